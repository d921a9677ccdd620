// GPU version of build.rs and edit.rs. Blocks are built from lists that come with them. Every cell of a block is
// evaluated with its list; then the bricks that may contain the surface are sampled with lists of their own. Freed
// bricks return to the pool at the end.

// Words of a cell's list: where it begins, its length, and where its words for three points at once begin.
const CELL_LIST_WORDS: u32 = 3u;
const NO_COLUMN: u32 = 0xffffffffu;

// Bounds on distances in a block: see BLOCK_WORDS.
struct BlockBounds {
    rounding: f32,
    gap: f32,
    slack: f32,
    hidden: f32,
    isolation: f32,
    list_jump: f32,
    lipschitz: f32,
}

fn bounds_of(index: u32) -> BlockBounds {
    let at = prune.bounds_first + 7u * index;
    return BlockBounds(
        bitcast<f32>(lists[at]),
        bitcast<f32>(lists[at + 1u]),
        bitcast<f32>(lists[at + 2u]),
        bitcast<f32>(lists[at + 3u]),
        bitcast<f32>(lists[at + 4u]),
        bitcast<f32>(lists[at + 5u]),
        bitcast<f32>(lists[at + 6u]),
    );
}

// GPU version of ClearanceModel::radius: the radius around a point at distance `d` without a surface.
fn plain_radius(d: f32, bounds: BlockBounds) -> f32 {
    return (d - bounds.rounding) / (1.00001 * bounds.lipschitz);
}

// The same for distances that can jump.
fn jumping_radius(d: f32, bounds: BlockBounds) -> f32 {
    let left = d - (bounds.rounding + bounds.slack);
    let steepness = 1.00001 * bounds.lipschitz;
    let plain = left / steepness;
    return select(max(bounds.isolation, (left - bounds.hidden) / steepness), plain, plain <= bounds.isolation);
}

// GPU version of Bounds::is_clear.
fn is_clear(d: f32, bounds: BlockBounds, radius: f32) -> bool {
    let near = min(abs(d), volume.far);
    return select(jumping_radius(near, bounds), plain_radius(near, bounds), bounds.gap > 0.0) > radius;
}

// GPU version of Bounds::center: the word of an empty cell, from the distance at its center.
fn center_word(d: f32, bounds: BlockBounds) -> u32 {
    let jumping = max(jumping_radius(min(abs(d), volume.far), bounds), bounds.gap);
    let clear = min(plain_radius(abs(d), bounds), jumping);
    let left = clamp(clear * bounds.lipschitz, 0.0, volume.far);
    return empty_word(select(left, -left, d < 0.0));
}

fn group_index(id: vec3<u32>, count: vec3<u32>) -> u32 {
    return id.x + count.x * id.y;
}

fn list_range_at(at: u32) -> vec2<u32> {
    return vec2(lists[at], lists[at + 1u]);
}

// Returns the slot of a block.
fn block_of(index: u32) -> u32 {
    return lists[prune.blocks_at + index];
}

// Returns the number of a cell near the surface among all evaluated cells, and its previous word.
fn near_cell(index: u32) -> vec2<u32> {
    return vec2(near_cells[2u * index], near_cells[2u * index + 1u]);
}

// Returns where the number of a cell among those near the surface is, counted from 1.
fn candidate_place(measured: u32) -> u32 {
    return prune.freed_first + 2u * 64u * prune.count + measured;
}

// Returns the index of a cell's word.
fn cell_index_of(measured: u32) -> u32 {
    return block_of(measured / 64u) * 64u + measured % 64u;
}

// Returns a list.
fn list_range_of(index: u32) -> vec2<u32> {
    if index < prune.cells_room {
        return list_range_at(prune.cells_first + CELL_LIST_WORDS * index);
    }
    return list_range_at(prune.blocks_first + 2u * (near_cell(index).x / 64u));
}

// Returns where a list's words for three points at once begin, or NO_COLUMN.
fn column_first_of(index: u32) -> u32 {
    if index < prune.cells_room {
        return lists[prune.cells_first + CELL_LIST_WORDS * index + 2u];
    }
    return NO_COLUMN;
}

// Takes a slot of the pool, or of the materials of mixed bricks. Free slots come first.
fn take_brick() -> u32 {
    let index = atomicAdd(&counters[COUNTER_BRICKS], 1u);
    let free = atomicLoad(&counters[COUNTER_FREE]);
    if index < free {
        return atomicLoad(&counters[COUNTERS + free - 1u - index]);
    }
    return atomicLoad(&counters[COUNTER_HIGH_WATER]) + index - free;
}

fn take_mixed() -> u32 {
    let index = atomicAdd(&counters[COUNTER_MIXED], 1u);
    let free = atomicLoad(&counters[COUNTER_FREE_MIXED]);
    if index < free {
        return atomicLoad(&counters[COUNTERS + volume.capacity + free - 1u - index]);
    }
    return atomicLoad(&counters[COUNTER_HIGH_WATER_MIXED]) + index - free;
}

// They return to the pool when all bricks are built.
fn free_mixed(look: u32) {
    if (look & BRICK_MIXED) != 0u {
        let place = atomicAdd(&counters[COUNTER_FREED_MIXED], 1u);
        near_cells[prune.freed_first + prune.count * 64u + place] = look & ~BRICK_MIXED;
    }
}

fn free_brick(word: u32) {
    let number = brick_number(word);
    let place = atomicAdd(&counters[COUNTER_FREED], 1u);
    near_cells[prune.freed_first + place] = number;
    atomicAdd(&counters[COUNTER_REMOVED], 1u);
    free_mixed(brick_materials[number]);
}
