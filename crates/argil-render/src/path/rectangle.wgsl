// GPU version of RectangleLight in emitters.rs.

// Half of the width and of the height, with unit vectors along both.
struct Rectangle {
    center: vec3<f32>,
    half_width: f32,
    width: vec3<f32>,
    half_height: f32,
    height: vec3<f32>,
    area: f32,
    out: vec3<f32>,
}

fn rectangle_of(index: u32) -> Rectangle {
    let width = light_row(index, 2u);
    let height = light_row(index, 3u);
    let area = 4.0 * width.w * height.w;
    let out = cross(width.xyz, height.xyz);
    return Rectangle(light_row(index, 0u).xyz, width.w, width.xyz, height.w, height.xyz, area, out);
}

fn rectangle_importance(index: u32, p: vec3<f32>) -> f32 {
    let own = rectangle_of(index);
    let to = p - own.center;
    let above = dot(to, own.out);
    if above <= 0.0 {
        return 0.0;
    }
    let square = max(dot(to, to), 1e-12);
    let cosine = above / sqrt(square);
    return dot(light_row(index, 1u).xyz, vec3(1.0)) * min(own.area * (0.1 + 0.9 * cosine) / square, PI);
}

fn rectangle_point(index: u32, own: Rectangle, direction: vec3<f32>, distance: f32, cosine: f32) -> EmitterPoint {
    return EmitterPoint(direction, distance, light_row(index, 1u).xyz, distance * distance / (own.area * cosine));
}

fn rectangle_sample(index: u32, p: vec3<f32>, point: vec2<f32>) -> EmitterPoint {
    let own = rectangle_of(index);
    let place = 2.0 * point - 1.0;
    let to = own.center + place.x * own.half_width * own.width + place.y * own.half_height * own.height - p;
    let direction = direction_or_zero(to);
    let cosine = -dot(direction, own.out);
    if cosine <= 1e-6 {
        return no_emitter();
    }
    return rectangle_point(index, own, direction, length(to), cosine);
}

fn rectangle_met(index: u32, origin: vec3<f32>, direction: vec3<f32>) -> EmitterPoint {
    let own = rectangle_of(index);
    let cosine = -dot(direction, own.out);
    if cosine <= 1e-6 {
        return no_emitter();
    }
    let distance = dot(origin - own.center, own.out) / cosine;
    let from_center = origin + distance * direction - own.center;
    let is_in = abs(dot(from_center, own.width)) <= own.half_width && abs(dot(from_center, own.height)) <= own.half_height;
    if distance <= 0.0 || !is_in {
        return no_emitter();
    }
    return rectangle_point(index, own, direction, distance, cosine);
}
