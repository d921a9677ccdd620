// Converts drawn triangles to hits, one pixel per thread. GPU version of raster.rs, together with raster_draw.wgsl.

// Hits already have their normals.
fn surface_normal(hit: Hit, ray: Ray) -> vec3<f32> {
    return hit.normal_t.xyz;
}

@compute @workgroup_size(8, 8)
fn march(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let nearest = textureLoad(drawn, vec2<i32>(vec2(id.x, y)), 0);
    var kind = HIT_NONE;
    if nearest.w > 0.0 {
        kind = HIT_OUTSIDE;
    } else if nearest.w < 0.0 {
        kind = HIT_INSIDE;
    }
    let steps = select(0u, 1u, kind != HIT_NONE);
    store_hit(y * frame.width + id.x, Hit(vec4(nearest.xyz, abs(nearest.w)), kind, steps, 0u, 0u, 0u));
}
