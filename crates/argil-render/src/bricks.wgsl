// GPU version of bricks.rs, one pixel per thread. `cells` is the bound table of words, `stored` the pool of bricks.

// GPU version of nudge_for in step.rs.
fn nudge_for(u: vec3<f32>) -> f32 {
    let far = max(abs(u.x), max(abs(u.y), abs(u.z)));
    return select(0.0, NUDGE_POSITION * far * volume.voxel_size, HAS_LEVELS);
}

// The location of a point: its cell, the cell's word, and the position in the cell in voxels.
struct CellLocations {
    cell: vec3<f32>,
    inner: vec3<f32>,
    word: u32,
}

// Converts a point to voxels from the volume's corner.
fn in_voxels(p: vec3<f32>) -> vec3<f32> {
    return (p - volume.corner) * (1.0 / volume.voxel_size);
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
    return Held(vec3<f32>(begin), vec3<f32>(begin + size), vec3<f32>(low_cell()), vec3<f32>(high_cell() - 1), 1.0 / f32(volume.brick_size_voxels));
}

fn held_voxels(u: vec3<f32>) -> vec3<f32> {
    let held = held_box();
    return clamp(u, held.begin, held.end);
}

// Returns the cell of a position in the box.
fn cell_of_held(u: vec3<f32>, held: Held) -> vec3<f32> {
    return min(floor(u * held.per_brick), held.last);
}

fn cell_of_voxels(u: vec3<f32>) -> vec3<f32> {
    let held = held_box();
    return cell_of_held(clamp(u, held.begin, held.end), held);
}

fn inner_of(u: vec3<f32>, cell: vec3<f32>) -> vec3<f32> {
    return clamp(held_voxels(u) - cell * f32(volume.brick_size_voxels), vec3(0.0), vec3(f32(volume.brick_size_voxels)));
}

fn locate(u: vec3<f32>) -> CellLocations {
    let cell = cell_of_voxels(u);
    return CellLocations(cell, inner_of(u, cell), word_at(word_index(vec3<i32>(cell))));
}

// Interpolates the distances of a brick.
fn brick_distance(origin: vec3<f32>, inner: vec3<f32>) -> f32 {
    let uvw = (origin + inner) * volume.inv_pool_size;
    return textureSampleLevel(stored, linear, uvw, 0.0).x * volume.band_width;
}

// Returns a brick's first sample in texels, for filtering.
fn filter_origin(word: u32) -> vec3<f32> {
    return vec3<f32>(brick_origin(word)) + 0.5;
}

// GPU version of BrickSampler::empty_cell_distance: a signed lower bound on the distance, at a position in a cell without a brick.
fn away(word: u32, inner: vec3<f32>) -> f32 {
    let center = center_of(word);
    let p = inner - 0.5 * f32(volume.brick_size_voxels);
    let left = max(abs(center) - volume.slope * sqrt(p.x * p.x + p.y * p.y + p.z * p.z), 1e-30);
    return bitcast<f32>(bitcast<u32>(left) | (bitcast<u32>(center) & 0x80000000u));
}

// GPU version of BrickSampler::add_ways_out: in a large empty cube, the distance is at least that to the cube's
// sides plus the bound there.
fn empty_distance_in(slot: u32, u: vec3<f32>, plain: f32, word: u32) -> f32 {
    if !HAS_LEVELS || slot >= FAR_SLOTS || slot < 2u {
        return plain;
    }
    let edge = f32(far_cells(slot) * volume.brick_size_voxels);
    let begin = floor(u / edge) * edge;
    let low = u - begin;
    let high = begin + edge - u;
    let way = max(min(min(min(low.x, low.y), low.z), min(min(high.x, high.y), high.z)), 0.0) * volume.voxel_size;
    let center = center_of(word);
    return select(center + way, center - way, center < 0.0);
}

// Returns a signed lower bound on the distance around a point. It is never 0, so that its sign is known.
fn brick_clearance(p: vec3<f32>) -> f32 {
    let u = held_voxels(in_voxels(p));
    let cell = cell_of_voxels(u);
    let index = word_index(vec3<i32>(cell));
    let at = CellLocations(cell, inner_of(u, cell), word_at(index));
    if !is_brick(at.word) {
        return empty_distance_in(index / 64u, u, away(at.word, at.inner), at.word);
    }
    let d = brick_distance(filter_origin(at.word), at.inner);
    let length = max(abs(d) - 0.8660254 * volume.voxel_size, 1e-30);
    return select(length, -length, d < 0.0);
}

fn cone_clearance(p: vec3<f32>, t: f32) -> vec2<f32> {
    return vec2(brick_clearance(p), volume.voxel_size);
}

fn cone_box_min() -> vec3<f32> {
    return volume.corner + volume.voxel_size * held_box().begin;
}

fn cone_box_max() -> vec3<f32> {
    return volume.corner + volume.voxel_size * held_box().end;
}
