// GPU version of bent.rs.

@compute @workgroup_size(8, 8)
fn bend_normals(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let hit = stored_hit(at);
    let ray = primary_ray(id.x, y);
    let p = ray.origin + ray.direction * hit.normal_t.w;
    let n = hit.normal_t.xyz;
    let axes = axes_of(n);
    let reach = tap_height(reach_at(hit.normal_t.w), OCCLUSION_TAPS - 1u);
    var sum = vec3(0.0);
    var open = 0.0;
    // Two lengths along five directions around the normal, and along the normal.
    for (var index = 0u; index < 6u; index++) {
        let turn = TAU * (f32(index) + haze_noise(id.x, y)) / 5.0;
        let beside = axes * vec3(0.8660254 * cos(turn), 0.8660254 * sin(turn), 0.5);
        let direction = select(beside, n, index == 5u);
        var seen = 1.0;
        for (var place = 0u; place < 2u; place++) {
            let height = max(select(0.3, 1.0, place == 1u) * reach, 1e-20);
            let above = p + direction * height;
            var d = light_distance(above);
            d = select(d, min(d, above.y - frame.ground_y), frame.has_ground != 0u);
            seen = min(seen, clamp(d / (0.5 * height), 0.0, 1.0));
        }
        let weight = seen * select(0.5, 1.0, index == 5u);
        sum += weight * direction;
        open += weight;
    }
    let bent = direction_or_zero(sum);
    colors[layer_at(BENT_LAYER, at)] = vec4(select(bent, n, all(bent == vec3(0.0))), open / 3.5);
}
