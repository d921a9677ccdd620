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
    let voxel = volume.voxel_size;
    let scale = frame.inv_lipschitz;
    let brick = f32(volume.brick_size_voxels);
    let low = vec3<f32>(low_cell());
    let last = vec3<f32>(high_cell() - 1);
    // A ray's position in cells at length t is u_begin + u_direction · t.
    let per_cell = 1.0 / (brick * voxel);
    let u_begin = (ray.origin - volume.corner) * per_cell;
    let u_direction = ray.direction * per_cell;
    let inv_direction = 1.0 / vec3(not_zero(u_direction.x), not_zero(u_direction.y), not_zero(u_direction.z));
    let side = select(1.0, -1.0, live.blocks[block_place].is_inside != 0u);
    var motion = RayMotion(max(span.x, live.blocks[block_place].begin), 0.0, 0.0, 0.0);
    var kind = HIT_NONE;
    var steps = 0u;
    var samples = 0u;
    var last_index = 0xffffffffu;
    var exists = true;
    // Alternate between marching to the surface and solving there: on some devices, code in a branch costs time in
    // every step.
    while exists {
        var near = false;
        var inner = vec3(0.0);
        var word = 0u;
        var g = 0.0;
        // From cell to cell.
        loop {
            exists = motion.t <= span.y && steps < frame.max_steps;
            if !exists {
                break;
            }
            let u = u_begin + u_direction * motion.t;
            let cell = clamp(floor(u), low, last);
            let place = vec3<i32>(cell);
            let index = word_index(place);
            word = word_at(index);
            steps += u32(index != last_index);
            last_index = index;
            let in_brick = is_brick(word);
            // The end of the cell, or of an empty block or larger empty cube. Slots without a block are those of empty cubes.
            let is_cube = HAS_LEVELS && index < FAR_SLOTS * 64u;
            let block = select(1u, BLOCK_SIDE, !in_brick && is_block_empty(word));
            let edge = i32(select(block, far_cells(select(0u, index / 64u, is_cube)), is_cube));
            let ahead = (place & vec3(-edge)) + select(vec3(0), vec3(edge), inv_direction > vec3(0.0));
            let exits = (vec3<f32>(ahead) - u) * inv_direction;
            let leave = min(exits.x, min(exits.y, exits.z));
            if in_brick {
                let inner_begin = u_begin - cell;
                let end = min(motion.t + leave, span.y);
                let texels = filter_origin(word) * volume.inv_pool_size;
                // From sample to sample of the brick.
                loop {
                    inner = saturate(inner_begin + u_direction * motion.t);
                    steps++;
                    samples++;
                    let uvw = inner * (brick * volume.inv_pool_size) + texels;
                    g = textureSampleLevel(stored, linear, uvw, 0.0).x * (volume.band_width * side);
                    // The spheres no longer touch: return to the end of the last one.
                    if motion.over > 0.0 && g < motion.over {
                        motion = RayMotion(motion.t - motion.over, 0.0, g, 0.0);
                        break;
                    }
                    near = g < NEAR_VOXELS * voxel;
                    if near {
                        break;
                    }
                    motion = relaxed(motion, g, scale, span.y);
                    if motion.t > end || steps >= frame.max_steps {
                        break;
                    }
                }
                if near {
                    break;
                }
            } else {
                g = away(word, saturate(u - cell) * brick) * side;
                let too_far = motion.over > 0.0 && g < motion.over;
                if g < 0.0 && !too_far {
                    kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
                    exists = false;
                    break;
                }
                let nudged = leave + NUDGE_VOXELS * voxel + NUDGE_RELATIVE * motion.t + nudge_for(u * brick);
                let way = select(max(g * scale, nudged), -motion.over, too_far);
                motion = RayMotion(motion.t + way, 0.0, g, 0.0);
            }
        }
        if !near {
            break;
        }
        steps++;
        samples++;
        let intersection = intersect_voxel(ray, motion.t, side, g, filter_origin(word), inner * brick);
        motion = RayMotion(intersection.t, 0.0, 0.0, 0.0);
        if intersection.is_hit {
            kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
            exists = false;
        }
    }
    let own_steps = select(0u, live.blocks[block_place].steps, local.x == 0u && local.y == 0u);
    if kind == HIT_NONE {
        hits[at_pixel] = Hit(vec4(0.0), kind, steps + own_steps, 1.0, 0.0, 0u, steps - samples, 0u, 0u);
        return;
    }
    let t = motion.t;
    var normal = brick_normal(ray.origin + ray.direction * t, select(1.0, -1.0, kind == HIT_INSIDE));
    // If all differences are equal, the normal faces the viewer.
    if all(normal == vec3(0.0)) {
        normal = -ray.direction;
    }
    let clip = clip_normal(ray, t);
    if kind == HIT_OUTSIDE && any(clip != vec3(0.0)) {
        normal = clip;
    }
    hits[at_pixel] = Hit(vec4(normal, t), kind, steps + own_steps, 1.0, 0.0, 0u, steps - samples, last_index + 1u, 0u);
}
