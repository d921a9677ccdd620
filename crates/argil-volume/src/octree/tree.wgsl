// GPU version of tree.rs. One workgroup of 256 threads processes levels with more children in parts.

var<workgroup> children: array<u32, 256>;

@compute @workgroup_size(256)
fn build(@builtin(local_invocation_index) local: u32) {
    if local == 0u {
        shared_word = atomicLoad(&tree_words[OCTREE_HEADER_BRICKS]);
    }
    var count = workgroupUniformLoad(&shared_word);
    // The keys of each level follow those of the level below.
    var first_key = 0u;
    var first_node = 0u;
    for (var level = 0u; level < volume.depth; level++) {
        var parents = 0u;
        for (var first = 0u; first < count; first += 256u) {
            let i = first + local;
            // Copy the part's keys to shared memory. The first thread compares with the last key of the previous
            // part.
            var key = 0u;
            if i < count {
                key = keys[first_key + i];
            }
            children[local] = key;
            workgroupBarrier();
            var left = 0u;
            if local > 0u {
                left = children[local - 1u];
            } else if i > 0u && i < count {
                left = keys[first_key + i - 1u];
            }
            let starts = i < count && (i == 0u || (left >> 3u) != (key >> 3u));
            let parent = parents + sum_before(local, u32(starts)) + u32(starts) - 1u;
            if i < count {
                let node = 3u * (first_node + parent);
                if starts {
                    atomicStore(&node_words[node], i);
                    keys[first_key + count + parent] = key >> 3u;
                }
                atomicOr(&node_words[node + 1u], 1u << (key & 7u));
                if level == 0u {
                    atomicOr(&node_words[node + 2u], 1u << (key & 7u));
                }
            }
            parents += sum_of_all(local);
        }
        if local == 0u {
            atomicStore(&tree_words[OCTREE_HEADER_LEVELS + level], first_node);
        }
        first_key += count;
        first_node += parents;
        count = parents;
        storageBarrier();
    }
    if local == 0u {
        atomicStore(&tree_words[OCTREE_HEADER_NODES], first_node);
    }
}
