// Twin of build.rs and edit.rs. Blocks are made by lists that come with them. Every cell of a block is measured by its list; then the bricks that the surface can be
// in are sampled by lists of their own. What is freed is given back to the pool when all are made.

// Cells a group measures, and threads that sample a brick.
override BRICK_GROUP: u32 = 256u;

// What is known of distances in the nth block that is made: see BLOCK_WORDS.
struct BlockBounds {
    rounding: f32,
    gap: f32,
    slack: f32,
    hidden: f32,
    isolation: f32,
    list_jump: f32,
}

fn bounds_of(nth: u32) -> BlockBounds {
    let at = prune.bounds_first + 6u * nth;
    return BlockBounds(
        bitcast<f32>(lists[at]),
        bitcast<f32>(lists[at + 1u]),
        bitcast<f32>(lists[at + 2u]),
        bitcast<f32>(lists[at + 3u]),
        bitcast<f32>(lists[at + 4u]),
        bitcast<f32>(lists[at + 5u]),
    );
}

// Twin of ClearTerms::radius: how far around a point there is no surface that is `d` from it.
fn plain_radius(d: f32, bounds: BlockBounds) -> f32 {
    return (d - bounds.rounding) / volume.steepness;
}

// The same where something jumps.
fn jumping_radius(d: f32, bounds: BlockBounds) -> f32 {
    let left = d - (bounds.rounding + bounds.slack);
    let plain = left / volume.steepness;
    return select(max(bounds.isolation, (left - bounds.hidden) / volume.steepness), plain, plain <= bounds.isolation);
}

// Twin of Bounds::is_clear.
fn is_clear(d: f32, bounds: BlockBounds, radius: f32) -> bool {
    let near = min(abs(d), volume.far);
    return select(jumping_radius(near, bounds), plain_radius(near, bounds), bounds.gap > 0.0) > radius;
}

// Twin of Bounds::center: the word of an empty cell whose centre is so far.
fn center_word(d: f32, bounds: BlockBounds) -> u32 {
    let jumping = max(jumping_radius(min(abs(d), volume.far), bounds), bounds.gap);
    let clear = min(plain_radius(abs(d), bounds), jumping);
    let left = clamp(clear * volume.lipschitz, 0.0, volume.far);
    return empty_word(select(left, -left, d < 0.0));
}

fn group_index(id: vec3<u32>, count: vec3<u32>) -> u32 {
    return id.x + count.x * id.y;
}

fn stretch_at(at: u32) -> vec2<u32> {
    return vec2(lists[at], lists[at + 1u]);
}

fn keep_stretch(at: u32, stretch: vec2<u32>) {
    lists[at] = stretch.x;
    lists[at + 1u] = stretch.y;
}

// The slot of the nth block that is made.
fn block_of(nth: u32) -> u32 {
    return lists[prune.blocks_at + nth];
}

// Of a cell that the surface can be in: which one it is of all that are measured, and what its word was.
fn near_cell(nth: u32) -> vec2<u32> {
    return vec2(near_cells[2u * nth], near_cells[2u * nth + 1u]);
}

// Where its word stands among those of slots.
fn place_of(measured: u32) -> u32 {
    return block_of(measured / 64u) * 64u + measured % 64u;
}

// The list of the nth.
fn stretch_of(nth: u32) -> vec2<u32> {
    if nth < prune.cells_room {
        return stretch_at(prune.cells_first + 2u * nth);
    }
    return stretch_at(prune.blocks_first + 2u * (near_cell(nth).x / 64u));
}

// A place of the pool, and the same of a mixed brick's materials: free ones first.
fn take_brick() -> u32 {
    let nth = atomicAdd(&counters[COUNTER_BRICKS], 1u);
    let free = atomicLoad(&counters[COUNTER_FREE]);
    if nth < free {
        return atomicLoad(&counters[COUNTERS + free - 1u - nth]);
    }
    return atomicLoad(&counters[COUNTER_TOP]) + nth - free;
}

fn take_mixed() -> u32 {
    let nth = atomicAdd(&counters[COUNTER_MIXED], 1u);
    let free = atomicLoad(&counters[COUNTER_FREE_MIXED]);
    if nth < free {
        return atomicLoad(&counters[COUNTERS + volume.capacity + free - 1u - nth]);
    }
    return atomicLoad(&counters[COUNTER_TOP_MIXED]) + nth - free;
}

