// GPU version of around and set_normals in trace.rs: the exact field's normal.

// Uses central differences. One call in a loop, because each call copies the code of the whole field.
fn field_normal(p: vec3<f32>, side: f32) -> vec3<f32> {
    let h = frame.normal_bias;
    var n = vec3(0.0);
    for (var i = 0u; i < 6u; i++) {
        let axis = vec3(f32(i < 2u), f32(i / 2u == 1u), f32(i >= 4u));
        let sign = 1.0 - 2.0 * f32(i & 1u);
        n += axis * (field_distance(p + axis * (h * sign)) * sign);
    }
    n *= side;
    let length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    let scale = select(0.0, 1.0 / max(length, 1e-37), length > 0.0);
    return n * scale;
}
