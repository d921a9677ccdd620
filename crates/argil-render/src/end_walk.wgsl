// What marches through textures share at their end.

// Ends a march whose hit has no normal yet, unless it is a box.
fn end_walk(at: u32, ray: Ray, hit: Hit, shows: bool) {
    var normal = hit.normal_t.xyz;
    if shows && ((hit.kind != HIT_NONE) & (hit.id == 0u)) {
        normal = surface_normal(hit, ray);
    }
    end_march(at, ray, hit, normal, shows);
}
