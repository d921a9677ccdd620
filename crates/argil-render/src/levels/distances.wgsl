// Distances in cells of levels.

fn sample_at(texel: vec3<u32>) -> f32 {
    return textureLoad(stored, texel, 0).x;
}

// Interpolates the distances of a brick, at a position in it. A filter would round by the brick's place in the pool,
// and an image would depend on the order in which bricks came.
fn brick_distance(word: u32, inner: vec3<f32>, voxel: f32) -> f32 {
    // A ray that leaves a brick can round to a little outside.
    let low = clamp(floor(inner), vec3(0.0), vec3(7.0));
    let part = inner - low;
    let at = 9u * vec3(word & 1023u, (word >> 10u) & 1023u, word >> 20u) + vec3<u32>(low);
    let x0 = mix(sample_at(at), sample_at(at + vec3(1u, 0u, 0u)), part.x);
    let x1 = mix(sample_at(at + vec3(0u, 1u, 0u)), sample_at(at + vec3(1u, 1u, 0u)), part.x);
    let x2 = mix(sample_at(at + vec3(0u, 0u, 1u)), sample_at(at + vec3(1u, 0u, 1u)), part.x);
    let x3 = mix(sample_at(at + vec3(0u, 1u, 1u)), sample_at(at + vec3(1u)), part.x);
    return mix(mix(x0, x1, part.y), mix(x2, x3, part.y), part.z) * (volume.band_voxels * voxel);
}

// GPU version of LevelSampler::empty_cell_distance: a signed lower bound, in a cell without a brick.
fn empty_distance(found: LevelCell) -> f32 {
    let center = center_of(found.word);
    let p = found.inner - 4.0;
    let way = volume.steepness * found.voxel * sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    let left = max(abs(center) - way, 1e-30);
    return select(left, -left, center < 0.0);
}

// Returns the distance at a cell's point.
fn level_distance(found: LevelCell) -> f32 {
    let in_brick = is_brick(found.word);
    return select(empty_distance(found), brick_distance(select(0u, found.word, in_brick), found.inner, found.voxel), in_brick);
}
