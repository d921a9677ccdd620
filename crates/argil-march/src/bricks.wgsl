// Twin of bricks.rs, one thread a pixel. `cells` is the bound table of words, `stored` the pool of bricks.

// Twin of nudge_for in step.rs.
fn nudge_for(u: vec3<f32>) -> f32 {
    let far = max(abs(u.x), max(abs(u.y), abs(u.z)));
    return select(0.0, NUDGE_PLACE * far * volume.extent_voxel.w, HAS_LEVELS);
}

// Where a point lies: its cell, the cell's word, and the place in it in voxels.
struct Located {
    cell: vec3<f32>,
    inner: vec3<f32>,
    word: u32,
}

// In voxels from the volume's corner.
fn in_voxels(p: vec3<f32>) -> vec3<f32> {
    return (p - volume.corner_range.xyz) * (1.0 / volume.extent_voxel.w);
}

// The box in voxels, and its first and last cells.
struct Held {
    begin: vec3<f32>,
    end: vec3<f32>,
    low: vec3<f32>,
    last: vec3<f32>,
    per_brick: f32,
}

fn held_box() -> Held {
    let begin = vec3(volume.begin_x, volume.begin_y, volume.begin_z);
    let size = vec3<i32>(vec3(volume.size_x, volume.size_y, volume.size_z));
    return Held(vec3<f32>(begin), vec3<f32>(begin + size), vec3<f32>(low_cell()), vec3<f32>(high_cell() - 1), 1.0 / f32(volume.brick));
}

fn held_voxels(u: vec3<f32>) -> vec3<f32> {
    let held = held_box();
    return clamp(u, held.begin, held.end);
}

// Of a place in the box.
fn cell_of_held(u: vec3<f32>, held: Held) -> vec3<f32> {
    return min(floor(u * held.per_brick), held.last);
}

fn cell_of_voxels(u: vec3<f32>) -> vec3<f32> {
    let held = held_box();
    return cell_of_held(clamp(u, held.begin, held.end), held);
}

fn inner_of(u: vec3<f32>, cell: vec3<f32>) -> vec3<f32> {
    return clamp(held_voxels(u) - cell * f32(volume.brick), vec3(0.0), vec3(f32(volume.brick)));
}

fn locate(u: vec3<f32>) -> Located {
    let cell = cell_of_voxels(u);
    return Located(cell, inner_of(u, cell), word_at(word_index(vec3<i32>(cell))));
}

// What is interpolated in a brick.
fn brick_distance(origin: vec3<f32>, inner: vec3<f32>) -> f32 {
    let uvw = (origin + inner) * volume.per_texel.xyz;
    return textureSampleLevel(stored, linear, uvw, 0.0).x * volume.corner_range.w;
}

// Where a filter finds a brick's first sample, in texels.
fn filter_origin(word: u32) -> vec3<f32> {
    return vec3<f32>(brick_origin(word)) + 0.5;
}

// Twin of BrickSampler::away: of a place in a cell without a brick, the signed distance that it does not fall short of.
fn away(word: u32, inner: vec3<f32>) -> f32 {
    let center = center_of(word);
    let p = inner - 0.5 * f32(volume.brick);
    let left = max(abs(center) - volume.spread * sqrt(p.x * p.x + p.y * p.y + p.z * p.z), 1e-30);
    return select(left, -left, center < 0.0);
}

// Twin of BrickSampler::add_ways_out: in a large empty cube, the surface is as far as from the cube, and the way out of that.
fn away_in(slot: u32, u: vec3<f32>, plain: f32, word: u32) -> f32 {
    if !HAS_LEVELS || slot >= FAR_SLOTS || slot < 2u {
        return plain;
    }
    let edge = f32(far_cells(slot) * volume.brick);
    let begin = floor(u / edge) * edge;
    let low = u - begin;
    let high = begin + edge - u;
    let way = max(min(min(min(low.x, low.y), low.z), min(min(high.x, high.y), high.z)), 0.0) * volume.extent_voxel.w;
    let center = center_of(word);
    return select(center + way, center - way, center < 0.0);
}

