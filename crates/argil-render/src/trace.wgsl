// GPU version of trace.rs, one pixel per thread.

fn surface_normal(hit: Hit, ray: Ray) -> vec3<f32> {
    return field_normal(ray.origin + ray.direction * hit.normal_t.w, select(1.0, -1.0, hit.kind == HIT_INSIDE));
}

// Marches until the ray hits, leaves the box, or has used its steps or those of this dispatch. Between dispatches,
// the x of the normal stores the ray's side.
@compute @workgroup_size(8, 8)
fn march(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let ray = primary_ray(id.x, y);
    let epsilon = frame.epsilon;
    let span = box_span(ray);
    var t = span.x;
    var side = 0.0;
    var steps = 0u;
    var kind = select(HIT_NONE, HIT_PENDING, span.x <= span.y);
    if frame.first_step > 0u {
        let hit = hits[at];
        t = hit.normal_t.w;
        side = hit.normal_t.x;
        steps = hit.steps;
        kind = hit.kind;
    }
    for (var i = 0u; i < frame.step_count; i++) {
        if kind != HIT_PENDING {
            break;
        }
        let d = field_distance(ray.origin + ray.direction * t);
        steps++;
        if side == 0.0 {
            side = select(1.0, -1.0, d < 0.0);
        }
        let gap = d * side;
        let spent = steps >= frame.max_steps;
        let reached = gap < epsilon || (spent && gap < frame.pixel_width * t);
        t += gap * frame.inv_lipschitz;
        if reached {
            kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
        } else if spent || t > span.y {
            kind = HIT_NONE;
        }
    }
    hits[at] = Hit(vec4(side, 0.0, 0.0, t), kind, steps, 0.0, 0.0, 0u, 0u, 0u, 0u);
}
