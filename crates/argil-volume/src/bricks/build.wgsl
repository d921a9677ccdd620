// Twin of build.rs: the grid is cut into parts, each with its list, down to blocks; every cell is measured by its block's
// list; then the bricks that the surface can be in are sampled by lists of their own.

// Cells a group measures, and threads that sample a brick.
override BRICK_GROUP: u32 = 256u;

// Twin of ClearTerms::radius: how far around a point of such a distance there is no surface.
fn clear_radius(d: f32) -> f32 {
    let left = abs(d) - volume.slack;
    let plain = left / volume.steepness;
    return select(max(volume.isolation, (left - volume.hidden) / volume.steepness), plain, plain <= volume.isolation);
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

// That of the nth cell that the surface can be in.
fn stretch_of(nth: u32) -> vec2<u32> {
    if nth < prune.cells_room {
        return stretch_at(prune.cells_first + 2u * nth);
    }
    return stretch_at(prune.blocks_first + 2u * (near_cells[nth] / 64u));
}

// What is left of a list in `side` cells from one on.
fn pruned_in(cell: vec3<u32>, side: u32, whole: vec2<u32>) -> vec2<u32> {
    let edge = f32(volume.brick) * volume.extent_voxel.w;
    let center = volume.corner_range.xyz + (vec3<f32>(cell) + 0.5 * f32(side)) * edge;
    let change = 1.00001 * volume.lipschitz * volume.reach * f32(side);
    return pruned(center, whole, 2.0 * (change + prune.slack));
}

// The list of the whole program.
@compute @workgroup_size(64)
fn begin_lists(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let at = group_index(id, count) * 64u + local;
    if at < arrayLength(&instrs) {
        lists[prune.arena_first + at] = at;
    }
    if at == 0u {
        atomicStore(&counters[COUNTER_LISTS], arrayLength(&instrs));
    }
}

// The lists of parts of the grid, from those of the greater parts that they are in.
@compute @workgroup_size(64)
fn prune_parts(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let at = group_index(id, count) * 64u + local;
    if at >= prune.parts_x * prune.parts_y * prune.parts_z {
        return;
    }
    let part = vec3(at % prune.parts_x, at / prune.parts_x % prune.parts_y, at / prune.parts_x / prune.parts_y);
    var whole = vec2(prune.arena_first, arrayLength(&instrs));
    if prune.outer_side != 0u {
        let outer = part * prune.side / prune.outer_side;
        whole = stretch_at(prune.outer_first + 2u * (outer.x + prune.outer_x * (outer.y + prune.outer_y * outer.z)));
    }
    keep_stretch(prune.first + 2u * at, pruned_in(part * prune.side, prune.side, whole));
}

// The lists of cells that the surface can be in.
@compute @workgroup_size(64)
fn prune_cells(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let nth = fill.first_layer + 64u * id.x + local;
    if nth >= min(fill.first_layer + volume.chunk, atomicLoad(&counters[COUNTER_CANDIDATES])) || nth >= prune.cells_room {
        return;
    }
    let at = near_cells[nth];
    let whole = stretch_at(prune.blocks_first + 2u * (at / 64u));
    keep_stretch(prune.cells_first + 2u * nth, pruned_in(cell_at(at), 1u, whole));
}

// The words of empty cells, and a list of the others.
@compute @workgroup_size(64)
fn measure(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let at = group_index(id, count) * 64u + local;
    if at >= volume.code_count {
        return;
    }
    let cell = cell_at(at);
    let edge = f32(volume.brick) * volume.extent_voxel.w;
    if any(cell >= vec3(volume.grid_x, volume.grid_y, volume.grid_z)) {
        words[at] = empty_word(0.0);
        return;
    }
    list = stretch_at(prune.blocks_first + 2u * (at / 64u));
    let d = field_distance(volume.corner_range.xyz + (vec3<f32>(cell) + 0.5) * edge);
    // Of a cell near the surface, what stays if its brick is dropped.
    let clear = clear_radius(d);
    let left = clamp(clear * volume.lipschitz, 0.0, volume.far);
    words[at] = empty_word(select(left, -left, d < 0.0));
    if clear <= volume.reach {
        let place = atomicAdd(&counters[COUNTER_CANDIDATES], 1u);
        near_cells[place] = at;
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

fn sample_point(cell: vec3<u32>, i: u32) -> vec3<f32> {
    let side = volume.brick + 1u;
    let place = vec3(i % side, i / side % side, i / side / side);
    return volume.corner_range.xyz + volume.extent_voxel.w * (vec3<f32>(cell * volume.brick) + vec3<f32>(place));
}

// A brick a group, unless no surface can be in it.
@compute @workgroup_size(BRICK_GROUP)
fn fill_bricks(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let at = near_cells[fill.first_layer + id.x];
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
        if clear_radius(least) <= volume.spread {
            slot = atomicAdd(&counters[COUNTER_BRICKS], 1u);
            words[at] = brick_word(slot);
        }
    }
    workgroupBarrier();
    if slot >= volume.capacity {
        return;
    }
    let origin = brick_origin(words[at]);
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
    let at = near_cells[fill.first_layer + id.x];
    list = stretch_of(fill.first_layer + id.x);
    let word = words[at];
    let cell = cell_at(at);
    let is_there = is_brick(word);
    let is_place = is_there && local < MATERIAL_SIDE * MATERIAL_SIDE * MATERIAL_SIDE;
    let place = vec3(local % MATERIAL_SIDE, local / MATERIAL_SIDE % MATERIAL_SIDE, local / MATERIAL_SIDE / MATERIAL_SIDE);
    let inner = vec3<f32>(place) * (f32(volume.brick) / f32(MATERIAL_SIDE - 1u));
    var mine = vec2(0u);
    var is_near = false;
    if is_place {
        let d = field_surface(volume.corner_range.xyz + volume.extent_voxel.w * (vec3<f32>(cell * volume.brick) + inner));
        mine = pack_material(field_material);
        // Between places that are farther from the surface than the diagonal from one to the next, there is none.
        let step = f32(volume.brick) / f32(MATERIAL_SIDE - 1u);
        is_near = abs(d) <= 1.01 * volume.lipschitz * 1.7320508 * step * volume.extent_voxel.w;
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
        if look == BRICK_MIXED {
            look = BRICK_MIXED | atomicAdd(&counters[COUNTER_MIXED], 1u);
        }
        let number = brick_number(word);
        if number < volume.capacity {
            brick_materials[number] = look;
        }
    }
    workgroupBarrier();
    let block = look & ~BRICK_MIXED;
    if is_place && (look & BRICK_MIXED) != 0u && block < volume.mixed {
        let to = volume.capacity + 2u * (block * MATERIAL_SIDE * MATERIAL_SIDE * MATERIAL_SIDE + local);
        brick_materials[to] = mine.x;
        brick_materials[to + 1u] = mine.y;
    }
}

// Marks what is empty: one thread a block.
@compute @workgroup_size(64)
fn settle(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = group_index(id, count) * 64u + local;
    if block * 64u >= volume.code_count {
        return;
    }
    var found = false;
    for (var i = 0u; i < 64u; i++) {
        found = found || is_brick(words[block * 64u + i]);
    }
    if !found {
        for (var i = 0u; i < 64u; i++) {
            words[block * 64u + i] |= WORD_LONELY;
        }
    }
}
