// GPU version of shapes.rs, with the same names and the same order of operations. `w` is the index of a shape's
// first word.
//
// *Length.* One function per shape, as in shapes.rs, each as short as its definition.

fn length2(x: f32, y: f32) -> f32 {
    return sqrt(x * x + y * y);
}

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn length3(x: f32, y: f32, z: f32) -> f32 {
    return sqrt(x * x + y * y + z * z);
}

fn corner2(x: f32, y: f32) -> f32 {
    return min(max(x, y), 0.0) + length2(max(x, 0.0), max(y, 0.0));
}

fn corner3(x: f32, y: f32, z: f32) -> f32 {
    return min(max(x, max(y, z)), 0.0) + length3(max(x, 0.0), max(y, 0.0), max(z, 0.0));
}

fn sd_sphere(p: vec3<f32>, w: u32) -> f32 {
    return length3(p.x, p.y, p.z) - params[w];
}

fn sd_ellipsoid(p: vec3<f32>, w: u32) -> f32 {
    let scaled = (length3(p.x * params[w + 3u], p.y * params[w + 4u], p.z * params[w + 5u]) - 1.0) * params[w + 6u];
    let cuboid = corner3(abs(p.x) - params[w], abs(p.y) - params[w + 1u], abs(p.z) - params[w + 2u]);
    let ball = length3(p.x, p.y, p.z) - params[w + 7u];
    return max(scaled, max(cuboid, ball));
}

fn sd_box(p: vec3<f32>, w: u32) -> f32 {
    return corner3(abs(p.x) - params[w], abs(p.y) - params[w + 1u], abs(p.z) - params[w + 2u]) - params[w + 3u];
}

fn sd_box_frame(p: vec3<f32>, w: u32) -> f32 {
    let e = params[w + 3u];
    let q0 = abs(p) - vec3(params[w], params[w + 1u], params[w + 2u]);
    let q1 = abs(q0 + e) - e;
    return min(min(corner3(q0.x, q1.y, q1.z), corner3(q1.x, q0.y, q1.z)), corner3(q1.x, q1.y, q0.z));
}

fn sd_torus(p: vec3<f32>, w: u32) -> f32 {
    return length2(length2(p.x, p.z) - params[w], p.y) - params[w + 1u];
}

fn sd_capped_torus(p: vec3<f32>, w: u32) -> f32 {
    let sine = params[w];
    let cosine = params[w + 1u];
    let radius = params[w + 2u];
    let x = abs(p.x);
    let beyond = cosine * x > sine * p.y;
    let end = length3(x - sine * radius, p.y - cosine * radius, p.z);
    let ring = length2(length2(x, p.y) - radius, p.z);
    return select(ring, end, beyond) - params[w + 3u];
}

fn sd_link(p: vec3<f32>, w: u32) -> f32 {
    let y = max(abs(p.y) - params[w], 0.0);
    return length2(length2(p.x, y) - params[w + 1u], p.z) - params[w + 2u];
}

fn sd_capsule(p: vec3<f32>, w: u32) -> f32 {
    let q = p - vec3(params[w], params[w + 1u], params[w + 2u]);
    let axis = vec3(params[w + 3u], params[w + 4u], params[w + 5u]);
    let h = clamp((q.x * axis.x + q.y * axis.y + q.z * axis.z) * params[w + 6u], 0.0, 1.0);
    return length3(q.x - h * axis.x, q.y - h * axis.y, q.z - h * axis.z) - params[w + 7u];
}

fn sd_cylinder(p: vec3<f32>, w: u32) -> f32 {
    return corner2(length2(p.x, p.z) - params[w], abs(p.y) - params[w + 1u]) - params[w + 2u];
}

fn sd_cone(p: vec3<f32>, w: u32) -> f32 {
    let radius = params[w];
    let height = params[w + 1u];
    let q = length2(p.x, p.z);
    let side = clamp((q * radius - p.y * height) * params[w + 2u], 0.0, 1.0);
    let a = vec2(q - side * radius, p.y + side * height);
    let b = vec2(q - clamp(q, 0.0, radius), p.y + height);
    let d = sqrt(min(a.x * a.x + a.y * a.y, b.x * b.x + b.y * b.y));
    return signed_as(d, max(q * height + p.y * radius, -b.y));
}

