// Copies a frame into textures that stay on the device. One pixel per thread.

// The greatest 32-bit number stands for no hit: WGSL has no infinity.
const NO_HIT: f32 = 0x1.fffffep+127f;

@compute @workgroup_size(8, 8)
fn keep_distances(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let hit = hit_of(hits[id.y * frame.width + id.x]);
    let is_solid = hit.kind == HIT_OUTSIDE || hit.kind == HIT_INSIDE;
    textureStore(kept_distances, id.xy, vec4(select(NO_HIT, hit.normal_t.w, is_solid)));
}

@compute @workgroup_size(8, 8)
fn keep_colors(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let color = unpack4x8unorm(pixels[id.y * frame.width + id.x]);
    textureStore(kept_colors, id.xy, vec4(color.rgb, 1.0));
}
