// Copies bricks to another pool without gaps, one block of cells per group. On the CPU, pool.rs fills gaps as they
// appear.

struct Repack {
    // The old pool: bricks along x and y, and their total number.
    pool_x: u32,
    pool_y: u32,
    capacity: u32,
    spare: u32,
}

var<workgroup> from_word: u32;
var<workgroup> number: u32;
var<workgroup> material_before: u32;
var<workgroup> material_after: u32;

@compute @workgroup_size(64)
fn repack(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = id.x + count.x * id.y;
    let side = volume.brick_size_voxels + 1u;
    let samples = side * side * side;
    for (var i = 0u; i < 64u; i++) {
        let at = block * 64u + i;
        if local == 0u {
            from_word = WORD_EMPTY;
            if at < volume.table.cells {
                from_word = word_at(at);
            }
            if is_brick(from_word) {
                number = atomicAdd(&counters[COUNTER_HIGH_WATER], 1u);
                let before = (from_word & 1023u) + old.pool_x * (((from_word >> 10u) & 1023u) + old.pool_y * (from_word >> 20u));
                material_before = old_materials[before];
                material_after = material_before;
                if (material_before & BRICK_MIXED) != 0u {
                    material_after = BRICK_MIXED | atomicAdd(&counters[COUNTER_HIGH_WATER_MIXED], 1u);
                }
                brick_materials[number] = material_after;
                cells[volume.table.words_at + at] = brick_word(number);
            }
        }
        workgroupBarrier();
        if is_brick(from_word) {
            let begin = brick_origin(from_word);
            let to = brick_origin(brick_word(number));
            for (var s = local; s < samples; s += 64u) {
                let place = vec3(s % side, s / side % side, s / side / side);
                textureStore(texels, to + place, textureLoad(old_texels, begin + place, 0));
            }
            if (material_after & BRICK_MIXED) != 0u {
                let words_each = 2u * MATERIAL_SIDE * MATERIAL_SIDE * MATERIAL_SIDE;
                let old_first = old.capacity + words_each * (material_before & ~BRICK_MIXED);
                let first = volume.capacity + words_each * (material_after & ~BRICK_MIXED);
                for (var w = local; w < words_each; w += 64u) {
                    brick_materials[first + w] = old_materials[old_first + w];
                }
            }
        }
        workgroupBarrier();
    }
}
