// GPU version of fill.rs: writes distances to a level's texture, `texels`.

override TILE_SIDE: u32 = 16u;

fn fill_texel(texel: vec3<u32>) {
    if texel.x >= fill.size_x || texel.y >= fill.size_y || texel.z >= fill.size_z {
        return;
    }
    let d = field_distance(fill.first_bias.xyz + fill.spacing_scale.xyz * vec3<f32>(texel));
    textureStore(texels, texel, encode(d));
}

// The study's first version: one thread per group, one texel per thread.
@compute @workgroup_size(1)
fn fill_naive(@builtin(workgroup_id) id: vec3<u32>) {
    fill_texel(id + vec3(0u, 0u, fill.first_layer));
}

// One tile per group, one column of texels per thread.
@compute @workgroup_size(TILE_SIDE, TILE_SIDE)
fn fill_tiled(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    fill_tile(id * fill.tile, local);
}

// Fills layers of a tile at a corner. A tile may be larger than its group.
fn fill_tile(corner: vec3<u32>, local: vec3<u32>) {
    for (var y = local.y; y < fill.tile; y += TILE_SIDE) {
        for (var x = local.x; x < fill.tile; x += TILE_SIDE) {
            for (var z = 0u; z < fill.layer_count; z++) {
                fill_texel(corner + vec3(x, y, fill.first_layer + z));
            }
        }
    }
}
