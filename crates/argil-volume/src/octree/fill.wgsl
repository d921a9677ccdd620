// GPU version of fill.rs, with the tiles of fill.wgsl in the crate's root.

// One brick per group.
@compute @workgroup_size(TILE_SIDE, TILE_SIDE)
fn fill_bricks(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let brick = id.y * DISPATCH_ROW + id.x;
    if brick >= tree_words[OCTREE_HEADER_BRICKS] {
        return;
    }
    fill_tile(cell_of(keys[brick]) * fill.tile, local);
}

// One cell per group: without a brick, all its texels store a common lower bound on the distance.
@compute @workgroup_size(TILE_SIDE, TILE_SIDE)
fn fill_vacant(@builtin(workgroup_id) cell: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let away = centers[morton(cell)];
    if abs(away) <= volume.max_center_distance {
        return;
    }
    let magnitude = max(floor(min((abs(away) - volume.sample_margin) * fill.spacing_scale.w, f32(fill.max_code))), 1.0);
    let integer = select(magnitude, -magnitude, away < 0.0);
    let stored = vec4(integer / f32(fill.max_code), 0.0, 0.0, 0.0);
    let corner = cell * fill.tile;
    for (var y = local.y; y < fill.tile; y += TILE_SIDE) {
        for (var x = local.x; x < fill.tile; x += TILE_SIDE) {
            for (var z = 0u; z < fill.tile; z++) {
                let texel = corner + vec3(x, y, z);
                if texel.x < fill.size_x && texel.y < fill.size_y && texel.z < fill.size_z {
                    textureStore(texels, texel, stored);
                }
            }
        }
    }
}
