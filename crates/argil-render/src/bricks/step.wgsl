// GPU version of rays.rs and step.rs: one ray per thread, from step to step.

// One block of pixels per group: a block that its cone did not rule out.
@compute @workgroup_size(8, 8)
fn march(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let block_place = live.blocks[group.x].place;
    let blocks_across = (frame.width + CONE_SIDE - 1u) / CONE_SIDE;
    let x = block_place % blocks_across * CONE_SIDE + local.x;
    let y = block_place / blocks_across * CONE_SIDE + local.y;
    if x >= frame.width || y >= frame.height {
        return;
    }
    let at_pixel = y * frame.width + x;
    let ray = primary_ray(x, y);
    let span = box_span(ray);
    let begin = live.blocks[block_place].begin;
    let own_steps = select(0u, live.blocks[block_place].steps, local.x == 0u && local.y == 0u);
    let voxel = volume.voxel_size;
    let scale = frame.inv_lipschitz;
    let brick = f32(volume.brick_size_voxels);
    let held = held_box();
    let d = vec3(not_zero(ray.direction.x), not_zero(ray.direction.y), not_zero(ray.direction.z));
    let inv_direction = voxel / d;
    // A ray's position in voxels at length t is u_begin + u_way · t.
    let u_begin = in_voxels(ray.origin);
    let u_direction = ray.direction * (1.0 / voxel);
    var t = max(span.x, begin);
    var side = 0.0;
    var kind = HIT_NONE;
    var samples = 0u;
    var lookups = 0u;
    var last_index = 0xffffffffu;
    var exists = true;
    // Alternate between marching to the surface and solving there: on some devices, code in a branch costs time in
    // every step.
    while exists {
        var near = false;
        var motion = RayMotion(t, 0.0, 0.0, 0.0);
        var inner = vec3(0.0);
        var origin = vec3(0.0);
        var g = 0.0;
        loop {
            if t > span.y || samples + lookups >= frame.max_steps {
                exists = false;
                break;
            }
            let u = u_begin + u_direction * t;
            let cell = cell_of_held(clamp(u, held.begin, held.end), held);
            let index = word_index(vec3<i32>(cell));
            let word = word_at(index);
            let in_brick = is_brick(word);
            lookups += u32(index != last_index);
            last_index = index;
            samples += u32(in_brick);
            inner = clamp(u - cell * brick, vec3(0.0), vec3(brick));
            origin = filter_origin(select(0u, word, in_brick));
            let stored_d = select(away(word, inner), brick_distance(origin, inner), in_brick);
            if side == 0.0 {
                side = select(1.0, -1.0, stored_d < 0.0 && span.x <= 0.0);
            }
            g = stored_d * side;
            // The spheres no longer touch: return to the end of the last one.
            let too_far = motion.over > 0.0 && g < motion.over;
            near = in_brick && !too_far && g < NEAR_VOXELS * voxel;
            if !in_brick && !too_far && g < 0.0 {
                kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
                exists = false;
            }
            if near || !exists {
                break;
            }
            // Leave an empty cell, block, or larger empty cube. Slots without a block are those of empty cubes.
            let is_cube = HAS_LEVELS && index < FAR_SLOTS * 64u;
            let edge = select(1.0, f32(far_cells(select(0u, index / 64u, is_cube))), is_cube || is_block_empty(word));
            let first = floor(cell * (1.0 / edge)) * edge;
            let ahead = select(first, first + edge, d > vec3(0.0));
            let exits = (ahead * brick - u) * inv_direction;
            let leave = min(exits.x, min(exits.y, exits.z)) + NUDGE_VOXELS * voxel + NUDGE_RELATIVE * t + nudge_for(u);
            motion = advanced(motion, g, max(g * scale, leave), in_brick, too_far, span.y);
            t = motion.t;
        }
        if !near {
            break;
        }
        samples++;
        let intersection = intersect_voxel(ray, t, side, g, origin, inner);
        t = intersection.t;
        if intersection.is_hit {
            kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
            exists = false;
        }
    }
    var normal = brick_normal(ray.origin + ray.direction * t, select(1.0, -1.0, kind == HIT_INSIDE));
    // If all differences are equal, the normal faces the viewer.
    if all(normal == vec3(0.0)) {
        normal = -ray.direction;
    }
    let clip = clip_normal(ray, t);
    if kind == HIT_OUTSIDE && any(clip != vec3(0.0)) {
        normal = clip;
    }
    if kind == HIT_NONE {
        normal = vec3(0.0);
        t = 0.0;
    }
    let mark = select(last_index + 1u, 0u, kind == HIT_NONE);
    hits[at_pixel] = Hit(vec4(normal, t), kind, samples + lookups + own_steps, 1.0, 0.0, 0u, lookups, mark, 0u);
}
