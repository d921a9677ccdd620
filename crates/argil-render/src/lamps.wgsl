// GPU version of lamps.rs.
//
// *Length.* What lamps bring is one thing, which shade.wgsl and the passes before it read.

struct LampLight {
    direction: vec3<f32>,
    distance: f32,
    light: vec3<f32>,
    sharpness: f32,
}

fn soft(sharpness: f32) -> f32 {
    return clamp(sharpness, 3.0, 200.0);
}

// Returns what a lamp brings to a point in fog.
fn lamp_at(index: u32, p: vec3<f32>) -> LampLight {
    return lamp_above(index, p, vec3(0.0));
}

// Returns what a lamp brings to a surface. What is below its horizon does not shine on it.
fn lamp_above(index: u32, p: vec3<f32>, n: vec3<f32>) -> LampLight {
    let place = frame.lamps[4u * index];
    let light = frame.lamps[4u * index + 1u];
    let first = frame.lamps[4u * index + 2u];
    let second = frame.lamps[4u * index + 3u];
    let kind = u32(place.w);
    if kind == LIGHT_SUN {
        let sine = sqrt(max(1.0 - first.x * first.x, 1e-12));
        return LampLight(place.xyz, UNLIMITED, light.xyz, soft(first.x / sine));
    }
    let to = place.xyz - p;
    let square = max(dot(to, to), 1e-12);
    let distance = sqrt(square);
    let direction = to / distance;
    if kind == LIGHT_SPHERE {
        let share = cone_share(first, second.x, -direction);
        let above = sphere_above(n, direction, light.w * light.w / square);
        let own = light.xyz * (share * above.w / square);
        return LampLight(above.xyz, distance, own, soft(distance / max(light.w, 1e-6)));
    }
    let flow = rectangle_flow(to, first.xyz * first.w, second.xyz * second.w, n);
    let size = length(flow);
    let own = select(direction, flow / max(size, 1e-30), size > 0.0);
    return LampLight(own, distance, light.xyz * size, soft(distance / max(0.5 * (first.w + second.w), 1e-6)));
}

// Returns the direction from which a sphere shines on a surface, and what that receives from there, relative to a point of light.
fn sphere_above(n: vec3<f32>, direction: vec3<f32>, size: f32) -> vec4<f32> {
    let cosine = dot(n, direction);
    let sine = sqrt(size);
    // Nothing shines inward.
    if size >= 1.0 {
        return vec4(direction, 0.0);
    }
    if all(n == vec3(0.0)) || cosine >= sine {
        return vec4(direction, 1.0);
    }
    if cosine <= -sine {
        return vec4(direction, 0.0);
    }
    let toward = normalize(direction + 0.5 * (sine - cosine) * n);
    let facing = max(dot(n, toward), 1e-6);
    if size < 1e-3 {
        // A flat disc.
        let t = cosine / sine;
        let own = t * (0.5 * PI + asin(t)) + sqrt(1.0 - t * t) * (2.0 + t * t) / 3.0;
        return vec4(toward, sine * max(own, 0.0) / PI / facing);
    }
    let side = sqrt(max(1.0 - cosine * cosine, 1e-12));
    let x = sqrt(max(1.0 / size - 1.0, 1e-12));
    let y = clamp(-x * cosine / side, -1.0, 1.0);
    let across = side * sqrt(1.0 - y * y);
    let received = (cosine * acos(y) - x * across) * size + atan(across / x);
    return vec4(toward, max(received, 0.0) / (PI * size) / facing);
}

// Returns the direction from which a rectangle shines on average, times what a surface receives that faces it.
fn rectangle_flow(to: vec3<f32>, width: vec3<f32>, height: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    var sum = vec3(0.0);
    if dot(to, cross(width, height)) >= 0.0 {
        return sum;
    }
    // Where the outline goes below the horizon, and where it comes back.
    var leaves = vec3(0.0);
    var returns = vec3(0.0);
    var a = to - width - height;
    for (var index = 0u; index < 4u; index++) {
        let next = vec2(select(-1.0, 1.0, index == 1u || index == 2u), select(-1.0, 1.0, index < 2u));
        let b = to + next.x * width + next.y * height;
        let above = vec2(dot(n, a), dot(n, b));
        if above.x >= 0.0 || above.y >= 0.0 {
            let cut = a + (b - a) * (above.x / (above.x - above.y));
            if above.x < 0.0 {
                returns = cut;
            } else if above.y < 0.0 {
                leaves = cut;
            }
            sum += flow_of_side(select(a, cut, above.x < 0.0), select(b, cut, above.y < 0.0));
        }
        a = b;
    }
    return sum + flow_of_side(leaves, returns);
}

fn flow_of_side(start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {
    let a = direction_or_zero(start);
    let b = direction_or_zero(end);
    let across = cross(a, b);
    let sine = length(across);
    // Narrow sides are as long as their angle.
    let ratio = select(1.0, atan2(sine, dot(a, b)) / max(sine, 1e-30), sine > 1e-4);
    return 0.5 * ratio * across;
}

// Returns the light of the first lamps that a ray meets within a length. Fog dims them.
fn lamps_seen(ray: Ray, reach: f32, lamp_count: u32) -> vec3<f32> {
    var sum = vec3(0.0);
    for (var index = 0u; index < lamp_count; index++) {
        let place = frame.lamps[4u * index];
        let light = frame.lamps[4u * index + 1u];
        let first = frame.lamps[4u * index + 2u];
        let second = frame.lamps[4u * index + 3u];
        let to = place.xyz - ray.origin;
        let kind = u32(place.w);
        var met = -1.0;
        var own = light.xyz;
        if kind == LIGHT_SPHERE && light.w >= 1e-5 {
            let along = dot(to, ray.direction);
            let beside = to - along * ray.direction;
            let inside = light.w * light.w - dot(beside, beside);
            met = select(-1.0, along - sqrt(max(inside, 0.0)), inside > 0.0);
            own *= cone_share(first, second.x, -ray.direction) / max(PI * light.w * light.w, 1e-20);
        } else if kind == LIGHT_RECTANGLE {
            let out = cross(first.xyz, second.xyz);
            let facing = dot(out, ray.direction);
            let length = dot(out, to) / min(facing, -1e-20);
            let p = length * ray.direction - to;
            let is_in = abs(dot(p, first.xyz)) < first.w && abs(dot(p, second.xyz)) < second.w;
            met = select(-1.0, length, facing < 0.0 && is_in);
        }
        if met > near_length(ray) && met < reach {
            sum += own * fog_transmitted(ray.origin, ray.direction, min(frame.far, met));
        }
    }
    return sum;
}

// Returns the index of a pixel in a layer of the colors.
fn layer_at(layer: u32, at: u32) -> u32 {
    return layer * frame.width * frame.height + at;
}
