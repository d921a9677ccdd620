// GPU version of fill.rs, for a program of common instructions: writes distances to a level's texture, `texels`. `lists` has
// the program's length and its words.

const TEXELS_AT_ONCE: u32 = 3u;

fn texel_point(texel: vec3<u32>) -> vec3<f32> {
    return fill.first_bias.xyz + fill.spacing_scale.xyz * vec3<f32>(texel);
}

// Fills up to three texels above each other, no more than `count`.
fn fill_texels(texel: vec3<u32>, count: u32) {
    if texel.x >= fill.size_x || texel.y >= fill.size_y || texel.z >= fill.size_z {
        return;
    }
    let second = texel + vec3(0u, 0u, 1u);
    let third = texel + vec3(0u, 0u, 2u);
    let p = Column(texel_point(texel), texel_point(second), texel_point(third));
    let d = column_distances(vec2(1u, lists[0]), p);
    textureStore(texels, texel, encode(d.x));
    let left = min(count, fill.size_z - texel.z);
    if left > 1u {
        textureStore(texels, second, encode(d.y));
    }
    if left > 2u {
        textureStore(texels, third, encode(d.z));
    }
}
