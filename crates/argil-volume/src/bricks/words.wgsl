// Twin of words.rs: what a cell's word means. A brick's word is its place in the pool along x, y and z, ten bits each.

const WORD_EMPTY: u32 = 0x80000000u;
const WORD_LONELY: u32 = 1u;

fn empty_word(center: f32) -> u32 {
    return WORD_EMPTY | ((bitcast<u32>(center) >> 1u) & ~WORD_LONELY);
}

fn is_brick(word: u32) -> bool {
    return (word & WORD_EMPTY) == 0u;
}

fn is_lonely(word: u32) -> bool {
    return (word & WORD_LONELY) != 0u;
}

fn center_of(word: u32) -> f32 {
    return bitcast<f32>((word & ~WORD_LONELY) << 1u);
}

// Twin of BrickLayout::word_index.
fn word_index(cell: vec3<u32>) -> u32 {
    let block = cell / BLOCK_SIDE;
    let inner = cell % BLOCK_SIDE;
    let across = (vec3(volume.grid_x, volume.grid_y, volume.grid_z) + BLOCK_SIDE - 1u) / BLOCK_SIDE;
    let place = block.x + across.x * (block.y + across.y * block.z);
    return place * 64u + inner.x + 4u * inner.y + 16u * inner.z;
}

// Twin of BrickLayout::cell_at.
fn cell_at(index: u32) -> vec3<u32> {
    let block = index / 64u;
    let inner = index % 64u;
    let across = (vec3(volume.grid_x, volume.grid_y, volume.grid_z) + BLOCK_SIDE - 1u) / BLOCK_SIDE;
    let corner = vec3(block % across.x, block / across.x % across.y, block / across.x / across.y);
    return corner * BLOCK_SIDE + vec3(inner % 4u, inner / 4u % 4u, inner / 16u);
}

// The word of the brick that is so many bricks into the pool.
fn brick_word(brick: u32) -> u32 {
    return (brick % volume.pool_x) | ((brick / volume.pool_x % volume.pool_y) << 10u) | ((brick / volume.pool_x / volume.pool_y) << 20u);
}

// A brick's first texel in the pool.
fn brick_origin(word: u32) -> vec3<u32> {
    return (volume.brick + 1u) * vec3(word & 1023u, (word >> 10u) & 1023u, word >> 20u);
}
