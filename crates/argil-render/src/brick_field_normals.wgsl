// Replaces the normals of bricks with the field's.

@compute @workgroup_size(8, 8)
fn exact_normals(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    var hit = stored_hit(at);
    if hit.kind != HIT_OUTSIDE && hit.kind != HIT_INSIDE {
        return;
    }
    let ray = primary_ray(id.x, y);
    if any(clip_normal(ray, hit.normal_t.w) != vec3(0.0)) {
        return;
    }
    let normal = field_normal(ray.origin + ray.direction * hit.normal_t.w, select(1.0, -1.0, hit.kind == HIT_INSIDE));
    if any(normal != vec3(0.0)) {
        hit.normal_t = vec4(normal, hit.normal_t.w);
        store_surface(at, hit);
    }
}
