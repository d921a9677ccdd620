// What marches through textures share at their end.

fn surface_normal(hit: Hit, ray: Ray) -> vec3<f32> {
    let clip = clip_normal(ray, hit.normal_t.w);
    if hit.kind == HIT_OUTSIDE && any(clip != vec3(0.0)) {
        return clip;
    }
    let p = ray.origin + ray.direction * hit.normal_t.w;
    let side = select(1.0, -1.0, hit.kind == HIT_INSIDE);
    let h = frame.normal_bias;
    let n = vec3(
        stored_distance(p + vec3(h, 0.0, 0.0), 0u) - stored_distance(p - vec3(h, 0.0, 0.0), 0u),
        stored_distance(p + vec3(0.0, h, 0.0), 0u) - stored_distance(p - vec3(0.0, h, 0.0), 0u),
        stored_distance(p + vec3(0.0, 0.0, h), 0u) - stored_distance(p - vec3(0.0, 0.0, h), 0u),
    ) * side;
    let length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return n * select(0.0, 1.0 / max(length, 1e-37), length > 0.0);
}

// Ends a march whose hit has no normal yet, unless it is a box.
fn end_walk(at: u32, ray: Ray, hit: Hit, shows: bool) {
    var normal = hit.normal_t.xyz;
    if shows && ((hit.kind != HIT_NONE) & (hit.id == 0u)) {
        normal = surface_normal(hit, ray);
    }
    end_march(at, ray, hit, normal, shows);
}
