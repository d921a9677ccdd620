// Plans the dispatches of a build.

// Computes the dispatch sizes of `fill_bricks`.
@compute @workgroup_size(64)
fn plan(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= volume.chunks {
        return;
    }
    let found = atomicLoad(&counters[COUNTER_CANDIDATES]);
    let first = id.x * volume.chunk;
    let own = clamp(found, first, first + volume.chunk) - first;
    let at = 3u * id.x;
    arguments[at] = own;
    arguments[at + 1u] = 1u;
    arguments[at + 2u] = 1u;
}
