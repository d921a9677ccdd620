// GPU version of light.rs: distances in the air and materials of levels, for lighting.

var<private> light_slot: u32 = 0u;

// GPU version of LevelSampler::locate_bricks.
fn locate_brick(p: vec3<f32>, voxels: f32) -> LevelCell {
    let away = p - frame.eye;
    let wanted = level_of(voxels * volume.pixel_error * frame.pixel_width * length(away));
    var found = locate(away, wanted, light_slot);
    light_slot = found.cell / 8u;
    let above = page_parent(light_slot);
    if is_brick(found.word) || above == NO_PAGE {
        return found;
    }
    found.cell = above;
    if cell_word(above) == MISSING_BRICK {
        found.lacks = above;
        found.lacks_child = OWN_BRICK;
        found.cell = resident_above(above);
    }
    found.word = cell_word(found.cell);
    found.level = page_level(found.cell / 8u);
    found.voxel = volume.voxel_size * level_scale(found.level);
    return placed(found, volume.eye_inner + away * (1.0 / volume.voxel_size));
}

fn light_distance(p: vec3<f32>) -> f32 {
    let found = locate_brick(p, LIGHT_VOXELS);
    note(found);
    let in_brick = is_brick(found.word);
    let d = brick_distance(select(0u, found.word, in_brick), found.inner, found.voxel);
    return select(center_of(found.word), d, in_brick);
}

fn light_lift(length: f32) -> f32 {
    return max(frame.light_offset, LIFT_VOXELS * volume.pixel_error * frame.pixel_width * length);
}

fn light_step(length: f32) -> f32 {
    return max(2.0 * frame.epsilon, MIN_STEP_VOXELS * LIGHT_VOXELS * volume.pixel_error * frame.pixel_width * length);
}

// GPU version of LevelSampler::material. The field provides what bricks do not store, in a pass of its own.
fn surface_material(p: vec3<f32>, outward: vec3<f32>) -> GpuMaterial {
    let found = locate_brick(p, 1.0);
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
