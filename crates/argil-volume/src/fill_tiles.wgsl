// Fills a texture in tiles. `fill_texels` is that of fill.wgsl or of fill_by_columns.wgsl.

override TILE_SIDE: u32 = 16u;

// One tile per group, one column of texels per thread.
@compute @workgroup_size(TILE_SIDE, TILE_SIDE)
fn fill_tiled(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    fill_tile(id * fill.tile, local);
}

// Fills layers of a tile at a corner. A tile may be larger than its group.
fn fill_tile(corner: vec3<u32>, local: vec3<u32>) {
    for (var y = local.y; y < fill.tile; y += TILE_SIDE) {
        for (var x = local.x; x < fill.tile; x += TILE_SIDE) {
            for (var z = 0u; z < fill.layer_count; z += TEXELS_AT_ONCE) {
                fill_texels(corner + vec3(x, y, fill.first_layer + z), fill.layer_count - z);
            }
        }
    }
}
