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
    let cosine = max(-dot(direction, cross(first.xyz, second.xyz)), 0.0);
    let angle = min(4.0 * first.w * second.w * cosine / square, PI);
    return LampLight(direction, distance, light.xyz * angle, soft(distance / max(0.5 * (first.w + second.w), 1e-6)));
}

// Returns the index of a pixel in a layer of the colors.
fn layer_at(layer: u32, at: u32) -> u32 {
    return layer * frame.width * frame.height + at;
}