// They are given back when all bricks are made.
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

// What is left of a list in `side` cells from one on.
fn pruned_in(cell: vec3<i32>, side: u32, whole: vec2<u32>, jump: f32) -> vec2<u32> {
    let edge = f32(volume.brick) * volume.extent_voxel.w;
    let center = volume.corner_range.xyz + (vec3<f32>(cell) + 0.5 * f32(side)) * edge;
    let change = 1.00001 * volume.lipschitz * volume.reach * f32(side);
    return pruned(center, whole, 2.0 * (change + prune.slack + jump));
}

// The list of all instructions; nothing is counted yet.
@compute @workgroup_size(64)
fn begin_lists(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let at = group_index(id, count) * 64u + local;
    if at < arrayLength(&instrs) {
        lists[prune.arena_first + at] = at;
    }
    if at == 0u {
        atomicStore(&counters[COUNTER_LISTS], arrayLength(&instrs));
        atomicStore(&counters[COUNTER_CANDIDATES], 0u);
        atomicStore(&counters[COUNTER_BRICKS], 0u);
        atomicStore(&counters[COUNTER_MIXED], 0u);
        atomicStore(&counters[COUNTER_FREED], 0u);
        atomicStore(&counters[COUNTER_FREED_MIXED], 0u);
    }
}

// The lists of cells that the surface can be in.
@compute @workgroup_size(64)
fn prune_cells(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let nth = fill.first_layer + 64u * id.x + local;
    if nth >= min(fill.first_layer + volume.chunk, atomicLoad(&counters[COUNTER_CANDIDATES])) || nth >= prune.cells_room {
        return;
    }
    let measured = near_cell(nth).x;
    let block = measured / 64u;
    let whole = stretch_at(prune.blocks_first + 2u * block);
    let jump = bounds_of(block).list_jump;
    keep_stretch(prune.cells_first + 2u * nth, pruned_in(cell_at(place_of(measured)), 1u, whole, jump));
}

// Twin of is_clear_in_parts: whether no part of a cell has a surface, by the list.
fn is_clear_in_parts(corner: vec3<f32>, edge: f32, bounds: BlockBounds) -> bool {
    for (var i = 0u; i < 64u; i++) {
        let d = field_distance(corner + (vec3<f32>(inner_cell(i)) + 0.5) * (edge / 4.0));
        if !is_clear(d, bounds, volume.reach / 4.0) {
            return false;
        }
    }
    return true;
}

// The words of empty cells, and a list of the others.
@compute @workgroup_size(64)
fn measure(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let nth = group_index(id, count);
    if nth >= prune.count {
        return;
    }
    let index = block_of(nth) * 64u + local;
    let at = volume.words_at + index;
    let first = first_cell(index / 64u);
    let cell = first + inner_cell(local);
    let edge = f32(volume.brick) * volume.extent_voxel.w;
    if volume.is_cut != 0u && (any(cell < low_cell()) || any(cell >= high_cell())) {
        cells[at] = empty_word(0.0);
        return;
    }
    list = stretch_at(prune.blocks_first + 2u * nth);
    let d = field_distance(volume.corner_range.xyz + (vec3<f32>(cell) + 0.5) * edge);
    // Of a cell near the surface, what stays if its brick is dropped.
    let bounds = bounds_of(nth);
    var is_near = !is_clear(d, bounds, volume.reach);
    // Only what jumps is in the way.
    if is_near && bounds.gap <= 0.0 && plain_radius(min(abs(d), volume.far), bounds) > volume.reach {
        is_near = !is_clear_in_parts(volume.corner_range.xyz + vec3<f32>(cell) * edge, edge, bounds);
    }
    let before = cells[at];
    if (lists[prune.dirty_first + 2u * nth + local / 32u] & (1u << (local % 32u))) == 0u {
        // Nothing changed that a brick holds.
        if !is_brick(before) && prune.make == MAKE_SOME {
            cells[at] = center_word(d, bounds);
        }
        return;
    }
    if prune.make == MAKE_NONE {
        // Any brick that is sampled can become a mixed one.
        if is_near {
            atomicAdd(&counters[COUNTER_MIXED], 1u);
            if !is_brick(before) {
                atomicAdd(&counters[COUNTER_BRICKS], 1u);
            }
        }
        return;
    }
    cells[at] = center_word(d, bounds);
    if is_near {
        let place = atomicAdd(&counters[COUNTER_CANDIDATES], 1u);
        near_cells[2u * place] = nth * 64u + local;
        near_cells[2u * place + 1u] = before;
    } else if is_brick(before) {
        free_brick(before);
    }
}

