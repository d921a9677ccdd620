// GPU version of rays through levels: one ray per thread, from step to step.

// Returns a factor around 1 that differs from pixel to pixel.
fn dither(pixel: u32) -> f32 {
    var hash = pixel * 0x9e3779b9u;
    hash = (hash ^ (hash >> 15u)) * 0x85ebca6bu;
    return 1.0 + LEVEL_DITHER * (f32(hash >> 8u) * (1.0 / 16777216.0) - 0.5);
}

// Marches a pixel of a block. `cone_steps` are those of the block's cone, which one of its pixels has.
fn march_pixel(x: u32, y: u32, block_place: u32, cone_steps: u32, shows: bool) {
    let at_pixel = y * frame.width + x;
    let ray = primary_ray(x, y);
    let span = box_span(ray);
    let scale = frame.inv_lipschitz;
    // Positions are relative to the eye, where coordinates are most precise.
    let begin = select(vec3(0.0), ray.origin - frame.eye, PARALLEL_RAYS);
    let size = volume.pixel_error * frame.pixel_width;
    let own_size = size * dither(at_pixel);
    let d = vec3(not_zero(ray.direction.x), not_zero(ray.direction.y), not_zero(ray.direction.z));
    let ahead = select(vec3(0.0), vec3(8.0), d > vec3(0.0));
    var t = max(span.x, live.blocks[block_place].begin);
    var slot = 0u;
    var side = 0.0;
    var kind = HIT_NONE;
    var samples = 0u;
    var lookups = 0u;
    var last_cell = NO_PAGE;
    var exists = true;
    var normal = vec3(0.0);
    var hit_level = 0u;
    var hit_gap = 0.0;
    // Alternate between marching to the surface and solving there.
    while exists {
        var near = false;
        var motion = RayMotion(t, 0.0, 0.0, 0.0);
        var gap = 0.0;
        var found = LevelCell(0u, 0u, 0u, 0.0, 0u, NOTHING, 1.0, vec3(0.0));
        loop {
            if t > span.y || samples + lookups >= frame.max_steps {
                exists = false;
                break;
            }
            found = locate(begin + ray.direction * t, level_of(own_size * t), slot);
            slot = found.cell / 8u;
            hit_level = found.level;
            hit_gap = found.gap;
            let in_brick = is_brick(found.word);
            if found.cell != last_cell || found.gap > 0.0 {
                note(found);
            }
            lookups += u32(found.cell != last_cell);
            last_cell = found.cell;
            samples += u32(in_brick);
            let stored_d = level_distance(found);
            if side == 0.0 {
                side = select(1.0, -1.0, stored_d < 0.0 && span.x <= 0.0);
            }
            gap = stored_d * side;
            // In a page that is too coarse, the surface may be nearer than interpolated.
            let g = gap - select(0.0, volume.error_voxels * found.voxel, in_brick && found.gap > 0.0);
            // The spheres no longer touch: return to the end of the last one.
            let too_far = motion.over > 0.0 && g < motion.over;
            near = in_brick && !too_far && g < NEAR_VOXELS * found.voxel;
            if !in_brick && !too_far && g < 0.0 {
                kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
                exists = false;
            }
            if near || !exists {
                break;
            }
            let exits = (ahead - found.inner) * found.voxel / d;
            let leave = min(exits.x, min(exits.y, exits.z)) + NUDGE_VOXELS * found.voxel + NUDGE_RELATIVE * t;
            motion = advanced(motion, g, max(g * scale, leave), in_brick, too_far, span.y);
            t = motion.t;
        }
        if !near {
            break;
        }
        samples++;
        let close = frame.epsilon + select(0.0, volume.error_voxels * found.voxel, found.gap > 0.0);
        let intersection = intersect_voxel(ray, t, side, gap, found, close);
        let before = t;
        t = intersection.t;
        if intersection.is_hit {
            kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
            exists = false;
            found.inner = clamp(found.inner + ray.direction * ((t - before) / found.voxel), vec3(0.0), vec3(8.0));
            normal = level_normal(found, side);
            atomicAdd(&feedback[0], 1u);
            if found.gap > 0.0 && found.voxel > 2.0 * size * t {
                atomicAdd(&feedback[1], 1u);
            }
        }
    }
    // If all differences are equal, the normal faces the viewer.
    if all(normal == vec3(0.0)) {
        normal = -ray.direction;
    }
    if kind == HIT_NONE {
        normal = vec3(0.0);
        t = 0.0;
    }
    var seen = last_cell + 1u;
    let mode = per_thread(frame.mode, at_pixel);
    if mode == MODE_LEVELS {
        seen = 1u + hit_level + select(0u, LEVEL_MISSING, hit_gap > 0.0);
    }
    if mode == MODE_BRICKS && kind != HIT_NONE {
        let origin = bitcast<vec3<u32>>(page_origin(last_cell / 8u)) * vec3(0x8da6b343u, 0xd8163841u, 0xcb1ab31fu);
        seen = (origin.x ^ origin.y ^ origin.z ^ ((8u * hit_level + (last_cell & 7u)) * 0x9e3779b9u)) | 1u;
    }
    seen = select(seen, 0u, kind == HIT_NONE);
    let hit = Hit(vec4(normal, t), kind, samples + lookups + cone_steps, 0u, lookups, seen);
    end_march(at_pixel, ray, hit, normal, shows);
}
