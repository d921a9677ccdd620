// Distances in the air and materials of bricks, for lighting.

// GPU version of BrickSampler::at_center.
fn at_center(cell: vec3<i32>) -> f32 {
    let word = word_at(word_index(cell));
    let in_brick = is_brick(word);
    let stored_d = brick_distance(filter_origin(select(0u, word, in_brick)), vec3(f32(volume.brick_size_voxels / 2u)));
    return select(center_of(word), stored_d, in_brick);
}

// GPU version of BrickSampler::estimates: the best known distance at a point in the air.
fn light_distance(p: vec3<f32>) -> f32 {
    let own = in_voxels(p);
    let u = held_voxels(own);
    let beside = distance(own, u) * volume.voxel_size;
    let at = locate(u);
    let in_brick = is_brick(at.word);
    let stored_d = brick_distance(filter_origin(select(0u, at.word, in_brick)), at.inner);
    let has_levels = has_light_levels();
    if in_brick && (!has_levels || abs(stored_d) <= LIGHT_KNOWN * volume.band_width) {
        return stored_d + beside;
    }
    if has_levels {
        return light_beyond(volume.corner + u * volume.voxel_size) + beside;
    }
    let low = vec3<f32>(low_cell());
    let last = vec3<f32>(high_cell() - 1);
    let place = clamp(u * (1.0 / f32(volume.brick_size_voxels)) - 0.5, low, last);
    let begin = min(floor(place), max(last - 1.0, low));
    let share = place - begin;
    var total = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let far = vec3(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let weights = select(1.0 - share, share, far != vec3(0u));
        let cell = min(vec3<i32>(begin) + vec3<i32>(far), vec3<i32>(last));
        total += weights.x * weights.y * weights.z * at_center(cell);
    }
    return total + beside;
}

fn light_lift(length: f32) -> f32 {
    return frame.light_offset;
}

// Returns the shortest step of a shadow's ray.
fn light_step(length: f32) -> f32 {
    return 2.0 * frame.epsilon;
}
