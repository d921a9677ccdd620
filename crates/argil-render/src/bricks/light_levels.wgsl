// GPU version of lit.rs: distances that bricks do not store, from coarse levels, whose tables are a texture of words.

fn light_word(at: u32) -> u32 {
    return textureLoad(light_words, vec2(at % LIGHT_ROW, at / LIGHT_ROW), 0).x;
}

fn light_place(at: u32) -> vec3<i32> {
    return bitcast<vec3<i32>>(vec3(light_word(at), light_word(at + 1u), light_word(at + 2u)));
}

fn has_light_levels() -> bool {
    return light_word(0u) != 0u;
}

// Returns the distance at a point: from the finest level that has a brick there.
fn light_beyond(p: vec3<f32>) -> f32 {
    let voxel = bitcast<f32>(light_word(2u));
    let u = (p - volume.corner) * (1.0 / voxel);
    let whole = clamp(vec3<i32>(floor(clamp(u, vec3(-1e9), vec3(1e9)))), light_place(10u), light_place(13u));
    var level = light_word(1u);
    let size = light_place(7u);
    let root = clamp((whole >> vec3(PAGE_VOXELS_LOG2 + level)) - light_place(4u), vec3(0), size - 1);
    var slot = light_word(LIGHT_HEAD + u32(root.x + size.x * (root.y + size.y * root.z)));
    let records = light_word(16u);
    var found = MISSING_BRICK;
    var found_level = level;
    var center = 0.0;
    loop {
        let half = vec3<u32>((whole >> vec3(level + PAGE_VOXELS_LOG2 - 1u)) & vec3(1));
        let at = records + RECORD_WORDS * slot + 8u + (half.x | (half.y << 1u) | (half.z << 2u));
        let word = light_word(at);
        if !is_brick(word) {
            center = center_of(word);
            break;
        }
        if word != MISSING_BRICK {
            found = word;
            found_level = level;
        }
        let child = light_word(at + 8u);
        if level == 0u || child >= UNKNOWN_CELL {
            break;
        }
        slot = child;
        level--;
    }
    if found == MISSING_BRICK {
        return center;
    }
    let scale = f32(1u << found_level);
    let cell = vec3<f32>(whole >> vec3(found_level + 3u));
    let inner = clamp(u * (1.0 / scale) - 8.0 * cell, vec3(0.0), vec3(8.0));
    let origin = 9u * vec3(found & 1023u, (found >> 10u) & 1023u, found >> 20u);
    let uvw = (vec3<f32>(origin) + 0.5 + inner) / vec3<f32>(textureDimensions(light_stored));
    return textureSampleLevel(light_stored, linear, uvw, 0.0).x * (bitcast<f32>(light_word(3u)) * voxel * scale);
}
