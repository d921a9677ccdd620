// The first hit of each pixel.

// `march` has already computed it.
fn surface_normal(hit: Hit, ray: Ray) -> vec3<f32> {
    return hit.normal_t.xyz;
}

// Marches a pixel of a block. `cone_steps` are those of the block's cone, which one of its pixels has.
fn march_pixel(x: u32, y: u32, block_place: u32, cone_steps: u32, shows: bool) {
    let at_pixel = y * frame.width + x;
    let ray = primary_ray(x, y);
    let span = primary_span(ray);
    let begin = max(span.x, live.blocks[block_place].begin);
    var is_inside = live.blocks[block_place].is_inside != 0u;
    if HOST_RAYS {
        // A near plane may be in the solid, or in the box, for some pixels of a block only.
        is_inside = span.z <= 0.0 && brick_clearance(ray.origin + ray.direction * begin) < 0.0;
    }
    let walk = walk_bricks(ray, begin, span.y, select(1.0, -1.0, is_inside));
    var hit = Hit(vec4(0.0), walk.kind, walk.steps + cone_steps, 0u, walk.lookups, 0u);
    if walk.kind != HIT_NONE {
        hit.normal_t = vec4(walked_normal(ray, walk), walk.t);
        hit.id = walk.last_index + 1u;
    }
    end_march(at_pixel, ray, hit, hit.normal_t.xyz, shows);
}
