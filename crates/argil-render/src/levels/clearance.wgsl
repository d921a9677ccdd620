// Where the cones of blocks of pixels read distances of levels.

fn cone_box_min() -> vec3<f32> {
    return volume.box_min;
}

fn cone_box_max() -> vec3<f32> {
    return volume.box_max;
}

// Where the search for the next cell begins: a slot. Slot 0 always has a page of the coarsest level.
var<private> cone_slot: u32 = 0u;

fn cone_clearance(p: vec3<f32>, t: f32) -> vec2<f32> {
    let wanted = level_of(CONE_VOXELS * volume.pixel_error * frame.pixel_width * t);
    let found = locate(p - frame.eye, wanted, cone_slot);
    cone_slot = found.cell / 8u;
    note(found);
    let d = level_distance(found);
    let length = max(abs(d) - select(0.0, volume.error_voxels * found.voxel, is_brick(found.word)), 0.0);
    return vec2(select(length, -length, d < 0.0), found.voxel);
}
