// GPU version of solve in step.rs: intersects a ray with the surface in its voxel, and computes the normal there.

// `far` is how far from the eye the ray's point is at most.
fn intersect_voxel(direction: vec3<f32>, t: f32, far: f32, side: f32, gap: f32, found: LevelCell, close: f32) -> Intersection {
    let inner = found.inner;
    let voxel = min(floor(inner), vec3(7.0));
    let p = inner - voxel;
    let way = direction * (1.0 / found.voxel);
    let leave = max(min(way_out(way.x, p.x), min(way_out(way.y, p.y), way_out(way.z, p.z))), 0.0);
    let third = way * (leave * (1.0 / 3.0));
    let f1 = brick_distance(found.word, inner + third, found.voxel) * side;
    let f2 = brick_distance(found.word, inner + 2.0 * third, found.voxel) * side;
    let f3 = brick_distance(found.word, inner + 3.0 * third, found.voxel) * side;
    let root = first_root(gap, f1, f2, f3);
    let starts_below = gap <= 0.0;
    if !(starts_below || root.is_crossed || gap < close) {
        return Intersection(false, t + leave + NUDGE_VOXELS * found.voxel + NUDGE_RELATIVE * far);
    }
    return Intersection(true, t + select(root.share, 0.0, starts_below || !root.is_crossed) * leave);
}

// Returns the brick beside a cell on the same level, and whether it exists. Notes what is missing.
fn brick_beside(found: LevelCell, axis: u32, step: i32) -> u32 {
    let slot = found.cell / 8u;
    var voxel = page_origin(slot) + vec3<i32>(8.0 * octant_place(found.cell & 7u) + 4.0) * i32(1u << found.level);
    voxel[axis] += step * i32(8u << found.level);
    let first = vec3(volume.first_x, volume.first_y, volume.first_z);
    let last = vec3(volume.last_x, volume.last_y, volume.last_z);
    if any(voxel < first) || any(voxel > last) {
        return MISSING_BRICK;
    }
    let beside = search(voxel, found.level, slot);
    if beside.lacks_child != NOTHING {
        note(beside);
    }
    return select(MISSING_BRICK, beside.word, beside.level == found.level && is_brick(beside.word));
}

// Interpolates at a position that may be beyond a brick's end along an axis. Returns the distance from the point as
// well.
fn distance_beside(found: LevelCell, axis: u32, by: f32) -> vec2<f32> {
    var place = found.inner;
    place[axis] += by;
    let over = place[axis] - clamp(place[axis], 0.0, 8.0);
    var word = found.word;
    var far = by;
    if over != 0.0 {
        let beside = brick_beside(found, axis, select(-1, 1, over > 0.0));
        let exists = beside != MISSING_BRICK;
        word = select(word, beside, exists);
        place[axis] -= select(over, select(-8.0, 8.0, over > 0.0), exists);
        far -= select(over, 0.0, exists);
    }
    return vec2(brick_distance(word, place, found.voxel), far);
}

fn change_along(found: LevelCell, axis: u32) -> f32 {
    // Within a voxel, the difference along the axis is constant.
    var low = -0.5;
    var high = 0.5;
    if per_thread(frame.normals, found.cell) != NORMALS_SMOOTH {
        let inner = found.inner[axis];
        let begin = min(floor(inner), 7.0);
        low = begin - inner;
        high = begin + 1.0 - inner;
    }
    let a = distance_beside(found, axis, low);
    let b = distance_beside(found, axis, high);
    return (b.x - a.x) / (b.y - a.y);
}

// Returns the normal in a brick: differences over the voxel or, if smooth, over a voxel's width around the point.
fn level_normal(found: LevelCell, side: f32) -> vec3<f32> {
    let n = vec3(change_along(found, 0u), change_along(found, 1u), change_along(found, 2u));
    let length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return n * select(0.0, side / max(length, 1e-37), length > 0.0);
}