fn sd_capped_cone(p: vec3<f32>, w: u32) -> f32 {
    let half_height = params[w];
    let top = params[w + 2u];
    let gain = params[w + 3u];
    let q = length2(p.x, p.z);
    let near = select(top, params[w + 1u], p.y < 0.0);
    let a = vec2(q - min(q, near), abs(p.y) - half_height);
    let u = vec2(top - q, half_height - p.y);
    let t = clamp((u.x * gain + u.y * (2.0 * half_height)) * params[w + 4u], 0.0, 1.0);
    let b = vec2(-u.x + t * gain, -u.y + t * (2.0 * half_height));
    let d = sqrt(min(a.x * a.x + a.y * a.y, b.x * b.x + b.y * b.y));
    return select(d, -d, b.x < 0.0 && a.y < 0.0);
}

fn sd_round_cone(p: vec3<f32>, w: u32) -> f32 {
    let height = params[w + 2u];
    let sine = params[w + 3u];
    let cosine = params[w + 4u];
    let q = length2(p.x, p.z);
    let k = p.y * cosine - q * sine;
    let bottom = length2(q, p.y) - params[w];
    let top = length2(q, p.y - height) - params[w + 1u];
    let side = q * cosine + p.y * sine - params[w];
    return select(select(side, top, k > cosine * height), bottom, k < 0.0);
}

fn sd_plane(p: vec3<f32>, w: u32) -> f32 {
    return p.x * params[w] + p.y * params[w + 1u] + p.z * params[w + 2u] - params[w + 3u];
}

fn sd_hex_prism(p: vec3<f32>, w: u32) -> f32 {
    let apothem = params[w];
    let q = abs(p.xy);
    let fold = min(q.x * -0.8660254 + q.y * 0.5, 0.0) * 2.0;
    let x = q.x + fold * 0.8660254;
    let y = q.y - fold * 0.5;
    let half_side = apothem * 0.57735026;
    let rise = y - apothem;
    let d = signed_as(length2(x - clamp(x, -half_side, half_side), rise), rise);
    return corner2(d, abs(p.z) - params[w + 1u]);
}

fn sd_tri_prism(p: vec3<f32>, w: u32) -> f32 {
    let half_side = params[w];
    let x = abs(p.x) - half_side;
    let y = p.y + half_side * 0.57735026;
    let folded = vec2((x - y * 1.7320508) * 0.5, (x * -1.7320508 - y) * 0.5);
    let q = select(vec2(x, y), folded, x + 1.7320508 * y > 0.0);
    let off = q.x - clamp(q.x, -2.0 * half_side, 0.0);
    return corner2(signed_as(length2(off, q.y), -q.y), abs(p.z) - params[w + 1u]);
}

fn sd_octahedron(p: vec3<f32>, w: u32) -> f32 {
    let s = params[w];
    let a = abs(p);
    let m = a.x + a.y + a.z - s;
    let first = 3.0 * a.x < m;
    let second = 3.0 * a.y < m;
    let third = 3.0 * a.z < m;
    let q = select(select(a.zxy, a.yzx, second), a, first);
    let k = clamp((q.z - q.y + s) * 0.5, 0.0, s);
    let edge = length3(q.x, q.y - s + k, q.z - k);
    return select(m * 0.57735026, edge, first || second || third);
}

fn sd_pyramid(p: vec3<f32>, w: u32) -> f32 {
    let half_base = params[w];
    let slope = params[w + 2u];
    let cosine = params[w + 3u];
    let sine = params[w + 4u];
    let q = abs(p.xz);
    let xz = select(q, q.yx, q.y > q.x);
    let x = xz.x;
    let z = xz.y;
    let below = length3(max(x - half_base, 0.0), p.y, max(z - half_base, 0.0));
    let ex = x - half_base;
    let out = ex * sine + p.y * cosine;
    let along = p.y * sine - ex * cosine;
    let t = clamp(along, 0.0, slope);
    let half_width = (slope - t) * (half_base / slope);
    let inner = length3(along - t, out, max(z - half_width, 0.0));
    let s = clamp((along * slope - (z - half_base) * half_base) * (1.0 / (slope * slope + half_base * half_base)), 0.0, 1.0);
    let edge = length3(along - s * slope, out, z - (half_base - s * half_base));
    let outside = select(inner, edge, z > half_width);
    let inside = max(out, -p.y);
    return select(select(outside, inside, inside <= 0.0), below, p.y < 0.0);
}

