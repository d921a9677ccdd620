// Units of sparse bricks: the slots of the pool, including empty ones.

// Records the pool slot of each cell, plus 1; 0 means none.
@compute @workgroup_size(64)
fn find_owners(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let at = group_index(id, count) * 64u + local;
    if at < volume.table.cells && is_brick(word_at(at)) {
        owners[unit_of(word_at(at))] = at + 1u;
    }
}

fn unit_of(word: u32) -> u32 {
    return (word & 1023u) + volume.pool_x * (((word >> 10u) & 1023u) + volume.pool_y * (word >> 20u));
}

fn cell_of_unit(unit: u32) -> vec3<i32> {
    return cell_at(owners[unit] - 1u);
}

fn is_unit(unit: u32) -> bool {
    return unit < marching.units && owners[unit] != 0u;
}

// Returns the unit at an offset, or the unit itself if there is none.
fn unit_beside(unit: u32, way: vec3<u32>) -> u32 {
    let cell = cell_of_unit(unit) + vec3<i32>(way);
    if any(cell >= high_cell()) {
        return unit;
    }
    let word = word_at(word_index(cell));
    return select(unit, unit_of(word), is_brick(word));
}

// Returns the first sample of a unit, relative to the volume's first.
fn origin_of(unit: u32) -> vec3<f32> {
    return vec3<f32>(cell_of_unit(unit) * i32(marching.side));
}

// Returns the highest index of a sample in a unit.
fn last_of(unit: u32) -> vec3<u32> {
    return vec3(marching.side);
}

// Returns a stored distance in quanta.
fn stored_at(unit: u32, place: vec3<u32>) -> f32 {
    return round(textureLoad(stored, brick_origin(brick_word(unit)) + place, 0).x * f32(volume.max_code));
}

// Returns a stored distance that may be in a neighbor, and whether it exists.
fn stored_beyond(unit: u32, place: vec3<i32>) -> vec2<f32> {
    let side = i32(marching.side);
    let way = vec3<i32>(place > vec3(side)) - vec3<i32>(place < vec3(0));
    if all(way == vec3(0)) {
        return vec2(stored_at(unit, vec3<u32>(place)), 1.0);
    }
    let cell = cell_of_unit(unit) + way;
    if any(cell < low_cell()) || any(cell >= high_cell()) {
        return vec2(0.0);
    }
    let word = word_at(word_index(cell));
    if !is_brick(word) {
        return vec2(0.0);
    }
    return vec2(stored_at(unit_of(word), vec3<u32>(place - way * side)), 1.0);
}