// Around a point, how far the surface is at least, with the sign of the side.
fn brick_clearance(p: vec3<f32>) -> f32 {
    let u = held_voxels(in_voxels(p));
    let cell = cell_of_voxels(u);
    let index = word_index(vec3<i32>(cell));
    let at = Located(cell, inner_of(u, cell), word_at(index));
    if !is_brick(at.word) {
        return away_in(index / 64u, u, away(at.word, at.inner), at.word);
    }
    let d = brick_distance(filter_origin(at.word), at.inner);
    let length = max(abs(d) - 0.8660254 * volume.extent_voxel.w, 0.0);
    return select(length, -length, d < 0.0);
}

// Twin of step.rs: the distance at which a pixel's footprint ends a ray.
fn footprint(t: f32) -> f32 {
    let widest = max(volume.corner_range.w - BRICK_MARGIN_VOXELS * volume.extent_voxel.w, 0.0);
    return min(0.5 * frame.pixel * t, widest);
}

fn way_out(d: f32, f: f32) -> f32 {
    let way = not_zero(d);
    return select(-f, 1.0 - f, way > 0.0) / way;
}

struct Solved {
    is_hit: bool,
    t: f32,
}

// The first root of the cubic along the ray in the voxel of a brick that it is in, where `gap` is left to the surface.
// Four of its values tell a cubic: the filter interpolates as the cubic does.
fn solve(ray: Ray, t: f32, side: f32, gap: f32, origin: vec3<f32>, inner: vec3<f32>) -> Solved {
    let voxel = min(floor(inner), vec3(f32(volume.brick) - 1.0));
    let p = inner - voxel;
    let way = ray.direction * (1.0 / volume.extent_voxel.w);
    let leave = max(min(way_out(way.x, p.x), min(way_out(way.y, p.y), way_out(way.z, p.z))), 0.0);
    let third = way * (leave * (1.0 / 3.0));
    let f1 = brick_distance(origin, inner + third) * side;
    let f2 = brick_distance(origin, inner + 2.0 * third) * side;
    let f3 = brick_distance(origin, inner + 3.0 * third) * side;
    let c0 = gap;
    let c1 = 0.5 * (18.0 * f1 - 11.0 * gap - 9.0 * f2 + 2.0 * f3);
    let c2 = 4.5 * (2.0 * gap - 5.0 * f1 + 4.0 * f2 - f3);
    let c3 = 4.5 * (3.0 * f1 - gap - 3.0 * f2 + f3);

    // It rises and falls at most twice: the first stretch that ends below 0 holds the first root.
    let a = 3.0 * c3;
    let root = sqrt(max(c2 * c2 - a * c1, 0.0));
    let q = -(c2 + select(root, -root, c2 < 0.0));
    let s1 = clamp(q / select(a, 1e-30, a == 0.0), 0.0, 1.0);
    let s2 = clamp(c1 / select(q, 1e-30, q == 0.0), 0.0, 1.0);
    let first = min(s1, s2);
    let second = max(s1, s2);
    let in_first = cubic(c3, c2, c1, c0, first) < 0.0;
    let in_second = cubic(c3, c2, c1, c0, second) < 0.0;
    let at_end = cubic(c3, c2, c1, c0, 1.0) < 0.0;
    var begin = second;
    var end = 1.0;
    if in_first {
        begin = 0.0;
        end = first;
    } else if in_second {
        begin = first;
        end = second;
    }
    var f_begin = cubic(c3, c2, c1, c0, begin);
    var f_end = cubic(c3, c2, c1, c0, end);
    // Regula falsi, Illinois: the end that stays counts half.
    var share = end;
    for (var i = 0u; i < 4u; i++) {
        let span = f_begin - f_end;
        share = begin + (end - begin) * (f_begin / select(span, 1.0, span == 0.0));
        let f = cubic(c3, c2, c1, c0, share);
        if f < 0.0 {
            f_begin *= 0.5;
            end = share;
            f_end = f;
        } else {
            f_end *= 0.5;
            begin = share;
            f_begin = f;
        }
    }
    let is_crossed = in_first || in_second || at_end;
    let starts_below = c0 <= 0.0;
    let is_close = c0 < max(frame.epsilon, footprint(t));
    if starts_below || !is_crossed {
        share = 0.0;
    }
    if !(starts_below || is_crossed || is_close) {
        let u = in_voxels(ray.origin + ray.direction * t);
        return Solved(false, t + leave + NUDGE_VOXELS * volume.extent_voxel.w + NUDGE_SHARE * t + nudge_for(u));
    }
    return Solved(true, t + share * leave);
}

