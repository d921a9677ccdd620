// GPU version of select.rs. `volume` is the bound uniform.

fn cell_is_held(cell: vec3<u32>) -> bool {
    return cell.x < volume.grid_x && cell.y < volume.grid_y && cell.z < volume.grid_z;
}

// Evaluates the distance at a cell's center, which cells without a brick keep. Returns true if the cell gets a
// brick.
fn measure_cell(code: u32) -> bool {
    let cell = cell_of(code);
    if code >= volume.code_count || !cell_is_held(cell) {
        return false;
    }
    let edge = f32(volume.brick_size_voxels) * volume.voxel_size;
    let d = field_distance(volume.corner + (vec3<f32>(cell) + 0.5) * edge);
    centers[code] = d;
    return abs(d) <= volume.max_center_distance;
}

// One Morton code per thread: one bit per brick, in Morton order.
@compute @workgroup_size(64)
fn select_bits(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let code = id.y * groups.x * 64u + id.x;
    if measure_cell(code) {
        atomicOr(&occupied[code >> 5u], 1u << (code & 31u));
    }
}

// The study's version: an unordered list of bricks, which is then sorted. Its length is the first word of the
// table.
@compute @workgroup_size(64)
fn select_list(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let code = id.y * groups.x * 64u + id.x;
    if measure_cell(code) {
        atomicStore(&occupied[atomicAdd(&tree_words[OCTREE_HEADER_BRICKS], 1u)], code);
    }
}
