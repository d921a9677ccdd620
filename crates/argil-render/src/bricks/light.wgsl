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

// Returns the position of a material's sample in voxels.
fn material_place(nth: vec3<u32>) -> vec3<u32> {
    let steps = MATERIAL_SIDE - 1u;
    return (2u * nth * volume.brick_size_voxels + steps) / (2u * steps);
}

// GPU version of Bricks::material. The field provides what bricks do not store, in a pass of its own.
fn surface_material(p: vec3<f32>, outward: vec3<f32>) -> GpuMaterial {
    let at = locate(in_voxels(p));
    if !is_brick(at.word) {
        lacks_material = true;
        return materials[0];
    }
    let own = brick_materials[brick_number(at.word)];
    if (own & BRICK_MIXED) == 0u {
        return materials[min(own, arrayLength(&materials) - 1u)];
    }
    let steps = f32(MATERIAL_SIDE - 1u);
    let place = clamp(at.inner * (steps / f32(volume.brick_size_voxels)), vec3(0.0), vec3(steps));
    let begin = min(floor(place), vec3(steps - 1.0));
    let share = place - begin;
    let block = (own & ~BRICK_MIXED) * MATERIAL_SIDE * MATERIAL_SIDE * MATERIAL_SIDE;
    let per_voxel = volume.band_width / volume.voxel_size;
    var total = GpuMaterial(vec4(0.0), vec4(0.0));
    var sum = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let far = vec3(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let index = vec3<u32>(begin) + far;
        let sample = material_place(index);
        let d = textureLoad(stored, brick_origin(at.word) + sample, 0).x * per_voxel;
        let from_plane = clamp(dot(vec3<f32>(sample) - at.inner, outward), -per_voxel, per_voxel);
        let beside = max(1.0 - abs(d - from_plane), 0.0);
        let word = volume.capacity + 2u * (block + index.x + MATERIAL_SIDE * (index.y + MATERIAL_SIDE * index.z));
        let found = unpack_material(vec2(brick_materials[word], brick_materials[word + 1u]));
        let weights = select(1.0 - share, share, far != vec3(0u));
        let weight = weights.x * weights.y * weights.z * (MIN_WEIGHT + beside * beside);
        sum += weight;
        total.base_roughness += weight * found.base_roughness;
        total.emission_metallic += weight * found.emission_metallic;
    }
    return GpuMaterial(total.base_roughness / sum, total.emission_metallic / sum);
}