fn cubic(c3: f32, c2: f32, c1: f32, c0: f32, s: f32) -> f32 {
    return ((c3 * s + c2) * s + c1) * s + c0;
}

// What is interpolated at a place that may be beyond a brick's end along an axis, and how far that is from `inner`: in the
// neighbour's brick, or where there is none, at the brick's end. Without branches, which software devices walk both.
fn brick_beside(at: Located, axis: u32, by: f32) -> vec2<f32> {
    let side = f32(volume.brick);
    var place = at.inner;
    place[axis] += by;
    let over = place[axis] - clamp(place[axis], 0.0, side);
    var cell = vec3<i32>(at.cell);
    cell[axis] += i32(over > 0.0) - i32(over < 0.0);
    let held = clamp(cell, low_cell(), high_cell() - 1);
    let word = word_at(word_index(held));
    let is_there = is_brick(word) && all(held == cell);
    let across = select(0.0, select(-side, side, over > 0.0), over != 0.0);
    place[axis] -= select(over, across, is_there);
    let d = brick_distance(filter_origin(select(at.word, word, is_there)), place);
    return vec2(d, by - select(over, 0.0, is_there));
}

fn change_along(at: Located, axis: u32) -> f32 {
    // Within a voxel the change is the same everywhere along the axis.
    var low = -0.5;
    var high = 0.5;
    if frame.normals != NORMALS_SMOOTH {
        var inner = at.inner;
        let begin = min(floor(inner[axis]), f32(volume.brick) - 1.0);
        low = begin - inner[axis];
        high = begin + 1.0 - inner[axis];
    }
    let a = brick_beside(at, axis, low);
    let b = brick_beside(at, axis, high);
    return (b.x - a.x) / (b.y - a.y);
}

// The normal at a point of the surface: differences over the voxel or, smooth, over a voxel's width around the point.
fn brick_normal(p: vec3<f32>, side: f32) -> vec3<f32> {
    let at = locate(in_voxels(p));
    let in_brick = is_brick(at.word);
    let held = Located(at.cell, at.inner, select(0u, at.word, in_brick));
    let n = vec3(change_along(held, 0u), change_along(held, 1u), change_along(held, 2u));
    let length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return n * select(0.0, side / max(length, 1e-37), in_brick && length > 0.0);
}

// `march` has found it already.
fn surface_normal(hit: Hit, p: vec3<f32>) -> vec3<f32> {
    return hit.normal_t.xyz;
}

