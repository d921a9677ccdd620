// Materials that bricks of levels store.

// Returns the material at a cell's point.
fn brick_material(found: LevelCell, outward: vec3<f32>) -> GpuMaterial {
    if !is_brick(found.word) {
        lacks_material = true;
        return materials[0];
    }
    let own = cells[volume.materials_at + brick_number(found.word)];
    if (own & BRICK_MIXED) == 0u {
        return materials[min(own, arrayLength(&materials) - 1u)];
    }
    let block = volume.mixed_at + 2u * (own & ~BRICK_MIXED) * MATERIAL_SIDE * MATERIAL_SIDE * MATERIAL_SIDE;
    let steps = MATERIAL_SIDE - 1u;
    let place = clamp(found.inner * (f32(steps) / 8.0), vec3(0.0), vec3(f32(steps)));
    let begin = min(floor(place), vec3(f32(steps) - 1.0));
    let share = place - begin;
    let origin = 9u * vec3(found.word & 1023u, (found.word >> 10u) & 1023u, found.word >> 20u);
    var total = GpuMaterial(vec4(0.0), vec4(0.0));
    var sum = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let far = vec3(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let index = vec3<u32>(begin) + far;
        let sample = (16u * index + steps) / (2u * steps);
        let d = textureLoad(stored, origin + sample, 0).x * volume.band_voxels;
        let from_plane = clamp(dot(vec3<f32>(sample) - found.inner, outward), -volume.band_voxels, volume.band_voxels);
        let beside = max(1.0 - abs(d - from_plane), 0.0);
        let word = block + 2u * (index.x + MATERIAL_SIDE * (index.y + MATERIAL_SIDE * index.z));
        let stored_material = unpack_material(vec2(cells[word], cells[word + 1u]));
        let weights = select(1.0 - share, share, far != vec3(0u));
        let weight = weights.x * weights.y * weights.z * (MIN_WEIGHT + beside * beside);
        sum += weight;
        total.base_roughness += weight * stored_material.base_roughness;
        total.emission_metallic += weight * stored_material.emission_metallic;
    }
    return GpuMaterial(total.base_roughness / sum, total.emission_metallic / sum);
}
