// GPU version of brick_baker.rs: samples bricks by lists of common instructions, three samples of a column at a time.

// Threads that sample a brick. Nine by nine by three columns are a brick of 9³ samples.
override COLUMN_GROUP: u32 = 243u;

// Samples that a thread keeps until the group decides whether the brick is needed.
var<private> own: array<vec3<f32>, COLUMNS_PER_THREAD>;

// Returns the lowest sample of a column.
fn column_place(i: u32, side: u32) -> vec3<u32> {
    return vec3(i % side, i / side % side, i / side / side * 3u);
}

// One brick per group, unless it cannot contain a surface.
@compute @workgroup_size(COLUMN_GROUP)
fn fill_columns(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let index = fill.first_layer + id.x;
    let first = column_first_of(index);
    if first == NO_COLUMN {
        return;
    }
    let near = near_cell(index);
    let at = cell_index_of(near.x);
    let cell = cell_at(at);
    let side = volume.brick_size_voxels + 1u;
    let columns = side * side * ((side + 2u) / 3u);
    if local == 0u {
        atomicStore(&nearest, 0xffffffffu);
    }
    workgroupBarrier();
    let words = vec2(first, list_range_of(index).y);
    var n = 0u;
    var mine = 0xffffffffu;
    for (var i = local; i < columns; i += COLUMN_GROUP) {
        let place = column_place(i, side);
        let p = Column(
            sample_point(cell, place),
            sample_point(cell, place + vec3(0u, 0u, 1u)),
            sample_point(cell, place + vec3(0u, 0u, 2u)),
        );
        let d = column_distances(words, p);
        own[n] = d;
        n++;
        mine = min(mine, by_magnitude(d.x));
        mine = min(mine, select(0xffffffffu, by_magnitude(d.y), place.z + 1u < side));
        mine = min(mine, select(0xffffffffu, by_magnitude(d.z), place.z + 2u < side));
    }
    atomicMin(&nearest, mine);
    workgroupBarrier();
    if local == 0u {
        settle(near, at);
    }
    workgroupBarrier();
    if slot >= volume.capacity {
        return;
    }
    let origin = brick_origin(word_at(at));
    n = 0u;
    for (var i = local; i < columns; i += COLUMN_GROUP) {
        let place = column_place(i, side);
        let to = origin + place;
        textureStore(texels, to, encode(own[n].x));
        if place.z + 1u < side {
            textureStore(texels, to + vec3(0u, 0u, 1u), encode(own[n].y));
        }
        if place.z + 2u < side {
            textureStore(texels, to + vec3(0u, 0u, 2u), encode(own[n].z));
        }
        n++;
    }
}