// A block of pixels a group: one of those that its cone has left.
@compute @workgroup_size(8, 8)
fn march(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let block_place = live.blocks[group.x].place;
    let blocks_across = (frame.width + CONE_SIDE - 1u) / CONE_SIDE;
    let x = block_place % blocks_across * CONE_SIDE + local.x;
    let y = block_place / blocks_across * CONE_SIDE + local.y;
    if x >= frame.width || y >= frame.height {
        return;
    }
    let at_pixel = y * frame.width + x;
    let ray = primary_ray(x, y);
    let span = box_span(ray);
    let begin = live.blocks[block_place].begin;
    let own_steps = select(0u, live.blocks[block_place].steps, local.x == 0u && local.y == 0u);
    let voxel = volume.extent_voxel.w;
    let scale = frame.inv_lipschitz;
    let brick = f32(volume.brick);
    let held = held_box();
    let d = vec3(not_zero(ray.direction.x), not_zero(ray.direction.y), not_zero(ray.direction.z));
    let per_way = voxel / d;
    // A ray's place in voxels at length t is u_begin + u_way · t.
    let u_begin = in_voxels(ray.origin);
    let u_way = ray.direction * (1.0 / voxel);
    var t = max(span.x, begin);
    var side = 0.0;
    var kind = HIT_NONE;
    var samples = 0u;
    var looked_up = 0u;
    var last_index = 0xffffffffu;
    var is_there = true;
    // Rounds of marching to the surface and solving there: what is in a branch costs every step on some devices.
    while is_there {
        var near = false;
        var over = 0.0;
        var last_gap = 0.0;
        var last_way = 0.0;
        var inner = vec3(0.0);
        var origin = vec3(0.0);
        var g = 0.0;
        loop {
            if t > span.y || samples + looked_up >= frame.max_steps {
                is_there = false;
                break;
            }
            let u = u_begin + u_way * t;
            let cell = cell_of_held(clamp(u, held.begin, held.end), held);
            let index = word_index(vec3<i32>(cell));
            let word = word_at(index);
            let in_brick = is_brick(word);
            looked_up += u32(index != last_index);
            last_index = index;
            samples += u32(in_brick);
            inner = clamp(u - cell * brick, vec3(0.0), vec3(brick));
            origin = filter_origin(select(0u, word, in_brick));
            let stored_d = select(away(word, inner), brick_distance(origin, inner), in_brick);
            if side == 0.0 {
                side = select(1.0, -1.0, stored_d < 0.0 && span.x <= 0.0);
            }
            g = stored_d * side;
            // Spheres that no longer touch: back to where the last one ended.
            let too_far = over > 0.0 && g < over;
            near = in_brick && !too_far && g < max(NEAR_VOXELS * voxel, footprint(t));
            if !in_brick && !too_far && g < 0.0 {
                kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
                is_there = false;
            }
            if near || !is_there {
                break;
            }
            // Out of an empty cell, or block, or what is empty around that.
            // The slots that no block has are those of empty cubes.
            let is_cube = HAS_LEVELS && index < FAR_SLOTS * 64u;
            let edge = select(1.0, f32(far_cells(select(0u, index / 64u, is_cube))), is_cube || is_lonely(word));
            let first = floor(cell * (1.0 / edge)) * edge;
            let ahead = select(first, first + edge, d > vec3(0.0));
            let ways = (ahead * brick - u) * per_way;
            let leave = min(ways.x, min(ways.y, ways.z)) + NUDGE_VOXELS * voxel + NUDGE_SHARE * t + nudge_for(u);
            // Along a plane, spheres still touch with so much more than their radius between their centres.
            let fell = max(last_gap - g, 0.0);
            let sum = last_way + fell;
            let share = max((last_way - fell) / select(1.0, sum, sum > 0.0), 0.0);
            let beyond = select(0.0, RELAXATION * g * share * scale, in_brick && !too_far);
            let way = select(max(g * scale, leave), g * scale + beyond, in_brick);
            t += select(way, -over, too_far);
            last_gap = g;
            last_way = select(0.0, way, in_brick && !too_far);
            over = beyond;
            // Beyond the ray's end it goes no farther than is known to be free.
            let pull = clamp(t - span.y, 0.0, over);
            t -= pull;
            over -= pull;
            last_way = max(last_way - pull, 0.0);
        }
        if !near {
            break;
        }
        samples++;
        let solved = solve(ray, t, side, g, origin, inner);
        t = solved.t;
        if solved.is_hit {
            kind = select(HIT_OUTSIDE, HIT_INSIDE, side < 0.0);
            is_there = false;
        }
    }
    var normal = brick_normal(ray.origin + ray.direction * t, select(1.0, -1.0, kind == HIT_INSIDE));
    // Where all differences are the same, towards the viewer.
    if all(normal == vec3(0.0)) {
        normal = -ray.direction;
    }
    if kind == HIT_NONE {
        normal = vec3(0.0);
        t = 0.0;
    }
    let mark = select(last_index + 1u, 0u, kind == HIT_NONE);
    hits[at_pixel] = Hit(vec4(normal, t), kind, samples + looked_up + own_steps, 1.0, 0.0, 0u, looked_up, mark, 0u);
}

