// Rays in memory, in records of 16 bytes: for each pixel its surface, then what the sun lights, if anything is shaded, then
// what the ray did, if that is asked for.

struct Hit {
    // The normal, and the length of the ray.
    normal_t: vec4<f32>,
    kind: u32,
    steps: u32,
    descents: u32,
    cells: u32,
    id: u32,
}

// The index of what the sun lights.
fn sun_at(at: u32) -> u32 {
    return frame.width * frame.height + at;
}

// The index of what a ray did.
fn counts_at(at: u32) -> u32 {
    return frame.width * frame.height * select(1u, 2u, frame.mode == MODE_SHADED) + at;
}

// The kind is in bits of the normal that numbers below 2 leave free.
fn surface_record(hit: Hit) -> vec4<u32> {
    let kind = vec4((vec3(hit.kind) >> vec3(0u, 1u, 2u)) & vec3(1u), 0u) * HIT_KIND_BIT;
    return (bitcast<vec4<u32>>(hit.normal_t) & vec4(vec3(~HIT_KIND_BIT), 0xffffffffu)) | kind;
}

// A hit without what the ray did.
fn hit_of(surface: vec4<u32>) -> Hit {
    let kind = dot(vec3<u32>((surface.xyz & vec3(HIT_KIND_BIT)) != vec3(0u)), vec3(1u, 2u, 4u));
    let normal_t = bitcast<vec4<f32>>(surface & vec4(vec3(~HIT_KIND_BIT), 0xffffffffu));
    return Hit(normal_t, kind, 0u, 0u, 0u, 0u);
}
