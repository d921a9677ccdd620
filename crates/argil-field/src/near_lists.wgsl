// GPU version of NearField::new: prunes the program for the blocks of a grid, and then a block's list for its parts.

fn group_index(id: vec3<u32>, count: vec3<u32>) -> u32 {
    return id.x + count.x * id.y;
}

fn block_count() -> u32 {
    return prune.blocks_x * prune.blocks_y * prune.blocks_z;
}

// Returns where the range of a block's list is. The range of the whole program comes before.
fn block_range(block: u32) -> u32 {
    return 2u * (64u * block_count() + 1u + block);
}

// Returns the first part of a block.
fn first_part(block: u32) -> vec3<u32> {
    let x = block % prune.blocks_x;
    let y = block / prune.blocks_x % prune.blocks_y;
    return 4u * vec3(x, y, block / (prune.blocks_x * prune.blocks_y));
}

// Returns the center of some parts.
fn center_at(part: vec3<u32>, side: f32) -> vec3<f32> {
    return prune.corner + (vec3<f32>(part) + 0.5 * side) / prune.inv_edge;
}

fn put_range(at: u32, range: vec2<u32>) {
    lists[at] = range.x;
    lists[at + 1u] = range.y;
}

// Resets the list of all instructions.
@compute @workgroup_size(64)
fn begin_near_lists(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let at = group_index(id, count) * 64u + local;
    let length = arrayLength(&instructions);
    if at < length {
        lists[prune.arena_first + at] = at;
    }
    if at == 0u {
        put_range(block_range(0u) - 2u, vec2(prune.arena_first, length));
        atomicStore(&counters[COUNTER_LISTS], length);
    }
}

@compute @workgroup_size(64)
fn prune_near_blocks(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = group_index(id, count) * 64u + local;
    if block < block_count() {
        let whole = vec2(prune.arena_first, arrayLength(&instructions));
        put_range(block_range(block), pruned(center_at(first_part(block), 4.0), whole, prune.block_margin));
    }
}

// A group has one block, so that its threads read the same list together.
@compute @workgroup_size(64)
fn prune_near_parts(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = group_index(id, count);
    if block < block_count() {
        let at = block_range(block);
        let whole = vec2(lists[at], lists[at + 1u]);
        let part = first_part(block) + vec3(local % 4u, local / 4u % 4u, local / 16u);
        put_range(2u * (64u * block + local), pruned(center_at(part, 1.0), whole, prune.part_margin));
    }
}
