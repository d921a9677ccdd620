// What decides whether a sampled cell needs a brick.

var<workgroup> nearest: atomic<u32>;
var<workgroup> slot: u32;

fn sample_point(cell: vec3<i32>, place: vec3<u32>) -> vec3<f32> {
    return volume.corner + volume.voxel_size * (vec3<f32>(cell * i32(volume.brick_size_voxels)) + vec3<f32>(place));
}

// Returns a number that is ordered by magnitude, with the sign in the lowest bit.
fn by_magnitude(d: f32) -> u32 {
    let bits = bitcast<u32>(d);
    return (bits << 1u) | (bits >> 31u);
}

// Gives a cell a brick, unless its samples are too far from the surface. One thread of a group does.
fn settle(near: vec2<u32>, at: u32) {
    let bits = atomicLoad(&nearest);
    let least = bitcast<f32>((bits >> 1u) | (bits << 31u));
    slot = 0xffffffffu;
    let had_brick = is_brick(near.y);
    if !is_clear(least, bounds_of(near.x / 64u), volume.half_diagonal) {
        atomicAdd(&counters[COUNTER_FILLED], 1u);
        if had_brick {
            slot = brick_number(near.y);
        } else {
            slot = take_brick();
            atomicAdd(&counters[COUNTER_ADDED], 1u);
        }
        if slot < volume.capacity {
            cells[volume.table.words_at + at] = brick_word(slot);
        }
    } else if had_brick {
        free_brick(near.y);
    }
}
