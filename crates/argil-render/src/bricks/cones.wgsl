// GPU version of cones.rs, one block of pixels per thread: where its rays begin, and the number of steps. Blocks
// that can hit something are listed for marching; the others have missed. The volume provides its box, and around a
// point a lower bound of the distance with the voxel that it comes from.

const INFINITE: f32 = 3.0e38;

fn cone_place(x: u32, y: u32) -> u32 {
    let across = (frame.width + CONE_SIDE - 1u) / CONE_SIDE;
    return y / CONE_SIDE * across + x / CONE_SIDE;
}

@compute @workgroup_size(8, 8)
fn cone(@builtin(global_invocation_id) id: vec3<u32>) {
    march_cone(id, false);
}

@compute @workgroup_size(8, 8)
fn cone_and_show(@builtin(global_invocation_id) id: vec3<u32>) {
    march_cone(id, true);
}

fn march_cone(id: vec3<u32>, shows: bool) {
    let x = id.x * CONE_SIDE;
    let y = frame.first_row + id.y * CONE_SIDE;
    if x >= frame.width || y >= frame.height {
        return;
    }
    // The interval of the box over all rays of the block.
    var begin = INFINITE;
    var end = -INFINITE;
    var starts_outside = false;
    for (var i = 0u; i < CONE_SIDE * CONE_SIDE; i++) {
        let px = x + i % CONE_SIDE;
        let py = y + i / CONE_SIDE;
        if px < frame.width && py < frame.height {
            let span = primary_span(primary_ray(px, py));
            if span.x <= span.y {
                begin = min(begin, span.x);
                starts_outside = starts_outside || span.z > 0.0;
                end = max(end, span.y);
            }
        }
    }
    let place = cone_place(x, y);
    let meets = begin <= end;
    let middle = ray_through(f32(x) + 0.5 * f32(CONE_SIDE), f32(y) + 0.5 * f32(CONE_SIDE));
    let direction = middle.direction;
    let eye = middle.origin;
    let slope = CONE_RADIUS * frame.pixel_width;
    let held_min = cone_box_min();
    let held_max = cone_box_max();
    var steps = 0u;
    var is_inside = false;
    while meets && steps < CONE_STEPS {
        steps++;
        let at = eye + direction * begin;
        let held = clamp(at, held_min, held_max);
        let beside = distance(at, held);
        let clearance = cone_clearance(held, begin);
        let d = clearance.x;
        is_inside = is_inside || (steps == 1u && d < 0.0 && !starts_outside);
        var free = max(abs(d) * frame.inv_lipschitz - beside, beside);
        if d < 0.0 && starts_outside {
            free = 0.0;
        }
        let next = (begin + free) / (1.0 + slope);
        let gain = next - begin;
        let is_enough = gain > max(0.5 * clearance.y, 0.1 * slope * begin);
        begin = max(begin, next);
        if begin > end {
            begin = INFINITE;
            break;
        }
        if !is_enough {
            break;
        }
    }
    live.blocks[place].begin = begin;
    live.blocks[place].steps = steps;
    live.blocks[place].is_inside = u32(is_inside);
    if meets && begin < INFINITE {
        live.blocks[atomicAdd(&live.groups_x, 1u)].place = place;
        return;
    }
    for (var i = 0u; i < CONE_SIDE * CONE_SIDE; i++) {
        let px = x + i % CONE_SIDE;
        let py = y + i / CONE_SIDE;
        if px < frame.width && py < frame.height {
            let own_steps = select(0u, steps, i == 0u);
            let hit = Hit(vec4(0.0), HIT_NONE, own_steps, 0u, 0u, 0u);
            end_march(py * frame.width + px, primary_ray(px, py), hit, vec3(0.0), shows);
        }
    }
}
