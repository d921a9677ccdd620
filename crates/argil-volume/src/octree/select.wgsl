// Twin of select.rs. `volume` is the bound uniform.

fn cell_is_held(cell: vec3<u32>) -> bool {
    return cell.x < volume.grid_x && cell.y < volume.grid_y && cell.z < volume.grid_z;
}

// The distance at a cell's center, kept for the cells that stay without a brick; whether the cell gets one.
fn measure_cell(code: u32) -> bool {
    let cell = cell_of(code);
    if code >= volume.code_count || !cell_is_held(cell) {
        return false;
    }
    let edge = f32(volume.brick) * volume.voxel;
    let d = field_distance(volume.corner + (vec3<f32>(cell) + 0.5) * edge);
    centers[code] = d;
    return abs(d) <= volume.reach;
}

// One thread a code: a bit for each brick, in Morton order.
@compute @workgroup_size(64)
fn select_bits(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let code = id.y * groups.x * 64u + id.x;
    if measure_cell(code) {
        atomicOr(&occupied[code >> 5u], 1u << (code & 31u));
    }
}

// The study's way: bricks in any order, to be sorted. The list's length stands in the table's first word.
@compute @workgroup_size(64)
fn select_list(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let code = id.y * groups.x * 64u + id.x;
    if measure_cell(code) {
        atomicStore(&occupied[atomicAdd(&tree_words[TREE_BRICKS], 1u)], code);
    }
}
