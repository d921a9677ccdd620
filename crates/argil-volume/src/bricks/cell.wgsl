// GPU version of cell.rs: the meaning of a cell's word. A brick's word is its position in the pool along x, y and
// z, ten bits each.

fn empty_word(center: f32) -> u32 {
    return WORD_EMPTY | ((bitcast<u32>(center) >> 1u) & ~WORD_BLOCK_EMPTY);
}

fn is_brick(word: u32) -> bool {
    return (word & WORD_EMPTY) == 0u;
}

fn is_block_empty(word: u32) -> bool {
    return (word & WORD_BLOCK_EMPTY) != 0u;
}

fn center_of(word: u32) -> f32 {
    return bitcast<f32>((word & ~WORD_BLOCK_EMPTY) << 1u);
}

// Entries of the tree of blocks, see table.rs: the top level comes first in `cells`, then its nodes.

// Whether the table may have levels below its top.
override HAS_LEVELS: bool = true;

fn low_cell() -> vec3<i32> {
    return vec3(volume.low_x, volume.low_y, volume.low_z);
}

fn high_cell() -> vec3<i32> {
    return vec3(volume.high_x, volume.high_y, volume.high_z);
}

// GPU version of BlockTable::slot, for blocks in the box.
fn slot_of(block: vec3<i32>) -> u32 {
    let at = vec3<u32>(block - vec3(volume.table.tree_x, volume.table.tree_y, volume.table.tree_z));
    let top = at >> vec3(select(0u, 3u * volume.table.levels, HAS_LEVELS));
    var entry = cells[top.x + volume.table.top_x * (top.y + volume.table.top_y * top.z)];
    if HAS_LEVELS {
        for (var level = volume.table.levels; level > 0u && (entry & FAR_ENTRY) == 0u; level--) {
            let inner = (at >> vec3(3u * (level - 1u))) & vec3(7u);
            entry = cells[entry + inner.x + 8u * inner.y + 64u * inner.z];
        }
    }
    return entry & ~FAR_ENTRY;
}

// GPU version of Bricks::word_index: the index of a cell's word.
fn word_index(cell: vec3<i32>) -> u32 {
    return index_in(slot_of(cell >> vec3(2u)), cell);
}

// The index of the word of a cell in the block of a slot.
fn index_in(slot: u32, cell: vec3<i32>) -> u32 {
    let inner = vec3<u32>(cell & vec3(3));
    return slot * 64u + inner.x + 4u * inner.y + 16u * inner.z;
}

fn word_at(index: u32) -> u32 {
    return cells[volume.table.words_at + index];
}

fn inner_cell(index: u32) -> vec3<i32> {
    return vec3<i32>(vec3(index % 4u, index / 4u % 4u, index / 16u));
}

fn first_cell(slot: u32) -> vec3<i32> {
    let at = volume.table.slots_at + 3u * slot;
    return bitcast<vec3<i32>>(vec3(cells[at], cells[at + 1u], cells[at + 2u]));
}

// GPU version of Bricks::cell_at.
fn cell_at(index: u32) -> vec3<i32> {
    return first_cell(index / 64u) + inner_cell(index % 64u);
}

// GPU version of BlockTable::far_cells: the side, in cells, of the empty cube of a slot without a block.
fn far_cells(slot: u32) -> u32 {
    return BLOCK_SIDE << (3u * (slot / 2u));
}

// Returns the word of a brick, from its index in the pool.
fn brick_word(brick: u32) -> u32 {
    return (brick % volume.pool_x) | ((brick / volume.pool_x % volume.pool_y) << 10u) | ((brick / volume.pool_x / volume.pool_y) << 20u);
}

// Returns a brick's first texel in the pool.
fn brick_origin(word: u32) -> vec3<u32> {
    return (volume.brick_size_voxels + 1u) * vec3(word & 1023u, (word >> 10u) & 1023u, word >> 20u);
}
