// Shadows of lamps in fog. GPU version of lamp_rays.rs.

// Returns how much of a lamp a point sees.
fn lamp_share(origin: vec3<f32>, lamp: LampLight, least: f32) -> f32 {
    let span = box_span(Ray(origin, lamp.direction));
    var t = span.x;
    var end = min(span.y, lamp.distance);
    var share = 1.0;
    for (var step = 0u; step < LAMP_STEPS; step++) {
        if t >= end {
            break;
        }
        let d = light_distance(origin + lamp.direction * t);
        let own = clamp(lamp.sharpness * d / max(t, frame.epsilon), 0.0, 1.0);
        share = min(share, own);
        t += max(d * frame.inv_lipschitz, least);
        if own <= 0.005 {
            end = -1.0;
        }
    }
    return share * share * (3.0 - 2.0 * share);
}
