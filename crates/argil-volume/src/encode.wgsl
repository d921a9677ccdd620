// How a texture stores distances. `fill` is the bound uniform.

// GPU version of integer_of in encoding.rs. The stored value is the integer over the quanta.
fn encode(d: f32) -> vec4<f32> {
    let quanta = f32(fill.max_code);
    let bias = fill.first_bias.w;
    let scale = fill.spacing_scale.w;
    let is_signed = bias == 0.0;
    let value = select((abs(d) - bias) * scale, d * scale, is_signed);
    let q = floor(clamp(value, -quanta, quanta) + select(0.0, 0.5, is_signed));
    return vec4(q / quanta, 0.0, 0.0, 0.0);
}
