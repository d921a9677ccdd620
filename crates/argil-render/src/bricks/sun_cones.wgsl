// GPU version of the cylinders of sun.rs, one block of pixels per thread: from where on its rays to the sun are free.
// Blocks that march, or look up distances or materials, are listed. The others show the sky, and ground above which
// nothing is near.

const FLAT: f32 = 0.1;
const PLANE: f32 = 0.9;

struct SunRay {
    origin: vec3<f32>,
    normal: vec3<f32>,
    span: vec2<f32>,
}

// Returns the ray of a pixel. A side away from the sun, and a ray that misses the box, has none.
fn sun_ray(hit: Hit, x: u32, y: u32) -> SunRay {
    let view = primary_ray(x, y);
    let n = hit.normal_t.xyz;
    let origin = view.origin + view.direction * hit.normal_t.w + n * light_lift(hit.normal_t.w);
    let span = box_span(Ray(origin, frame.sun));
    let meets = hit.kind != HIT_NONE && dot(n, frame.sun) > 0.0 && span.x <= span.y;
    return SunRay(origin, n, select(vec2(INFINITE, -1.0), span, meets));
}

// What a block's begin means where none of its rays marches.
const ALL_FREE: f32 = -1.0;
const ALL_DARK: f32 = -2.0;
// What a block's steps are if its surfaces are ground that sees the whole sky.
const PLAIN: u32 = 1u;

// Whether occlusion finds nothing above the surfaces of a block around a point.
fn is_open_above(p: vec3<f32>, n: vec3<f32>, radius: f32, shortest: f32) -> bool {
    let height = tap_height(frame.radius, OCCLUSION_TAPS - 1u);
    let reach = (height + radius) / frame.inv_lipschitz;
    return shortest >= frame.radius && light_distance(p + n * height) >= reach;
}

@compute @workgroup_size(8, 8)
fn sun_cone(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = id.x * CONE_SIDE;
    let y = frame.first_row + id.y * CONE_SIDE;
    if x >= frame.width || y >= frame.height {
        return;
    }
    var low = vec3(INFINITE);
    var high = vec3(-INFINITE);
    var all_low = vec3(INFINITE);
    var all_high = vec3(-INFINITE);
    var begin = INFINITE;
    var end = 0.0;
    // How far origins are from the plane of the first one.
    var first_origin = vec3(0.0);
    var first_normal = vec3(0.0);
    var below = 0.0;
    var above = 0.0;
    var normals = vec3(0.0);
    var all_normals = vec3(0.0);
    var count = 0.0;
    var lit = 0.0;
    var solid = false;
    var min_step = INFINITE;
    var shortest = INFINITE;
    for (var i = 0u; i < CONE_SIDE * CONE_SIDE; i++) {
        let px = x + i % CONE_SIDE;
        let py = y + i / CONE_SIDE;
        let at = py * frame.width + px;
        if px >= frame.width || py >= frame.height { continue; }
        let hit = stored_hit(at);
        if hit.kind != HIT_NONE {
            let ray = sun_ray(hit, px, py);
            lit += 1.0;
            solid = solid || hit.kind != HIT_GROUND;
            all_low = min(all_low, ray.origin);
            all_high = max(all_high, ray.origin);
            all_normals += ray.normal;
            shortest = min(shortest, hit.normal_t.w);
            if ray.span.x <= ray.span.y {
                low = min(low, ray.origin);
                high = max(high, ray.origin);
                begin = min(begin, ray.span.x);
                end = max(end, ray.span.y);
                first_origin = select(first_origin, ray.origin, count == 0.0);
                first_normal = select(first_normal, ray.normal, count == 0.0);
                let away = dot(ray.origin - first_origin, first_normal);
                below = min(below, away);
                above = max(above, away);
                normals += ray.normal;
                count += 1.0;
                min_step = min(min_step, light_step(hit.normal_t.w));
            }
        }
    }
    let place = cone_place(x, y);
    // All normals of the ground are equal.
    var is_plain = lit == 0.0;
    if !solid && lit > 0.0 {
        is_plain = is_open_above(0.5 * (all_low + all_high), all_normals / lit, 0.5001 * distance(all_low, all_high), shortest);
    }
    live.blocks[place].steps = select(0u, PLAIN, is_plain);
    if count == 0.0 || begin >= end {
        live.blocks[place].begin = ALL_FREE;
        if !is_plain {
            live.blocks[atomicAdd(&live.groups_x, 1u)].place = place;
        }
        return;
    }
    let center = 0.5 * (low + high);
    let radius = 0.5001 * distance(low, high);
    let n = normals / count;
    let is_flat = dot(n, n) > 0.95 && dot(n, first_normal) > 0.95 && above - below <= 2.0 * FLAT * radius;
    // From where on a plane is far enough below.
    let over = dot(n, frame.sun) - 1.0 / SHADOW_SHARPNESS;
    var rise = select(0.0, dot(n, frame.sun), is_flat && over > 0.3);
    let leaves = begin + (1.0 + FLAT) * radius / max(over, 0.3);
    var t = select(begin, begin + 0.3 * radius, rise > 0.0);
    var free_from = begin;
    var is_dark = false;
    for (var step = 0u; step < SHADOW_STEPS && t < end; step++) {
        let d = light_distance(center + frame.sun * t);
        let around = d - radius / frame.inv_lipschitz;
        let is_free = SHADOW_SHARPNESS * around >= t;
        if rise > 0.0 {
            // As long as nothing is nearer than the plane, no ray is shadowed above it.
            let is_left = t >= leaves;
            let holds = select(d >= PLANE * rise * (t - begin), is_free, is_left);
            if !is_left && holds {
                t += max(max(0.5 * d * frame.inv_lipschitz, 0.1 * radius), min_step);
                continue;
            }
            rise = 0.0;
            if !holds {
                t = begin;
                continue;
            }
        }
        if d * frame.inv_lipschitz <= -radius {
            is_dark = true;
            break;
        }
        t += max(select(max(d * frame.inv_lipschitz, radius), around * frame.inv_lipschitz, is_free), min_step);
        free_from = select(t, free_from, is_free);
    }
    if t < end && !is_dark {
        free_from = INFINITE;
    }
    let marches = !is_dark && free_from > begin;
    live.blocks[place].begin = select(select(ALL_FREE, free_from, marches), ALL_DARK, is_dark);
    if marches || !is_plain {
        live.blocks[atomicAdd(&live.groups_x, 1u)].place = place;
    }
}
