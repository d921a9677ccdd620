// GPU version of voxel_intersect.rs: intersects a ray with the surface in its voxel, and computes the normal there.

// Finds the first root of the cubic along the ray in its voxel, where `gap` is the distance to the surface. Four
// values determine the cubic, because filtering interpolates the same cubic.
fn intersect_voxel(ray: Ray, t: f32, side: f32, gap: f32, origin: vec3<f32>, inner: vec3<f32>) -> Intersection {
    let voxel = min(floor(inner), vec3(f32(volume.brick_size_voxels) - 1.0));
    let p = inner - voxel;
    let way = ray.direction * (1.0 / volume.voxel_size);
    let leave = max(min(way_out(way.x, p.x), min(way_out(way.y, p.y), way_out(way.z, p.z))), 0.0);
    let third = way * (leave * (1.0 / 3.0));
    let f1 = brick_distance(origin, inner + third) * side;
    let f2 = brick_distance(origin, inner + 2.0 * third) * side;
    let f3 = brick_distance(origin, inner + 3.0 * third) * side;
    let root = first_root(gap, f1, f2, f3);
    var share = root.share;
    let c0 = gap;
    let is_crossed = root.is_crossed;
    let starts_below = c0 <= 0.0;
    let is_close = c0 < frame.epsilon;
    if starts_below || !is_crossed {
        share = 0.0;
    }
    if !(starts_below || is_crossed || is_close) {
        let u = in_voxels(ray.origin + ray.direction * t);
        return Intersection(false, t + leave + NUDGE_VOXELS * volume.voxel_size + NUDGE_RELATIVE * t + nudge_for(u));
    }
    return Intersection(true, t + share * leave);
}

// Interpolates at a position that may be beyond a brick's end along an axis. Returns the distance from `inner` as
// well. Reads the neighbor's brick or, without one, the brick's end.
fn brick_beside(at: CellLocations, axis: u32, by: f32) -> vec2<f32> {
    let side = f32(volume.brick_size_voxels);
    var place = at.inner;
    place[axis] += by;
    let over = place[axis] - clamp(place[axis], 0.0, side);
    var word = at.word;
    var pull = over;
    var given = by - over;
    // Few places are beyond. This is a loop because software devices execute branches that no thread takes.
    for (var left = u32(over != 0.0); left > 0u; left--) {
        var cell = vec3<i32>(at.cell);
        cell[axis] += i32(over > 0.0) - i32(over < 0.0);
        let held = clamp(cell, low_cell(), high_cell() - 1);
        let other = word_at(word_index(held));
        let exists = is_brick(other) && all(held == cell);
        word = select(word, other, exists);
        pull = select(over, select(-side, side, over > 0.0), exists);
        given = select(given, by, exists);
    }
    place[axis] -= pull;
    return vec2(brick_distance(filter_origin(word), place), given);
}

fn change_along(at: CellLocations, axis: u32) -> f32 {
    // Within a voxel, the difference along the axis is constant.
    var low = -0.5;
    var high = 0.5;
    if per_thread(frame.normals, at.word) != NORMALS_SMOOTH {
        var inner = at.inner;
        let begin = min(floor(inner[axis]), f32(volume.brick_size_voxels) - 1.0);
        low = begin - inner[axis];
        high = begin + 1.0 - inner[axis];
    }
    let a = brick_beside(at, axis, low);
    let b = brick_beside(at, axis, high);
    return (b.x - a.x) / (b.y - a.y);
}

// Returns the normal at a location on the surface: differences over the voxel or, if smooth, over a voxel's width around it.
fn brick_normal(at: CellLocations, side: f32) -> vec3<f32> {
    let in_brick = is_brick(at.word);
    let held = CellLocations(at.cell, at.inner, select(0u, at.word, in_brick));
    let n = vec3(change_along(held, 0u), change_along(held, 1u), change_along(held, 2u));
    let length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return n * select(0.0, side / max(length, 1e-37), in_brick && length > 0.0);
}