// Twin of BrickSampler::at_center.
fn at_center(cell: vec3<i32>) -> f32 {
    let word = word_at(word_index(cell));
    let in_brick = is_brick(word);
    let stored_d = brick_distance(filter_origin(select(0u, word, in_brick)), vec3(f32(volume.brick / 2u)));
    return select(center_of(word), stored_d, in_brick);
}

// Twin of BrickSampler::estimates: the distance at a point in the air, as nearly as it is known.
fn air_distance(p: vec3<f32>) -> f32 {
    let own = in_voxels(p);
    let u = held_voxels(own);
    let beside = distance(own, u) * volume.extent_voxel.w;
    let at = locate(u);
    let in_brick = is_brick(at.word);
    let stored_d = brick_distance(filter_origin(select(0u, at.word, in_brick)), at.inner);
    let low = vec3<f32>(low_cell());
    let last = vec3<f32>(high_cell() - 1);
    let place = clamp(u * (1.0 / f32(volume.brick)) - 0.5, low, last);
    let begin = min(floor(place), max(last - 1.0, low));
    let share = place - begin;
    var total = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let far = vec3(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let weights = select(1.0 - share, share, far != vec3(0u));
        let cell = min(vec3<i32>(begin) + vec3<i32>(far), vec3<i32>(last));
        total += weights.x * weights.y * weights.z * at_center(cell);
    }
    return select(total, stored_d, in_brick) + beside;
}

// Where a place that has a material is, in voxels: at a sample.
fn material_place(nth: vec3<u32>) -> vec3<u32> {
    let steps = MATERIAL_SIDE - 1u;
    return (2u * nth * volume.brick + steps) / (2u * steps);
}

// Twin of Bricks::material; what bricks do not tell the field does.
fn surface_material(p: vec3<f32>, outwards: vec3<f32>) -> MaterialWords {
    let at = locate(in_voxels(p));
    if !is_brick(at.word) {
        field_surface(p);
        return field_material;
    }
    let own = brick_materials[brick_number(at.word)];
    if (own & BRICK_MIXED) == 0u {
        return materials[min(own, arrayLength(&materials) - 1u)];
    }
    let steps = f32(MATERIAL_SIDE - 1u);
    let place = clamp(at.inner * (steps / f32(volume.brick)), vec3(0.0), vec3(steps));
    let begin = min(floor(place), vec3(steps - 1.0));
    let share = place - begin;
    let block = (own & ~BRICK_MIXED) * MATERIAL_SIDE * MATERIAL_SIDE * MATERIAL_SIDE;
    let per_voxel = volume.corner_range.w / volume.extent_voxel.w;
    var total = MaterialWords(vec4(0.0), vec4(0.0));
    var sum = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let far = vec3(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let index = vec3<u32>(begin) + far;
        let sample = material_place(index);
        let d = textureLoad(stored, brick_origin(at.word) + sample, 0).x * per_voxel;
        let from_plane = clamp(dot(vec3<f32>(sample) - at.inner, outwards), -per_voxel, per_voxel);
        let beside = max(1.0 - abs(d - from_plane), 0.0);
        let word = volume.capacity + 2u * (block + index.x + MATERIAL_SIDE * (index.y + MATERIAL_SIDE * index.z));
        let found = unpack_material(vec2(brick_materials[word], brick_materials[word + 1u]));
        let weights = select(1.0 - share, share, far != vec3(0u));
        let weight = weights.x * weights.y * weights.z * (LEAST_WEIGHT + beside * beside);
        sum += weight;
        total.base_roughness += weight * found.base_roughness;
        total.emission_metallic += weight * found.emission_metallic;
    }
    return MaterialWords(total.base_roughness / sum, total.emission_metallic / sum);
}
