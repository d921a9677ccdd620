// GPU version of material.rs: materials in eight bytes.

fn byte_of(v: f32) -> u32 {
    return u32(clamp(v, 0.0, 1.0) * 255.0 + 0.5);
}

fn pack_material(m: GpuMaterial) -> vec2<u32> {
    let base = sqrt(max(m.base_roughness.xyz, vec3(0.0)));
    let e = max(m.emission_metallic.xyz, vec3(0.0));
    let light = e / (1.0 + e);
    return vec2(
        byte_of(base.x) | (byte_of(base.y) << 8u) | (byte_of(base.z) << 16u) | (byte_of(m.base_roughness.w) << 24u),
        byte_of(light.x) | (byte_of(light.y) << 8u) | (byte_of(light.z) << 16u) | (byte_of(m.emission_metallic.w) << 24u),
    );
}

fn unpack_bytes(word: u32) -> vec4<f32> {
    return vec4<f32>((vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(255u)) * (1.0 / 255.0);
}

fn unpack_material(packed: vec2<u32>) -> GpuMaterial {
    let a = unpack_bytes(packed.x);
    let b = unpack_bytes(packed.y);
    return GpuMaterial(vec4(a.xyz * a.xyz, a.w), vec4(b.xyz / max(1.0 - b.xyz, vec3(1.0 / 512.0)), b.w));
}

// Converts a brick's word to its index in the pool.
fn brick_number(word: u32) -> u32 {
    return (word & 1023u) + volume.pool_x * (((word >> 10u) & 1023u) + volume.pool_y * (word >> 20u));
}
