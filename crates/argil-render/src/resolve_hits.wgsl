// GPU version of set_normals and intersect_ground in trace.rs: work that all primary rays share after marching, one pixel
// per thread. `surface_normal` depends on the representation.

// Returns a hit with its normal, or the ground where that is closer.
fn with_ground(ray: Ray, hit: Hit, hit_normal: vec3<f32>) -> Hit {
    var kind = hit.kind;
    var normal = vec3(0.0);
    var t = 0.0;
    if kind != HIT_NONE {
        t = hit.normal_t.w;
        // If all differences are equal, the normal faces the viewer.
        normal = select(hit_normal, -ray.direction, all(hit_normal == vec3(0.0)));
    }
    if ray.direction.y <= -1e-6 && frame.has_ground != 0u {
        let g = (frame.ground_y - ray.origin.y) / ray.direction.y;
        if g > near_length(ray) && g < frame.far && (kind == HIT_NONE || g < t) {
            kind = HIT_GROUND;
            normal = vec3(0.0, 1.0, 0.0);
            t = g;
        }
    }
    return Hit(vec4(normal, t), kind, hit.steps, hit.descents, hit.cells, hit.id);
}

// Sets the normal, and the ground where it is closer.
@compute @workgroup_size(8, 8)
fn resolve_hits(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let hit = stored_hit(at);
    let ray = primary_ray(id.x, y);
    var normal = hit.normal_t.xyz;
    if hit.kind != HIT_NONE {
        normal = surface_normal(hit, ray);
    }
    store_surface(at, with_ground(ray, hit, normal));
}

// Ends a march that other passes go on from, or shows what it hit: a frame without light needs no other pass.
fn end_march(at: u32, ray: Ray, hit: Hit, normal: vec3<f32>, shows: bool) {
    if !shows {
        store_hit(at, hit);
        return;
    }
    let shown = with_ground(ray, hit, normal);
    if per_thread(frame.records, at) != 0u {
        store_hit(at, shown);
    }
    show_hit(at, shown);
}
