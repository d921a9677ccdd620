// Surfaces whose materials the volume does not store. They are listed, and a pass of their own evaluates the field: a
// software device would evaluate it for all pixels.

// Lists a pixel. The list lies beside what the sun lights.
fn defer(at: u32) {
    let index = atomicAdd(&live.deferred, 1u);
    hits[sun_at(index)].y = at;
    if index % 64u == 0u {
        atomicAdd(&live.groups_x, 1u);
    }
}

@compute @workgroup_size(64)
fn shade_deferred(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= atomicLoad(&live.deferred) {
        return;
    }
    let at = hits[sun_at(id.x)].y;
    let hit = stored_hit(at);
    let ray = primary_ray(at % frame.width, at / frame.width);
    field_surface(ray.origin + ray.direction * hit.normal_t.w);
    let sunlit = sun_share_of(hit, at % frame.width, at / frame.width);
    put(at, hit.kind, shaded(at, ray, hit, field_material, sunlit));
}
