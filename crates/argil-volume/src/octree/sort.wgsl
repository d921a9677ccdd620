// No CPU version: select.rs lists bricks in ascending order. On the GPU, threads find bricks in any order, as bits
// or as an unordered list. One workgroup of 256 threads processes them in parts.

var<workgroup> sums: array<u32, 256>;
var<workgroup> shared_word: u32;

fn sum_round(local: u32, shift: u32) {
    var left = 0u;
    if local >= shift {
        left = sums[local - shift];
    }
    workgroupBarrier();
    sums[local] += left;
    workgroupBarrier();
}

// Exclusive prefix sum over the workgroup (Hillis and Steele 1986). The rounds are unrolled, because a software
// device counts loop iterations.
fn sum_before(local: u32, value: u32) -> u32 {
    sums[local] = value;
    workgroupBarrier();
    sum_round(local, 1u);
    sum_round(local, 2u);
    sum_round(local, 4u);
    sum_round(local, 8u);
    sum_round(local, 16u);
    sum_round(local, 32u);
    sum_round(local, 64u);
    sum_round(local, 128u);
    return sums[local] - value;
}

// The sum over the workgroup, after sum_before.
fn sum_of_all(local: u32) -> u32 {
    if local == 255u {
        shared_word = sums[255];
    }
    return workgroupUniformLoad(&shared_word);
}

fn set_dispatch(bricks: u32) {
    arguments[0] = min(bricks, DISPATCH_ROW);
    arguments[1] = (bricks + DISPATCH_ROW - 1u) / DISPATCH_ROW;
    arguments[2] = 1u;
}

// Converts bits to codes. Bits are in Morton order, so counting the bits before each one sorts them.
@compute @workgroup_size(256)
fn compact(@builtin(local_invocation_index) local: u32) {
    let words = (volume.code_count + 31u) / 32u;
    var total = 0u;
    for (var first = 0u; first < words; first += 256u) {
        var bits = 0u;
        if first + local < words {
            bits = atomicLoad(&occupied[first + local]);
        }
        var at = total + sum_before(local, countOneBits(bits));
        total += sum_of_all(local);
        while bits != 0u {
            keys[at] = (first + local) * 32u + countTrailingZeros(bits);
            at++;
            bits &= bits - 1u;
        }
    }
    if local == 0u {
        atomicStore(&tree_words[OCTREE_HEADER_BRICKS], total);
        set_dispatch(total);
    }
}

// The study's enumeration sort: the index of a code is the number of smaller codes.
@compute @workgroup_size(256)
fn rank(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = atomicLoad(&tree_words[OCTREE_HEADER_BRICKS]);
    if id.x == 0u {
        set_dispatch(count);
    }
    if id.x >= count {
        return;
    }
    let code = atomicLoad(&occupied[id.x]);
    var place = 0u;
    for (var i = 0u; i < count; i++) {
        place += u32(atomicLoad(&occupied[i]) < code);
    }
    keys[place] = code;
}
