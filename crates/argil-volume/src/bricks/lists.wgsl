// The lists of cells.

// Makes the lists of cells that may contain the surface. A group has one block, so that its threads read the same list together.
@compute @workgroup_size(64)
fn prune_cells(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = group_index(id, count);
    if block >= prune.count {
        return;
    }
    // Cells that are not near the surface have 0.
    let index = near_cells[candidate_place(block * 64u + local)] - 1u;
    if index >= prune.cells_room {
        return;
    }
    let whole = list_range_at(prune.blocks_first + 2u * block);
    let jump = bounds_of(block).list_jump;
    let own = pruned_in(cell_at(cell_index_of(block * 64u + local)), 1u, whole, jump);
    let at = prune.cells_first + CELL_LIST_WORDS * index;
    lists[at] = own.x;
    lists[at + 1u] = own.y;
    lists[at + 2u] = NO_COLUMN;
    // Only a list that was pruned has been looked at.
    if any(own != whole) {
        lists[at + 2u] = column_of(own);
    }
}

// Prunes a list to `side` cells from a cell on.
fn pruned_in(cell: vec3<i32>, side: u32, whole: vec2<u32>, jump: f32) -> vec2<u32> {
    let edge = f32(volume.brick_size_voxels) * volume.voxel_size;
    let center = volume.corner + (vec3<f32>(cell) + 0.5 * f32(side)) * edge;
    let change = 1.00001 * volume.lipschitz * volume.max_center_distance * f32(side);
    return pruned(center, whole, 2.0 * (change + prune.slack + jump));
}

// Resets the list of all instructions and the counters.
@compute @workgroup_size(64)
fn begin_lists(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let at = group_index(id, count) * 64u + local;
    if at < arrayLength(&instructions) {
        lists[prune.arena_first + at] = at;
    }
    if at == 0u {
        atomicStore(&counters[COUNTER_LISTS], arrayLength(&instructions));
        atomicStore(&counters[COUNTER_CANDIDATES], 0u);
        atomicStore(&counters[COUNTER_BRICKS], 0u);
        atomicStore(&counters[COUNTER_MIXED], 0u);
        atomicStore(&counters[COUNTER_FREED], 0u);
        atomicStore(&counters[COUNTER_FREED_MIXED], 0u);
    }
}
