// GPU version of fill.rs: writes distances to a level's texture, `texels`.

// Texels above each other that a thread fills at once.
const TEXELS_AT_ONCE: u32 = 1u;

fn fill_texels(texel: vec3<u32>, count: u32) {
    if texel.x >= fill.size_x || texel.y >= fill.size_y || texel.z >= fill.size_z {
        return;
    }
    let d = field_distance(fill.first_bias.xyz + fill.spacing_scale.xyz * vec3<f32>(texel));
    textureStore(texels, texel, encode(d));
}

// The study's first version: one thread per group, one texel per thread.
@compute @workgroup_size(1)
fn fill_naive(@builtin(workgroup_id) id: vec3<u32>) {
    fill_texels(id + vec3(0u, 0u, fill.first_layer), 1u);
}
