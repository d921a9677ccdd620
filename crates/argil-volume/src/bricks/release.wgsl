// Marks empty blocks, and returns freed bricks to the pool.

// Marks empty blocks, one per thread.
@compute @workgroup_size(64)
fn mark_empty_blocks(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let index = group_index(id, count) * 64u + local;
    if index >= prune.count {
        return;
    }
    let block = block_of(index);
    var found = false;
    for (var i = 0u; i < 64u; i++) {
        found = found || is_brick(word_at(block * 64u + i));
    }
    if !found {
        for (var i = 0u; i < 64u; i++) {
            cells[volume.table.words_at + block * 64u + i] |= WORD_BLOCK_EMPTY;
        }
    }
}

// Replaces taken slots on the stack with freed ones, for bricks or mixed bricks. Returns the number of free slots.
fn update_free_slots(kind: u32, local: u32) -> u32 {
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

// Removes taken slots from the free list and adds freed ones, in one group.
@compute @workgroup_size(64)
fn release_freed(@builtin(local_invocation_index) local: u32) {
    let free = vec2(update_free_slots(0u, local), update_free_slots(1u, local));
    storageBarrier();
    if local < 2u {
        let taken = atomicLoad(&counters[COUNTER_BRICKS + local]);
        let reused = min(taken, atomicLoad(&counters[COUNTER_FREE + local]));
        atomicAdd(&counters[COUNTER_HIGH_WATER + local], taken - reused);
        atomicStore(&counters[COUNTER_FREE + local], free[local]);
    }
}
