// GPU version of light.rs: distances in the air and materials of levels, for lighting.

var<private> light_slot: u32 = 0u;

// GPU version of LevelSampler::locate_bricks.
fn locate_brick(p: vec3<f32>, voxels: f32) -> LevelCell {
    let away = p - frame.eye;
    let wanted = level_of(voxels * volume.pixel_error * frame.pixel_width * length(away));
    let found = locate(away, wanted, light_slot);
    light_slot = found.cell / 8u;
    return brick_above(found, away);
}

fn light_distance(p: vec3<f32>) -> f32 {
    let found = locate_brick(p, LIGHT_VOXELS);
    note(found);
    let in_brick = is_brick(found.word);
    let d = brick_distance(select(0u, found.word, in_brick), found.inner, found.voxel);
    return select(center_of(found.word), d, in_brick);
}

fn light_lift(length: f32) -> f32 {
    return max(frame.light_offset, LIFT_VOXELS * volume.pixel_error * frame.pixel_width * length);
}

fn light_step(length: f32) -> f32 {
    return max(2.0 * frame.epsilon, MIN_STEP_VOXELS * LIGHT_VOXELS * volume.pixel_error * frame.pixel_width * length);
}

// GPU version of LevelSampler::material. The field provides what bricks do not store, in a pass of its own.
fn surface_material(p: vec3<f32>, outward: vec3<f32>) -> GpuMaterial {
    return brick_material(locate_brick(p, 1.0), outward);
}