fn sd_cut_sphere(p: vec3<f32>, w: u32) -> f32 {
    let radius = params[w];
    let cut = params[w + 1u];
    let rim_radius = params[w + 2u];
    let q = length2(p.x, p.z);
    let s = max(
        q * q * (cut - radius) + (p.y * -2.0 + (cut + radius)) * (rim_radius * rim_radius),
        q * cut - p.y * rim_radius,
    );
    let ball = length2(q, p.y) - radius;
    let rim = length2(q - rim_radius, p.y - cut);
    return select(select(rim, cut - p.y, q < rim_radius), ball, s < 0.0);
}

fn sd_cut_hollow_sphere(p: vec3<f32>, w: u32) -> f32 {
    let cut = params[w + 1u];
    let rim_radius = params[w + 2u];
    let q = length2(p.x, p.z);
    let rim = length2(q - rim_radius, p.y - cut);
    let ball = abs(length2(q, p.y) - params[w]);
    return select(ball, rim, cut * q < rim_radius * p.y) - params[w + 3u];
}

fn sd_solid_angle(p: vec3<f32>, w: u32) -> f32 {
    let sine = params[w];
    let cosine = params[w + 1u];
    let q = length2(p.x, p.z);
    let ball = length2(q, p.y) - params[w + 2u];
    let t = clamp(q * sine + p.y * cosine, 0.0, params[w + 2u]);
    let side = signed_as(length2(q - t * sine, p.y - t * cosine), q * cosine - p.y * sine);
    return max(ball, side);
}

fn sd_rhombus(p: vec3<f32>, w: u32) -> f32 {
    let bx = params[w];
    let bz = params[w + 1u];
    let a = abs(p);
    let f = clamp(((bx - a.x * 2.0) * bx - (bz - a.z * 2.0) * bz) * params[w + 4u], -1.0, 1.0);
    let off = vec2(a.x - (1.0 - f) * (0.5 * bx), a.z - (f + 1.0) * (0.5 * bz));
    let side = a.x * bz + a.z * bx - bx * bz;
    return corner2(signed_as(length2(off.x, off.y), side) - params[w + 3u], a.y - params[w + 2u]);
}

fn sd_extruded_rounded_box(p: vec3<f32>, w: u32) -> f32 {
    let right = select(params[w + 4u], params[w + 3u], p.z > 0.0);
    let left = select(params[w + 6u], params[w + 5u], p.z > 0.0);
    let r = select(left, right, p.x > 0.0);
    let flat_distance = corner2(abs(p.x) - (params[w] - r), abs(p.z) - (params[w + 2u] - r)) - r;
    let rim = select(params[w + 8u], params[w + 7u], p.y > 0.0);
    return corner2(flat_distance + rim, abs(p.y) - (params[w + 1u] - rim)) - rim;
}

fn sheet_in_box(p: vec3<f32>, w: u32, level: f32) -> f32 {
    let sheet = abs(level) * params[w + 4u] - params[w + 5u];
    return max(sheet, corner3(abs(p.x) - params[w], abs(p.y) - params[w + 1u], abs(p.z) - params[w + 2u]));
}

// Returns sine and cosine of the angle along an axis, at the point of the box closest to a point.
fn sheet_angle(c: f32, half: f32, w: u32) -> vec2<f32> {
    return sin_cos(clamp(c, -half, half) * params[w + 3u]);
}

fn sd_gyroid(p: vec3<f32>, w: u32) -> f32 {
    let x = sheet_angle(p.x, params[w], w);
    let y = sheet_angle(p.y, params[w + 1u], w);
    let z = sheet_angle(p.z, params[w + 2u], w);
    return sheet_in_box(p, w, x.x * y.y + y.x * z.y + z.x * x.y);
}

fn sd_schwarz_p(p: vec3<f32>, w: u32) -> f32 {
    let x = sheet_angle(p.x, params[w], w);
    let y = sheet_angle(p.y, params[w + 1u], w);
    let z = sheet_angle(p.z, params[w + 2u], w);
    return sheet_in_box(p, w, x.y + y.y + z.y);
}

fn sd_superellipsoid(p: vec3<f32>, w: u32) -> f32 {
    let q = abs(p);
    let u = q.x * params[w + 3u];
    let v = q.y * params[w + 4u];
    let t = q.z * params[w + 5u];
    let most = max(max(u, max(v, t)), 1e-18);
    let level = power(u / most, params[w + 6u]) + power(t / most, params[w + 6u]);
    let whole = power(level, params[w + 7u] * params[w + 8u]) + power(v / most, params[w + 7u]);
    let norm = most * power(whole, params[w + 9u]);
    return max((norm - 1.0) * params[w + 10u], corner3(q.x - params[w], q.y - params[w + 1u], q.z - params[w + 2u]));
}
