// GPU version of lamps.rs.

struct LampLight {
    direction: vec3<f32>,
    distance: f32,
    light: vec3<f32>,
    sharpness: f32,
}

fn soft(sharpness: f32) -> f32 {
    return clamp(sharpness, 3.0, 200.0);
}

// Returns what a lamp brings to a point.
fn lamp_at(nth: u32, p: vec3<f32>) -> LampLight {
    let place = frame.lamps[4u * nth];
    let light = frame.lamps[4u * nth + 1u];
    let first = frame.lamps[4u * nth + 2u];
    let second = frame.lamps[4u * nth + 3u];
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
        let own = light.xyz * (share / max(square, light.w * light.w));
        return LampLight(direction, distance, own, soft(distance / max(light.w, 1e-6)));
    }
    let flow = rectangle_flow(to, first.xyz * first.w, second.xyz * second.w);
    let size = length(flow);
    let own = select(direction, flow / max(size, 1e-30), size > 0.0);
    return LampLight(own, distance, light.xyz * size, soft(distance / max(0.5 * (first.w + second.w), 1e-6)));
}

// Returns the direction from which a rectangle shines on average, times what a surface receives that faces it.
fn rectangle_flow(to: vec3<f32>, width: vec3<f32>, height: vec3<f32>) -> vec3<f32> {
    var sum = vec3(0.0);
    if dot(to, cross(width, height)) >= 0.0 {
        return sum;
    }
    var a = direction_or_zero(to - width - height);
    for (var nth = 0u; nth < 4u; nth++) {
        let next = vec2(select(-1.0, 1.0, nth == 1u || nth == 2u), select(-1.0, 1.0, nth < 2u));
        let b = direction_or_zero(to + next.x * width + next.y * height);
        let across = cross(a, b);
        let sine = length(across);
        // Narrow sides are as long as their angle.
        let ratio = select(1.0, atan2(sine, dot(a, b)) / max(sine, 1e-30), sine > 1e-4);
        sum += 0.5 * ratio * across;
        a = b;
    }
    return sum;
}

// Returns where a lamp's shadow begins that is seen from a surface: above it, but not beyond the lamp.
fn shadow_start(p: vec3<f32>, n: vec3<f32>, lift: f32, lamp: LampLight) -> vec3<f32> {
    return p + n * min(lift, 0.05 * lamp.distance);
}

// Returns the index of a pixel in a layer of the colors.
fn layer_at(layer: u32, at: u32) -> u32 {
    return layer * frame.width * frame.height + at;
}
