// Each unit writes its vertices and triangles.

// GPU version of table::corners: where an edge of a cell begins.
fn edge_position(edge: u32) -> vec3<u32> {
    let low = edge & 1u;
    let high = (edge >> 1u) & 1u;
    if edge < 4u {
        return vec3(0u, low, high);
    }
    if edge < 8u {
        return vec3(low, 0u, high);
    }
    return vec3(low, high, 0u);
}

@compute @workgroup_size(GROUP)
fn emit(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let unit = min(group_index(id, count), marching.units - 1u);
    // All vertices of a unit's triangles can belong to its neighbors.
    let exists = is_unit(unit);
    if exists {
        load(unit, local);
    }
    workgroupBarrier();
    let last = last_of(unit);
    let side = marching.side;
    let each = (side * side + GROUP - 1u) / GROUP;
    let begin = local * each;
    let end = min(begin + each, side * side);
    var own = 0u;
    if exists {
        for (var index = begin; index < end; index++) {
            own += triangles_in(cell_row(index), last);
        }
    }
    let before = scanned(vec3(own, 0u, 0u), local).x;
    let first = first_of(unit);
    if units[unit].spare != 0u {
        for (var row = local; row < row_count(); row += GROUP) {
            let edges = rows[first.z * row_count() + row];
            var at = first.x + edges.w;
            for (var axis = 0u; axis < 3u; axis++) {
                var left = edges[axis];
                while left != 0u {
                    let x = firstTrailingBit(left);
                    left &= left - 1u;
                    write_vertex(at, unit, vec3(x, row % points(), row / points()), axis);
                    at += 1u;
                }
            }
        }
    }
    if own > 0u {
        var at = 3u * (first.y + before);
        for (var index = begin; index < end; index++) {
            let row = cell_row(index);
            var left = active_cells(row, last);
            while left != 0u {
                let x = firstTrailingBit(left);
                left &= left - 1u;
                let words = case_of(row, x);
                for (var i = 0u; i < 3u * triangle_count(words); i++) {
                    let edge = case_edge(words, i);
                    let place = vec3(x, row % points(), row / points()) + edge_position(edge);
                    triangles[at] = vertex_on(unit, edge / 4u, place);
                    at += 1u;
                }
            }
        }
    }
}
