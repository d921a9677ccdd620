// Marches of the blocks of pixels that their cones list, one group per block. `march_pixel` depends on the volume.

// Returns the pixel of a thread in a listed block.
fn listed_pixel(group: u32, local: vec3<u32>) -> vec2<u32> {
    let place = live.blocks[group].place;
    let across = (frame.width + CONE_SIDE - 1u) / CONE_SIDE;
    return vec2(place % across, place / across) * CONE_SIDE + local.xy;
}

fn march_listed(group: u32, local: vec3<u32>, shows: bool) {
    let pixel = listed_pixel(group, local);
    if pixel.x >= frame.width || pixel.y >= frame.height {
        return;
    }
    let place = live.blocks[group].place;
    let cone_steps = select(0u, live.blocks[place].steps, local.x == 0u && local.y == 0u);
    march_pixel(pixel.x, pixel.y, place, cone_steps, shows);
}

@compute @workgroup_size(8, 8)
fn march(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    march_listed(group.x, local, false);
}

@compute @workgroup_size(8, 8)
fn march_and_show(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    march_listed(group.x, local, true);
}
