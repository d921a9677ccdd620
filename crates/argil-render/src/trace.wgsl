// GPU version of trace.rs, one pixel per thread.

fn surface_normal(hit: Hit, ray: Ray) -> vec3<f32> {
    return field_normal(ray.origin + ray.direction * hit.normal_t.w, select(1.0, -1.0, hit.kind == HIT_INSIDE));
}

// What a ray that goes on in the next dispatch has in its first record: what it went beyond its sphere, the last distance, how far
// it went with that, and its length. In the second record are its steps, its kind and its side.
@compute @workgroup_size(8, 8)
fn march(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let ray = primary_ray(id.x, y);
    let span = primary_span(ray);
    var state = vec4(0.0, 0.0, 0.0, span.x);
    var counts = vec4(0u, select(HIT_NONE, HIT_PENDING, span.x <= span.y), 0u, 0u);
    if per_thread(frame.first_step, at) > 0u {
        state = bitcast<vec4<f32>>(hits[at]);
        counts = hits[counts_at(at)];
    }
    var over = state.x;
    var last_gap = state.y;
    var last_way = state.z;
    var t = state.w;
    var steps = counts.x;
    var kind = counts.y;
    var side = bitcast<f32>(counts.z);
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
    if per_thread(frame.first_step, at) + step_count < frame.max_steps {
        hits[at] = bitcast<vec4<u32>>(vec4(over, last_gap, last_way, t));
        hits[counts_at(at)] = vec4(steps, kind, bitcast<u32>(side), 0u);
    } else {
        store_hit(at, Hit(vec4(0.0, 0.0, 0.0, t), kind, steps, 0u, 0u, 0u));
    }
}
