// Light, block by block of pixels, after `sun_cone`. A software device executes what a thread skips, so each kind of
// block has a pass of its own.

// Returns how much of the sun a pixel sees.
fn sun_share_of(hit: Hit, x: u32, y: u32) -> f32 {
    let at = y * frame.width + x;
    let begin = live.blocks[cone_place(x, y)].begin;
    let share = select(1.0, bitcast<f32>(hits[sun_at(at)].x), begin >= 0.0);
    // What meets nothing is not in the cylinder.
    let span = sun_ray(hit, x, y).span;
    return select(share, 0.0, begin == ALL_DARK && span.x <= span.y);
}

// Marches the rays of the listed blocks.
@compute @workgroup_size(8, 8)
fn shadow_blocks(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let pixel = listed_pixel(group.x, local);
    let begin = live.blocks[live.blocks[group.x].place].begin;
    if pixel.x >= frame.width || pixel.y >= frame.height || begin < 0.0 {
        return;
    }
    let at = pixel.y * frame.width + pixel.x;
    let hit = stored_hit(at);
    let ray = sun_ray(hit, pixel.x, pixel.y);
    let end = min(ray.span.y, begin);
    let state = vec2(1.0, select(ray.span.x, -1.0, ray.span.x > end));
    let share = march_to_sun(ray.origin, state, end, hit.normal_t.w, vec2(0u, SHADOW_STEPS)).x;
    hits[sun_at(at)].x = bitcast<u32>(share);
}

// Shades the blocks that are plain.
@compute @workgroup_size(8, 8)
fn shade_plain(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height || live.blocks[cone_place(id.x, y)].steps != PLAIN {
        return;
    }
    let at = y * frame.width + id.x;
    let hit = stored_hit(at);
    let ray = primary_ray(id.x, y);
    let sunlit = sun_share_of(hit, id.x, y);
    let surface = shade_surface(at, ray, hit, ground_material(), sunlit, vec4(hit.normal_t.xyz, 1.0));
    let light = select(surface, sky(ray.direction), hit.kind == HIT_NONE);
    let reach = select(hit.normal_t.w, UNLIMITED, hit.kind == HIT_NONE);
    put(at, hit.kind, tone_map(with_more(at, ray, reach, light)));
}

// Shades the other blocks.
@compute @workgroup_size(8, 8)
fn shade_blocks(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let pixel = listed_pixel(group.x, local);
    let place = live.blocks[group.x].place;
    if pixel.x >= frame.width || pixel.y >= frame.height || live.blocks[place].steps == PLAIN {
        return;
    }
    let at = pixel.y * frame.width + pixel.x;
    shade_pixel(pixel.x, pixel.y, sun_share_of(stored_hit(at), pixel.x, pixel.y));
}
