// GPU version of trace.rs, one pixel per thread.

fn surface_normal(hit: Hit, ray: Ray) -> vec3<f32> {
    return field_normal(ray.origin + ray.direction * hit.normal_t.w, select(1.0, -1.0, hit.kind == HIT_INSIDE));
}

// Marches until the ray hits, leaves the box, or has used its steps or those of this dispatch. Between dispatches,
// a hit stores the ray's state: its side, the normal's x; what it went beyond its sphere, y; the last distance, z; and how far it
// went with that, the sun's share.
@compute @workgroup_size(8, 8)
fn march(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let ray = primary_ray(id.x, y);
    let span = box_span(ray);
    var hit = Hit(vec4(0.0, 0.0, 0.0, span.x), select(HIT_NONE, HIT_PENDING, span.x <= span.y), 0u, 0.0, 0.0, 0u, 0u, 0u, 0u);
    if per_thread(frame.first_step, at) > 0u {
        hit = hits[at];
    }
    var side = hit.normal_t.x;
    var over = hit.normal_t.y;
    var last_gap = hit.normal_t.z;
    var last_way = hit.sun_share;
    var t = hit.normal_t.w;
    var steps = hit.steps;
    var kind = hit.kind;
    let step_count = per_thread(frame.step_count, at);
    for (var i = 0u; i < step_count; i++) {
        if kind != HIT_PENDING {
            break;
        }
        let d = field_distance(ray.origin + ray.direction * t);
        steps++;
        if side == 0.0 {
            side = select(1.0, -1.0, d < 0.0);
        }
        let gap = d * side;
        let way = gap * frame.inv_lipschitz;
        let spent = steps >= frame.max_steps;
        // The spheres no longer touch: return to the end of the last one.
        let is_too_far = over > 0.0 && way < over;
        let close = max(frame.epsilon, select(0.0, frame.close_slope, steps > EXACT_STEPS) * t);
        let reached = !is_too_far && (gap < close || (spent && gap < frame.pixel_width * t));
        // Along a plane, spheres still touch with this additional distance between their centers.
        let fell = max(last_gap - gap, 0.0);
        let sum = last_way + fell;
        var more = RELAXATION * way * max((last_way - fell) / select(1.0, sum, sum > 0.0), 0.0);
        // Beyond the box, nothing would tell whether they do.
        if is_too_far || t + way + more > span.y {
            more = 0.0;
        }
        let moved = select(way + more, -over, is_too_far);
        t += select(moved, way, reached);
        if reached {
            kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
        } else if spent || t > span.y {
            kind = HIT_NONE;
        }
        over = more;
        last_gap = gap;
        last_way = select(moved, 0.0, is_too_far);
    }
    hits[at] = Hit(vec4(side, over, last_gap, t), kind, steps, last_way, 0.0, 0u, 0u, 0u, 0u);
}
