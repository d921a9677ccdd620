// The first hit of each pixel.

// `march` has already computed it.
fn surface_normal(hit: Hit, ray: Ray) -> vec3<f32> {
    return hit.normal_t.xyz;
}

// Returns a factor around 1 that differs from pixel to pixel.
fn dither(pixel: u32) -> f32 {
    var hash = pixel * 0x9e3779b9u;
    hash = (hash ^ (hash >> 15u)) * 0x85ebca6bu;
    return 1.0 + LEVEL_DITHER * (f32(hash >> 8u) * (1.0 / 16777216.0) - 0.5);
}

// Marches a pixel of a block. `cone_steps` are those of the block's cone, which one of its pixels has.
fn march_pixel(x: u32, y: u32, block_place: u32, cone_steps: u32, shows: bool) {
    let at_pixel = y * frame.width + x;
    let ray = primary_ray(x, y);
    let span = primary_span(ray);
    let from_eye = select(vec3(0.0), ray.origin - frame.eye, HOST_RAYS);
    let size = volume.pixel_error * frame.pixel_width;
    let begin = max(span.x, live.blocks[block_place].begin);
    let walk = walk_levels(ray.direction, from_eye, begin, span.zy, size * dither(at_pixel));
    if walk.voxel > 0.0 {
        atomicAdd(&feedback[0], 1u);
        if walk.gap > 0.0 && walk.voxel > 2.0 * size * walk.t {
            atomicAdd(&feedback[1], 1u);
        }
    }
    let is_hit = walk.kind != HIT_NONE;
    var seen = walk.last_cell + 1u;
    let mode = per_thread(frame.mode, at_pixel);
    if mode == MODE_LEVELS {
        seen = 1u + walk.level + select(0u, LEVEL_MISSING, walk.gap > 0.0);
    }
    if mode == MODE_BRICKS && is_hit {
        let origin = bitcast<vec3<u32>>(page_origin(walk.last_cell / 8u)) * vec3(0x8da6b343u, 0xd8163841u, 0xcb1ab31fu);
        seen = (origin.x ^ origin.y ^ origin.z ^ ((8u * walk.level + (walk.last_cell & 7u)) * 0x9e3779b9u)) | 1u;
    }
    seen = select(0u, seen, is_hit);
    let normal = select(vec3(0.0), walk.normal, is_hit);
    let normal_t = vec4(normal, select(0.0, walk.t, is_hit));
    let hit = Hit(normal_t, walk.kind, walk.samples + walk.lookups + cone_steps, 0u, walk.lookups, seen);
    end_march(at_pixel, ray, hit, normal, shows);
}
