// The records of pages, see tables.rs in argil-gpu's levels. `cells` holds the slots of the coarsest pages, a record for
// each page, and the materials of bricks.

fn record(slot: u32) -> u32 {
    return volume.records_at + RECORD_WORDS * slot;
}

fn page_level(slot: u32) -> u32 {
    return cells[record(slot) + 3u];
}

fn page_parent(slot: u32) -> u32 {
    return cells[record(slot) + 4u];
}

fn page_origin(slot: u32) -> vec3<i32> {
    let at = record(slot);
    return bitcast<vec3<i32>>(vec3(cells[at], cells[at + 1u], cells[at + 2u]));
}

fn cell_word(cell: u32) -> u32 {
    return cells[record(cell / 8u) + 8u + (cell & 7u)];
}

fn cell_child(cell: u32) -> u32 {
    return cells[record(cell / 8u) + 16u + (cell & 7u)];
}

fn is_brick(word: u32) -> bool {
    return (word & WORD_EMPTY) == 0u;
}

fn center_of(word: u32) -> f32 {
    return bitcast<f32>((word & ~WORD_BLOCK_EMPTY) << 1u);
}

fn level_scale(level: u32) -> f32 {
    return bitcast<f32>((127u + level) << 23u);
}

fn octant_of(voxel: vec3<i32>, bit: u32) -> u32 {
    let half = vec3<u32>((voxel >> vec3(bit)) & vec3(1));
    return half.x | (half.y << 1u) | (half.z << 2u);
}

fn octant_place(octant: u32) -> vec3<f32> {
    return vec3<f32>(vec3(octant & 1u, (octant >> 1u) & 1u, (octant >> 2u) & 1u));
}

fn eye_voxel() -> vec3<i32> {
    return vec3(volume.eye_x, volume.eye_y, volume.eye_z);
}
