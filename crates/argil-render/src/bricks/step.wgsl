// The first hit of each pixel.

// One block of pixels per group: a block that its cone did not rule out.
@compute @workgroup_size(8, 8)
fn march(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    march_pixel(group.x, local, false);
}

@compute @workgroup_size(8, 8)
fn march_and_show(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    march_pixel(group.x, local, true);
}

fn march_pixel(group: u32, local: vec3<u32>, shows: bool) {
    let block_place = live.blocks[group].place;
    let blocks_across = (frame.width + CONE_SIDE - 1u) / CONE_SIDE;
    let x = block_place % blocks_across * CONE_SIDE + local.x;
    let y = block_place / blocks_across * CONE_SIDE + local.y;
    if x >= frame.width || y >= frame.height {
        return;
    }
    let at_pixel = y * frame.width + x;
    let ray = primary_ray(x, y);
    let span = box_span(ray);
    let side = select(1.0, -1.0, live.blocks[block_place].is_inside != 0u);
    let walk = walk_bricks(ray, max(span.x, live.blocks[block_place].begin), span.y, side);
    let own_steps = select(0u, live.blocks[block_place].steps, local.x == 0u && local.y == 0u);
    var hit = Hit(vec4(0.0), walk.kind, walk.steps + own_steps, 1.0, 0.0, 0u, walk.lookups, 0u, 0u);
    if walk.kind != HIT_NONE {
        hit.normal_t = vec4(walked_normal(ray, walk), walk.t);
        hit.id = walk.last_index + 1u;
    }
    end_march(at_pixel, ray, hit, hit.normal_t.xyz, shows);
}