// How many groups each dispatch of `fill_bricks` has, and of `prune_cells`.
@compute @workgroup_size(64)
fn plan(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= volume.chunks {
        return;
    }
    let found = atomicLoad(&counters[COUNTER_CANDIDATES]);
    let first = id.x * volume.chunk;
    let own = clamp(found, first, first + volume.chunk) - first;
    let at = 6u * id.x;
    arguments[at] = own;
    arguments[at + 1u] = 1u;
    arguments[at + 2u] = 1u;
    arguments[at + 3u] = (own + 63u) / 64u;
    arguments[at + 4u] = 1u;
    arguments[at + 5u] = 1u;
}

var<workgroup> nearest: atomic<u32>;
var<workgroup> slot: u32;
// The samples that a thread keeps while the group makes up its mind.
var<private> own: array<f32, 20>;

fn sample_point(cell: vec3<i32>, i: u32) -> vec3<f32> {
    let side = volume.brick + 1u;
    let place = vec3(i % side, i / side % side, i / side / side);
    return volume.corner_range.xyz + volume.extent_voxel.w * (vec3<f32>(cell * i32(volume.brick)) + vec3<f32>(place));
}

// A brick a group, unless no surface can be in it.
@compute @workgroup_size(BRICK_GROUP)
fn fill_bricks(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let near = near_cell(fill.first_layer + id.x);
    let at = place_of(near.x);
    list = stretch_of(fill.first_layer + id.x);
    let cell = cell_at(at);
    let side = volume.brick + 1u;
    let samples = side * side * side;
    if local == 0u {
        atomicStore(&nearest, 0xffffffffu);
    }
    workgroupBarrier();
    var n = 0u;
    for (var i = local; i < samples; i += BRICK_GROUP) {
        let d = field_distance(sample_point(cell, i));
        own[n] = d;
        n++;
        // Ordered by length, the sign in the lowest bit.
        let bits = bitcast<u32>(d);
        atomicMin(&nearest, (bits << 1u) | (bits >> 31u));
    }
    workgroupBarrier();
    if local == 0u {
        let bits = atomicLoad(&nearest);
        let least = bitcast<f32>((bits >> 1u) | (bits << 31u));
        slot = 0xffffffffu;
        let had_one = is_brick(near.y);
        if !is_clear(least, bounds_of(near.x / 64u), volume.spread) {
            atomicAdd(&counters[COUNTER_FILLED], 1u);
            if had_one {
                slot = brick_number(near.y);
            } else {
                slot = take_brick();
                atomicAdd(&counters[COUNTER_ADDED], 1u);
            }
            if slot < volume.capacity {
                cells[volume.words_at + at] = brick_word(slot);
            }
        } else if had_one {
            free_brick(near.y);
        }
    }
    workgroupBarrier();
    if slot >= volume.capacity {
        return;
    }
    let origin = brick_origin(word_at(at));
    n = 0u;
    for (var i = local; i < samples; i += BRICK_GROUP) {
        textureStore(texels, origin + vec3(i % side, i / side % side, i / side / side), encode(own[n]));
        n++;
    }
}

var<workgroup> first_packed: vec2<u32>;
var<workgroup> differing: atomic<u32>;
var<workgroup> first_place: atomic<u32>;
var<workgroup> look: u32;

