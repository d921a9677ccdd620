// Units of a dense volume: adjacent parts of its cells.

fn grid_of() -> vec3<u32> {
    return vec3(volume.grid_x, volume.grid_y, volume.grid_z);
}

fn is_unit(unit: u32) -> bool {
    return unit < marching.units;
}

fn unit_position(unit: u32) -> vec3<u32> {
    let grid = grid_of();
    return vec3(unit % grid.x, unit / grid.x % grid.y, unit / grid.x / grid.y);
}

// Returns the unit at an offset, or the unit itself if there is none.
fn unit_beside(unit: u32, way: vec3<u32>) -> u32 {
    let grid = grid_of();
    let place = unit_position(unit) + way;
    return select(unit, place.x + grid.x * (place.y + grid.y * place.z), all(place < grid));
}

fn texel_of(unit: u32) -> vec3<u32> {
    return unit_position(unit) * marching.side;
}

// Returns the first sample of a unit, relative to the volume's first.
fn origin_of(unit: u32) -> vec3<f32> {
    return vec3<f32>(texel_of(unit));
}

// Returns the highest index of a sample in a unit.
fn last_of(unit: u32) -> vec3<u32> {
    let size = vec3(volume.size_x, volume.size_y, volume.size_z);
    return min(size - 1u - texel_of(unit), vec3(marching.side));
}

// Returns a stored distance in quanta.
fn stored_at(unit: u32, place: vec3<u32>) -> f32 {
    return round(textureLoad(stored, texel_of(unit) + place, 0).x * f32(volume.max_code));
}

// Returns a stored distance that may be outside the unit, and whether it exists.
fn stored_beyond(unit: u32, place: vec3<i32>) -> vec2<f32> {
    let at = vec3<i32>(texel_of(unit)) + place;
    let size = vec3<i32>(vec3(volume.size_x, volume.size_y, volume.size_z));
    if any(at < vec3(0)) || any(at >= size) {
        return vec2(0.0);
    }
    return vec2(round(textureLoad(stored, at, 0).x * f32(volume.max_code)), 1.0);
}
