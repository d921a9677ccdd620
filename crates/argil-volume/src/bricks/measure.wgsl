// GPU version of candidates.rs: evaluates cells with the lists of their blocks.

// GPU version of is_clear_in_parts: whether no part of a cell contains a surface, by the list.
fn is_clear_in_parts(corner: vec3<f32>, edge: f32, bounds: BlockBounds) -> bool {
    for (var i = 0u; i < 64u; i++) {
        let d = field_distance(corner + (vec3<f32>(inner_cell(i)) + 0.5) * (edge / 4.0));
        if !is_clear(d, bounds, volume.max_center_distance / 4.0) {
            return false;
        }
    }
    return true;
}

// Writes the words of empty cells, and lists the others.
@compute @workgroup_size(64)
fn measure(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let job = group_index(id, count);
    if job >= prune.count {
        return;
    }
    let index = block_of(job) * 64u + local;
    let at = volume.table.words_at + index;
    let first = first_cell(index / 64u);
    let cell = first + inner_cell(local);
    let edge = f32(volume.brick_size_voxels) * volume.voxel_size;
    if (any(cell < low_cell()) || any(cell >= high_cell())) && volume.is_clipped != 0u {
        cells[at] = empty_word(0.0);
        return;
    }
    list = list_range_at(prune.blocks_first + 2u * job);
    let d = field_distance(volume.corner + (vec3<f32>(cell) + 0.5) * edge);
    // If the brick of a cell near the surface is dropped, this word remains.
    let bounds = bounds_of(job);
    var is_near = !is_clear(d, bounds, volume.max_center_distance);
    // Only jumps prevent that the cell is empty.
    if is_near && bounds.gap <= 0.0 && plain_radius(min(abs(d), volume.far), bounds) > volume.max_center_distance {
        is_near = !is_clear_in_parts(volume.corner + vec3<f32>(cell) * edge, edge, bounds);
    }
    let before = cells[at];
    if (lists[prune.dirty_first + 2u * job + local / 32u] & (1u << (local % 32u))) == 0u {
        // Nothing changed that a brick stores.
        if !is_brick(before) && prune.build_mode == BUILD_BLOCKS {
            cells[at] = center_word(d, bounds);
        }
        return;
    }
    if per_thread(prune.build_mode, job) == BUILD_COUNT_ONLY {
        // Any sampled brick can become a mixed one.
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
        near_cells[2u * place] = job * 64u + local;
        near_cells[2u * place + 1u] = before;
        near_cells[candidate_place(job * 64u + local)] = place + 1u;
    } else if is_brick(before) {
        free_brick(before);
    }
}