// What a brick looks like: a brick a group, a place a thread.
@compute @workgroup_size(BRICK_GROUP)
fn fill_materials(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let near = near_cell(fill.first_layer + id.x);
    let at = place_of(near.x);
    list = stretch_of(fill.first_layer + id.x);
    let word = word_at(at);
    let cell = cell_at(at);
    let is_there = is_brick(word);
    let is_place = is_there && local < MATERIAL_SIDE * MATERIAL_SIDE * MATERIAL_SIDE;
    let place = vec3(local % MATERIAL_SIDE, local / MATERIAL_SIDE % MATERIAL_SIDE, local / MATERIAL_SIDE / MATERIAL_SIDE);
    let inner = vec3<f32>(place) * (f32(volume.brick) / f32(MATERIAL_SIDE - 1u));
    var mine = vec2(0u);
    var is_near = false;
    var is_told = true;
    if is_place {
        let d = field_surface(volume.corner_range.xyz + volume.extent_voxel.w * (vec3<f32>(cell * i32(volume.brick)) + inner));
        mine = pack_material(field_material);
        // Between places that are farther from the surface than the diagonal from one to the next, there is none.
        let step = f32(volume.brick) / f32(MATERIAL_SIDE - 1u);
        let reach = 1.01 * volume.lipschitz * 1.7320508 * step * volume.extent_voxel.w;
        is_near = abs(d) <= reach;
        is_told = abs(d) <= MATERIAL_TOLD * reach;
    }
    if local == 0u {
        atomicStore(&first_place, 0xffffffffu);
        atomicStore(&differing, 0u);
    }
    workgroupBarrier();
    if is_near {
        atomicMin(&first_place, local);
    }
    workgroupBarrier();
    // Where no place is near, all of them count.
    let has_near = atomicLoad(&first_place) != 0xffffffffu;
    workgroupBarrier();
    if !has_near {
        is_told = true;
        is_near = is_place;
        if is_place {
            atomicMin(&first_place, local);
        }
    }
    workgroupBarrier();
    let first = atomicLoad(&first_place);
    if local == first {
        first_packed = mine;
    }
    workgroupBarrier();
    if first == 0xffffffffu || (is_near && any(mine != first_packed)) {
        atomicStore(&differing, 1u);
    }
    workgroupBarrier();
    if local == 0u && is_there {
        look = BRICK_MIXED;
        if atomicLoad(&differing) == 0u {
            for (var i = 0u; i < arrayLength(&materials); i++) {
                if look == BRICK_MIXED && all(pack_material(materials[i]) == first_packed) {
                    look = i;
                }
            }
        }
        let number = brick_number(word);
        var before = 0u;
        if is_brick(near.y) {
            before = brick_materials[number];
        }
        if look == BRICK_MIXED {
            if (before & BRICK_MIXED) != 0u {
                look = before;
            } else {
                look = BRICK_MIXED | take_mixed();
            }
        } else {
            free_mixed(before);
        }
        brick_materials[number] = look;
    }
    workgroupBarrier();
    let block = look & ~BRICK_MIXED;
    if is_place && (look & BRICK_MIXED) != 0u && block < volume.mixed {
        let to = volume.capacity + 2u * (block * MATERIAL_SIDE * MATERIAL_SIDE * MATERIAL_SIDE + local);
        // Lists do not tell what is so far that none of it is looked at.
        let kept = select(first_packed, mine, is_told);
        brick_materials[to] = kept.x;
        brick_materials[to + 1u] = kept.y;
    }
}

// Marks what is empty: one thread a block.
@compute @workgroup_size(64)
fn settle(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let nth = group_index(id, count) * 64u + local;
    if nth >= prune.count {
        return;
    }
    let block = block_of(nth);
    var found = false;
    for (var i = 0u; i < 64u; i++) {
        found = found || is_brick(word_at(block * 64u + i));
    }
    if !found {
        for (var i = 0u; i < 64u; i++) {
            cells[volume.words_at + block * 64u + i] |= WORD_LONELY;
        }
    }
}

// Bricks, or mixed ones: stack what was freed in place of what was taken; how many are free then.
fn restack(kind: u32, local: u32) -> u32 {
    let free = atomicLoad(&counters[COUNTER_FREE + kind]);
    let freed = atomicLoad(&counters[COUNTER_FREED + kind]);
    let left = free - min(atomicLoad(&counters[COUNTER_BRICKS + kind]), free);
    let to = COUNTERS + kind * volume.capacity + left;
    let begin = prune.freed_first + kind * prune.count * 64u;
    for (var i = local; i < freed; i += 64u) {
        atomicStore(&counters[to + i], near_cells[begin + i]);
    }
    return left + freed;
}

// What was taken from the pool is gone from it, and what was freed is there again: one group.
@compute @workgroup_size(64)
fn give_back(@builtin(local_invocation_index) local: u32) {
    let free = vec2(restack(0u, local), restack(1u, local));
    storageBarrier();
    if local < 2u {
        let taken = atomicLoad(&counters[COUNTER_BRICKS + local]);
        let reused = min(taken, atomicLoad(&counters[COUNTER_FREE + local]));
        atomicAdd(&counters[COUNTER_TOP + local], taken - reused);
        atomicStore(&counters[COUNTER_FREE + local], free[local]);
    }
}
