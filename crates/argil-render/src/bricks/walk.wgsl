// GPU version of rays.rs and step.rs: one ray per thread, from step to step.

// Where a ray ends.
struct BrickWalk {
    t: f32,
    kind: u32,
    steps: u32,
    lookups: u32,
    last_index: u32,
    // The last cell, and its word.
    place: vec3<i32>,
    word: u32,
}

// Marches a ray between two lengths. `side` is -1 where it begins in the solid, and else 1.
fn walk_bricks(ray: Ray, begin: f32, end_of_ray: f32, side: f32) -> BrickWalk {
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
    var motion = RayMotion(begin, 0.0, 0.0, 0.0);
    var kind = HIT_NONE;
    var steps = 0u;
    var samples = 0u;
    // The cell of the last step, and what was loaded for it. No table has as many slots as it begins with.
    var last_place = vec3<i32>(-0x7fffffff);
    var slot = 0x3ffffffu;
    var word = 0u;
    var exists = true;
    // Alternate between marching to the surface and solving there: on some devices, code in a branch costs time in
    // every step.
    while exists {
        var near = false;
        var inner = vec3(0.0);
        var g = 0.0;
        // From cell to cell.
        loop {
            exists = motion.t <= end_of_ray && steps < frame.max_steps;
            if !exists {
                break;
            }
            let u = u_begin + u_direction * motion.t;
            let cell = clamp(floor(u), low, last);
            let place = vec3<i32>(cell);
            if any(place != last_place) {
                // Computed again, it takes no register in other steps.
                let last_index = index_in(slot, last_place);
                if any(((place ^ last_place) >> vec3(2u)) != vec3(0)) {
                    slot = slot_of(place >> vec3(2u));
                }
                let index = index_in(slot, place);
                word = word_at(index);
                steps += u32(index != last_index);
                last_place = place;
            }
            let in_brick = is_brick(word);
            // The end of the cell, or of an empty block or larger empty cube. Slots without a block are those of empty cubes.
            let is_cube = HAS_LEVELS && slot < FAR_SLOTS;
            let block = select(1u, BLOCK_SIDE, !in_brick && is_block_empty(word));
            let edge = i32(select(block, far_cells(select(0u, slot, is_cube)), is_cube));
            let ahead = (place & vec3(-edge)) + select(vec3(0), vec3(edge), inv_direction > vec3(0.0));
            let exits = (vec3<f32>(ahead) - u) * inv_direction;
            let leave = min(exits.x, min(exits.y, exits.z));
            if in_brick {
                let inner_begin = u_begin - cell;
                let end = min(motion.t + leave, end_of_ray);
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
                    motion = relaxed(motion, g, scale, end_of_ray);
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
    return BrickWalk(motion.t, kind, steps, steps - samples, index_in(slot, last_place), last_place, word);
}

// Returns the normal where a ray hit.
fn walked_normal(ray: Ray, walk: BrickWalk) -> vec3<f32> {
    let clip = clip_normal(ray, walk.t);
    if walk.kind == HIT_OUTSIDE && any(clip != vec3(0.0)) {
        return clip;
    }
    let u = in_voxels(ray.origin + ray.direction * walk.t);
    let cell = cell_of_voxels(u);
    var word = walk.word;
    // Rounded, the point may be in the next cell.
    if any(vec3<i32>(cell) != walk.place) {
        word = word_at(word_index(vec3<i32>(cell)));
    }
    let at = CellLocations(cell, inner_of(u, cell), word);
    let normal = brick_normal(at, select(1.0, -1.0, walk.kind == HIT_INSIDE));
    // If all differences are equal, the normal faces the viewer.
    return select(normal, -ray.direction, all(normal == vec3(0.0)));
}
