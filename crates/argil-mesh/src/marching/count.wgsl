// Counts what units emit, and computes prefix sums of the counts.

// Computes the exclusive prefix sum of a triple over a workgroup.
fn scanned(own: vec3<u32>, local: u32) -> vec3<u32> {
    totals[local] = own;
    workgroupBarrier();
    for (var step = 1u; step < GROUP; step *= 2u) {
        var before = vec3(0u);
        if local >= step {
            before = totals[local - step];
        }
        workgroupBarrier();
        totals[local] += before;
        workgroupBarrier();
    }
    let sum = totals[local];
    workgroupBarrier();
    return sum - own;
}

@compute @workgroup_size(GROUP)
fn count_units(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let unit = min(group_index(id, count), marching.units - 1u);
    let exists = is_unit(unit);
    if exists {
        load(unit, local);
    }
    workgroupBarrier();
    var vertices = 0u;
    var triangles_here = 0u;
    if exists {
        let last = last_of(unit);
        for (var row = local; row < row_count(); row += GROUP) {
            for (var axis = 0u; axis < 3u; axis++) {
                vertices += countOneBits(owned(unit, axis, row, crossed(axis, row, last)));
            }
        }
        for (var index = local; index < marching.side * marching.side; index += GROUP) {
            triangles_here += triangles_in(cell_row(index), last);
        }
    }
    let own = vec3(vertices, triangles_here, 0u);
    let sum = scanned(own, local) + own;
    if local == GROUP - 1u {
        units[unit] = Unit(sum.x, sum.y, select(0u, 1u, sum.x > 0u), 0u);
    }
}

// Computes prefix sums of the units of a workgroup, and their total.
@compute @workgroup_size(GROUP)
fn add_units(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let group = group_index(id, count);
    let first = group * UNITS_PER_GROUP + local * 4u;
    let end = min(first + 4u, marching.units);
    var own = vec3(0u);
    for (var unit = first; unit < end; unit++) {
        own += vec3(units[unit].vertices, units[unit].triangles, units[unit].place);
    }
    var before = scanned(own, local);
    for (var unit = first; unit < end; unit++) {
        let counts = vec3(units[unit].vertices, units[unit].triangles, units[unit].place);
        // The flag of its slot still tells which are non-empty.
        units[unit] = Unit(before.x, before.y, before.z, counts.z);
        before += counts;
    }
    if local == GROUP - 1u && group < arrayLength(&groups) - 1u {
        groups[group] = vec4(before, 0u);
    }
}

// Computes prefix sums over groups of units, and the total. One workgroup.
@compute @workgroup_size(GROUP)
fn add_groups(@builtin(local_invocation_index) local: u32) {
    let count = arrayLength(&groups) - 1u;
    if local == 0u {
        carried = vec3(0u);
    }
    workgroupBarrier();
    for (var first = 0u; first < count; first += GROUP) {
        let at = first + local;
        var own = vec3(0u);
        if at < count {
            own = groups[at].xyz;
        }
        let before = scanned(own, local) + carried;
        workgroupBarrier();
        if at < count {
            groups[at] = vec4(before, 0u);
        }
        if local == GROUP - 1u {
            carried = before + own;
        }
        workgroupBarrier();
    }
    if local == 0u {
        groups[count] = vec4(carried, 0u);
    }
}
