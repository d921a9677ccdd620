// Shadows of lamps, before shade.wgsl adds their light. GPU version of `march` in lamps.rs.

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

// Marches to one lamp, whose number is the first step.
@compute @workgroup_size(8, 8)
fn lamp_shadow(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let hit = stored_hit(at);
    let ray = primary_ray(id.x, y);
    let length = hit.normal_t.w;
    let p = ray.origin + ray.direction * length;
    let lamp = lamp_at(frame.first_step, p);
    let origin = shadow_start(p, hit.normal_t.xyz, light_lift(length), lamp);
    var share = 0.0;
    if hit.kind != HIT_NONE && dot(hit.normal_t.xyz, lamp.direction) > 0.0 {
        share = lamp_share(origin, lamp, light_step(length));
    }
    colors[layer_at(1u + frame.first_step / 4u, at)][frame.first_step % 4u] = share;
}
