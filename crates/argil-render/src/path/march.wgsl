// Marches the rays of paths: to a light, and then to the next surface.

// Fills in how far a ray goes, and where its march begins. Returns whether it meets the solids' box.
fn begin_march(index: u32, origin: vec3<f32>, direction: vec3<f32>, reach: f32) -> bool {
    let span = box_span(Ray(origin, direction));
    states[index].t = span.x;
    states[index].reach = min(reach, span.y);
    states[index].side = 0.0;
    states[index].steps = 0u;
    return span.x <= span.y && span.x <= reach;
}

// Begins the ray to the next surface.
fn begin_ray(index: u32) -> u32 {
    let origin = states[index].origin;
    let direction = states[index].direction;
    var reach = frame.far;
    if states[index].is_inside == 0u {
        reach = min(reach, ground_distance(origin, direction));
    }
    return select(PATH_MISSED, PATH_RAY, begin_march(index, origin, direction, reach));
}

// Adds light that passed some surfaces.
fn clamped(light: vec3<f32>) -> vec3<f32> {
    let most = max(light.x, max(light.y, light.z));
    // Also false for what is not a number.
    if !(most < UNLIMITED) {
        return vec3(0.0);
    }
    return light * select(1.0, paths.clamp / most, most > paths.clamp);
}

// What happens when a ray to a light ends.
fn end_shadow(index: u32, is_clear: bool) -> u32 {
    if is_clear {
        states[index].light += clamped(states[index].arrives);
    }
    if states[index].ends != 0u {
        return PATH_ENDED;
    }
    return begin_ray(index);
}

@compute @workgroup_size(64)
fn march_paths(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x;
    if index >= paths.pixel_count {
        return;
    }
    var phase = states[index].phase;
    let step_count = per_thread(paths.step_count, index);
    for (var step = 0u; step < step_count; step++) {
        if phase != PATH_SHADOW && phase != PATH_RAY {
            break;
        }
        let is_shadow = phase == PATH_SHADOW;
        let origin = select(states[index].origin, states[index].shadow_origin, is_shadow);
        let direction = select(states[index].direction, states[index].shadow_direction, is_shadow);
        let t = states[index].t;
        let found = scene_sample(origin + t * direction);
        if states[index].side == 0.0 {
            // A ray that enters the box through a clipped solid comes from outside.
            states[index].side = select(1.0, -1.0, found.x < 0.0 && t == 0.0);
        }
        let gap = states[index].side * found.x;
        let is_exact = found.y > 0.0;
        let is_met = is_exact && gap < max(paths.epsilon, 2.4e-7 * t);
        var free = gap * frame.inv_lipschitz;
        if !is_exact {
            // The sample proves that no surface is near, but not how far it is.
            free = max(free, paths.least_step);
        }
        states[index].steps++;
        let next = select(t + free, t, is_met);
        states[index].t = next;
        let is_over = next > states[index].reach || states[index].steps >= PATH_STEPS;
        if !is_met && !is_over {
            continue;
        }
        if is_shadow {
            phase = end_shadow(index, !is_met);
        } else {
            phase = select(PATH_MISSED, PATH_MET, is_met);
        }
    }
    states[index].phase = phase;
}
