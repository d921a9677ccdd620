// GPU version of rays through levels: one ray per thread, from step to step.

// Where a ray ends.
struct LevelWalk {
    t: f32,
    kind: u32,
    samples: u32,
    lookups: u32,
    last_cell: u32,
    level: u32,
    gap: f32,
    // The edge of the voxel in which it hit, or 0.
    voxel: f32,
    normal: vec3<f32>,
}

// Marches a ray from a length to the end of its span, whose begin is 0 if the ray begins in the box. The ray begins at
// an offset from the eye, where coordinates are most precise. `own_size` is the edge of a voxel that it accepts at length 1.
fn walk_levels(direction: vec3<f32>, from_eye: vec3<f32>, begin: f32, span: vec2<f32>, own_size: f32) -> LevelWalk {
    let scale = frame.inv_lipschitz;
    let aside = length(from_eye);
    let d = vec3(not_zero(direction.x), not_zero(direction.y), not_zero(direction.z));
    let ahead = select(vec3(0.0), vec3(8.0), d > vec3(0.0));
    var walk = LevelWalk(begin, HIT_NONE, 0u, 0u, NO_PAGE, 0u, 0.0, 0.0, vec3(0.0));
    var slot = 0u;
    var side = 0.0;
    var exists = true;
    // Alternate between marching to the surface and solving there.
    while exists {
        var near = false;
        var motion = RayMotion(walk.t, 0.0, 0.0, 0.0);
        var gap = 0.0;
        var found = LevelCell(0u, 0u, 0u, 0.0, 0u, NOTHING, 1.0, vec3(0.0));
        loop {
            if walk.t > span.y || walk.samples + walk.lookups >= frame.max_steps {
                exists = false;
                break;
            }
            found = locate(from_eye + direction * walk.t, level_of(own_size * walk.t), slot);
            slot = found.cell / 8u;
            walk.level = found.level;
            walk.gap = found.gap;
            let in_brick = is_brick(found.word);
            if found.cell != walk.last_cell || found.gap > 0.0 {
                note(found);
            }
            walk.lookups += u32(found.cell != walk.last_cell);
            walk.last_cell = found.cell;
            walk.samples += u32(in_brick);
            let stored_d = level_distance(found);
            if side == 0.0 {
                side = select(1.0, -1.0, stored_d < 0.0 && span.x <= 0.0);
            }
            gap = stored_d * side;
            // In a page that is too coarse, the surface may be nearer than interpolated.
            let g = gap - select(0.0, doubt_of(found), in_brick);
            // The spheres no longer touch: return to the end of the last one.
            let too_far = motion.over > 0.0 && g < motion.over;
            near = in_brick && !too_far && g < NEAR_VOXELS * found.voxel;
            if !in_brick && !too_far && g < 0.0 {
                walk.kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
                exists = false;
            }
            if near || !exists {
                break;
            }
            let exits = (ahead - found.inner) * found.voxel / d;
            let nudge = NUDGE_VOXELS * found.voxel + NUDGE_RELATIVE * (walk.t + aside);
            let leave = min(exits.x, min(exits.y, exits.z)) + nudge;
            motion = advanced(motion, g, max(g * scale, leave), in_brick, too_far, span.y);
            walk.t = motion.t;
        }
        if !near {
            break;
        }
        walk.samples++;
        let close = frame.epsilon + doubt_of(found);
        let intersection = intersect_voxel(direction, walk.t, walk.t + aside, side, gap, found, close);
        let before = walk.t;
        walk.t = intersection.t;
        if intersection.is_hit {
            walk.kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
            exists = false;
            found.inner = clamp(found.inner + direction * ((walk.t - before) / found.voxel), vec3(0.0), vec3(8.0));
            walk.normal = level_normal(found, side);
            walk.voxel = found.voxel;
        }
    }
    // If all differences are equal, the normal faces the viewer.
    if all(walk.normal == vec3(0.0)) {
        walk.normal = -direction;
    }
    return walk;
}
