// GPU version of brick_baker.rs: samples bricks.

var<workgroup> nearest: atomic<u32>;
var<workgroup> slot: u32;
// Samples that a thread keeps until the group decides whether the brick is needed.
var<private> own: array<f32, SAMPLES_PER_THREAD>;

fn sample_point(cell: vec3<i32>, i: u32) -> vec3<f32> {
    let side = volume.brick_size_voxels + 1u;
    let place = vec3(i % side, i / side % side, i / side / side);
    return volume.corner + volume.voxel_size * (vec3<f32>(cell * i32(volume.brick_size_voxels)) + vec3<f32>(place));
}

// One brick per group, unless it cannot contain a surface.
@compute @workgroup_size(BRICK_GROUP)
fn fill_bricks(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let near = near_cell(fill.first_layer + id.x);
    let at = cell_index_of(near.x);
    list = list_range_of(fill.first_layer + id.x);
    let cell = cell_at(at);
    let side = volume.brick_size_voxels + 1u;
    let samples = side * side * side;
    if local == 0u {
        atomicStore(&nearest, 0xffffffffu);
    }
    workgroupBarrier();
    var n = 0u;
    var mine = 0xffffffffu;
    for (var i = local; i < samples; i += BRICK_GROUP) {
        let d = field_distance(sample_point(cell, i));
        own[n] = d;
        n++;
        // Ordered by magnitude, with the sign in the lowest bit.
        let bits = bitcast<u32>(d);
        mine = min(mine, (bits << 1u) | (bits >> 31u));
    }
    atomicMin(&nearest, mine);
    workgroupBarrier();
    if local == 0u {
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
    workgroupBarrier();
    if slot >= volume.capacity {
        return;
    }
    let origin = brick_origin(word_at(at));
    n = 0u;
    for (var i = local; i < samples; i += BRICK_GROUP) {
        textureStore(texels, origin + vec3(i % side, i / side % side, i / side / side), encode(own[n]));
        n++;
    }
}
