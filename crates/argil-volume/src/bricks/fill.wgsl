// GPU version of brick_baker.rs: samples bricks by lists of any instructions.

// Threads that sample a brick.
override BRICK_GROUP: u32 = 256u;

// Samples that a thread keeps until the group decides whether the brick is needed.
var<private> own: array<f32, SAMPLES_PER_THREAD>;

// One brick per group, unless it cannot contain a surface, or is sampled by columns.
@compute @workgroup_size(BRICK_GROUP)
fn fill_bricks(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let index = fill.first_layer + id.x;
    let near = near_cell(index);
    let at = cell_index_of(near.x);
    list = list_range_of(index);
    let cell = cell_at(at);
    let side = volume.brick_size_voxels + 1u;
    // No early return: all threads must meet at the barriers.
    let is_own = column_first_of(index) == NO_COLUMN;
    let samples = select(0u, side * side * side, is_own);
    if local == 0u {
        atomicStore(&nearest, 0xffffffffu);
        slot = 0xffffffffu;
    }
    workgroupBarrier();
    var n = 0u;
    var mine = 0xffffffffu;
    for (var i = local; i < samples; i += BRICK_GROUP) {
        let d = field_distance(sample_point(cell, vec3(i % side, i / side % side, i / side / side)));
        own[n] = d;
        n++;
        mine = min(mine, by_magnitude(d));
    }
    atomicMin(&nearest, mine);
    workgroupBarrier();
    if local == 0u && is_own {
        settle(near, at);
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
