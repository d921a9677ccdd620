// Materials that bricks store.

// Returns the position of a material's sample in voxels.
fn material_place(index: vec3<u32>) -> vec3<u32> {
    let steps = MATERIAL_SIDE - 1u;
    return (2u * index * volume.brick_size_voxels + steps) / (2u * steps);
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
