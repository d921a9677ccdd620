// Finds the way of each pixel's point to where it was before brushes moved. `field` comes from moved.wgsl's interpreter.

@compute @workgroup_size(8, 8)
fn move_hits(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let at = id.y * frame.width + id.x;
    let hit = hit_of(hits[at]);
    let ray = primary_ray(id.x, id.y);
    let point = ray.origin + ray.direction * hit.normal_t.w;
    var way = vec3(0.0);
    if (hit.kind == HIT_OUTSIDE || hit.kind == HIT_INSIDE) && is_near_moved(point) {
        field(point, true);
        way = field_material.base_roughness.xyz;
    }
    motions[at] = vec4(way, 0.0);
}
