// Twin of bricks.rs: marching cubes over units of cells, a workgroup each: bricks, or parts of a dense volume. Units are
// counted, the counts added up, then each writes its own vertices and triangles. A row of samples is a row of bits; a vertex
// is the unit's at whose low sides its edge lies. `stored.wgsl` of the volume says where samples are.

const GROUP: u32 = 64u;
// Rows of the samples of 16³ cells.
const MOST_ROWS: u32 = 289u;

// Vertices, triangles and units that have any before one, of those that one workgroup adds up.
struct Unit {
    vertices: u32,
    triangles: u32,
    place: u32,
    spare: u32,
}

var<workgroup> bits: array<u32, MOST_ROWS>;
var<workgroup> beside: array<u32, 8>;
var<workgroup> totals: array<vec3<u32>, GROUP>;
var<workgroup> carried: vec3<u32>;

fn group_index(id: vec3<u32>, count: vec3<u32>) -> u32 {
    return id.x + count.x * id.y;
}

fn points() -> u32 {
    return marching.side + 1u;
}

fn row_count() -> u32 {
    return points() * points();
}

// Units beside one, and the signs of its samples.
fn load(unit: u32, local: u32) {
    if local < 8u {
        beside[local] = unit_beside(unit, vec3(local & 1u, (local >> 1u) & 1u, local >> 2u));
    }
    let n = points();
    let last = last_of(unit);
    for (var row = local; row < row_count(); row += GROUP) {
        // Beyond the volume are the last samples again, so that nothing is crossed on the way there.
        var inside = 0u;
        for (var x = 0u; x < n; x++) {
            let place = min(vec3(x, row % n, row / n), last);
            inside |= select(0u, 1u, stored_at(unit, place) < marching.iso) << x;
        }
        bits[row] = inside;
    }
}

// Whether there are samples of its own in a row.
fn has_row(row: u32, last: vec3<u32>) -> bool {
    return row % points() <= last.y && row / points() <= last.z;
}

// The edges along an axis that begin in a row and are crossed.
fn crossed(axis: u32, row: u32, last: vec3<u32>) -> u32 {
    let n = points();
    if !has_row(row, last) {
        return 0u;
    }
    let own = bits[row];
    let held = (2u << last.x) - 1u;
    if axis == 0u {
        return (own ^ (own >> 1u)) & ((1u << last.x) - 1u);
    }
    if axis == 1u && row % n < last.y {
        return (own ^ bits[row + 1u]) & held;
    }
    if axis == 2u && row / n < last.z {
        return (own ^ bits[row + n]) & held;
    }
    return 0u;
}

// At which high sides but its axis's the edges of a row lie, without that of x.
fn sides_of(axis: u32, row: u32) -> u32 {
    let y = u32(axis != 1u && row % points() == marching.side) << 1u;
    let z = u32(axis != 2u && row / points() == marching.side) << 2u;
    return y | z;
}

// Towards which unit an edge's owner lies, of some high sides; 0 for this one. Of two sides: both, that of the higher axis,
// that of the lower.
fn towards(unit: u32, sides: u32) -> u32 {
    if sides == 0u {
        return 0u;
    }
    let high = 1u << firstLeadingBit(sides);
    let low = sides & ~high;
    if beside[sides] != unit {
        return sides;
    }
    if beside[high] != unit {
        return high;
    }
    return select(0u, low, beside[low] != unit);
}

// Of those, the unit's own.
fn owned(unit: u32, axis: u32, row: u32, edges: u32) -> u32 {
    let sides = sides_of(axis, row);
    let end = 1u << marching.side;
    var own = edges;
    if towards(unit, sides) != 0u {
        own &= end;
    }
    if axis != 0u && towards(unit, sides | 1u) != 0u {
        own &= ~end;
    }
    return own;
}

// The row of the nth row of cells.
fn cell_row(nth: u32) -> u32 {
    return nth % marching.side + points() * (nth / marching.side);
}

// The cells of a row that the surface goes through.
fn active_cells(row: u32, last: vec3<u32>) -> u32 {
    let n = points();
    if row % n >= last.y || row / n >= last.z {
        return 0u;
    }
    let a = bits[row];
    let b = bits[row + 1u];
    let c = bits[row + n];
    let d = bits[row + n + 1u];
    let any = a | b | c | d;
    let all = a & b & c & d;
    return (any | (any >> 1u)) & ~(all & (all >> 1u)) & ((1u << last.x) - 1u);
}

fn case_of(row: u32, x: u32) -> vec2<u32> {
    let n = points();
    let case_bits = ((bits[row] >> x) & 3u) | (((bits[row + 1u] >> x) & 3u) << 2u)
        | (((bits[row + n] >> x) & 3u) << 4u) | (((bits[row + n + 1u] >> x) & 3u) << 6u);
    let pair = cases[case_bits / 2u];
    return select(pair.xy, pair.zw, (case_bits & 1u) != 0u);
}

fn triangle_count(case_words: vec2<u32>) -> u32 {
    return case_words.y >> 28u;
}

// The nth edge of a case's triangles.
fn case_edge(case_words: vec2<u32>, nth: u32) -> u32 {
    return select(case_words.x >> (4u * nth), case_words.y >> (4u * (nth - 8u)), nth >= 8u) & 15u;
}

fn triangles_in(row: u32, last: vec3<u32>) -> u32 {
    var count = 0u;
    var left = active_cells(row, last);
    while left != 0u {
        count += triangle_count(case_of(row, firstTrailingBit(left)));
        left &= left - 1u;
    }
    return count;
}

// From a triple for each thread to how much the threads before it have.
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
    let is_there = is_unit(unit);
    if is_there {
        load(unit, local);
    }
    workgroupBarrier();
    var vertices = 0u;
    var triangles_here = 0u;
    if is_there {
        let last = last_of(unit);
        for (var row = local; row < row_count(); row += GROUP) {
            for (var axis = 0u; axis < 3u; axis++) {
                vertices += countOneBits(owned(unit, axis, row, crossed(axis, row, last)));
            }
        }
        for (var nth = local; nth < marching.side * marching.side; nth += GROUP) {
            triangles_here += triangles_in(cell_row(nth), last);
        }
    }
    let own = vec3(vertices, triangles_here, 0u);
    let sum = scanned(own, local) + own;
    if local == GROUP - 1u {
        units[unit] = Unit(sum.x, sum.y, select(0u, 1u, sum.x > 0u), 0u);
    }
}

// What units have before them, of those that a workgroup adds up, and what those have.
@compute @workgroup_size(GROUP)
fn add_units(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let group = group_index(id, count);
    let first = group * UNITS_A_GROUP + local * 4u;
    let end = min(first + 4u, marching.units);
    var own = vec3(0u);
    for (var unit = first; unit < end; unit++) {
        own += vec3(units[unit].vertices, units[unit].triangles, units[unit].place);
    }
    var before = scanned(own, local);
    for (var unit = first; unit < end; unit++) {
        let counts = vec3(units[unit].vertices, units[unit].triangles, units[unit].place);
        // What it has stays known by the flag of its place.
        units[unit] = Unit(before.x, before.y, before.z, counts.z);
        before += counts;
    }
    if local == GROUP - 1u && group < arrayLength(&groups) - 1u {
        groups[group] = vec4(before, 0u);
    }
}

// What groups of units have before them; last, what all have. One workgroup.
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

// The first vertex and triangle of a unit, and where its rows stand.
fn first_of(unit: u32) -> vec3<u32> {
    let own = units[unit];
    return vec3(own.vertices, own.triangles, own.place) + groups[unit / UNITS_A_GROUP].xyz;
}

// Of each row of a unit that has vertices: which edges along x, y and z have one, and how many come before the row's.
@compute @workgroup_size(GROUP)
fn place_rows(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let unit = min(group_index(id, count), marching.units - 1u);
    let is_there = units[unit].spare != 0u;
    if is_there {
        load(unit, local);
    }
    workgroupBarrier();
    let last = last_of(unit);
    let each = (row_count() + GROUP - 1u) / GROUP;
    let first = local * each;
    let end = min(first + each, row_count());
    var own = 0u;
    if is_there {
        for (var row = first; row < end; row++) {
            for (var axis = 0u; axis < 3u; axis++) {
                own += countOneBits(owned(unit, axis, row, crossed(axis, row, last)));
            }
        }
    }
    var before = scanned(vec3(own, 0u, 0u), local).x;
    if is_there {
        let begin = first_of(unit).z * row_count();
        for (var row = first; row < end; row++) {
            let x = owned(unit, 0u, row, crossed(0u, row, last));
            let y = owned(unit, 1u, row, crossed(1u, row, last));
            let z = owned(unit, 2u, row, crossed(2u, row, last));
            rows[begin + row] = vec4(x, y, z, before);
            before += countOneBits(x) + countOneBits(y) + countOneBits(z);
        }
    }
}

// The samples' gradient at a point of a unit, in quanta a voxel: central differences, one-sided where nothing is stored.
fn stored_gradient(unit: u32, place: vec3<u32>) -> vec3<f32> {
    var gradient = vec3(0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        var way = vec3(0);
        way[axis] = 1;
        let high = stored_beyond(unit, vec3<i32>(place) + way);
        let low = stored_beyond(unit, vec3<i32>(place) - way);
        let here = stored_at(unit, place);
        let a = select(here, low.x, low.y > 0.0);
        let b = select(here, high.x, high.y > 0.0);
        gradient[axis] = (b - a) / max(low.y + high.y, 1.0);
    }
    return gradient;
}

fn unit_vector(v: vec3<f32>) -> vec3<f32> {
    let length = sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return v * select(0.0, 1.0 / max(length, 1e-37), length > 0.0);
}

// Write the vertex on an edge; if it is to be moved, the distances stored at the edge's ends, and its axis.
fn write_vertex(at: u32, unit: u32, place: vec3<u32>, axis: u32) {
    var after = place;
    after[axis] += 1u;
    let a = stored_at(unit, place);
    let b = stored_at(unit, after);
    let t = clamp((marching.iso - a) / (b - a), NEAREST_ON_EDGE, 1.0 - NEAREST_ON_EDGE);
    var voxels = origin_of(unit) + vec3<f32>(place);
    voxels[axis] += t;
    let position = marching.first_voxel.xyz + marching.first_voxel.w * voxels;
    var normal = vec3(0.0);
    if marching.normals == MARCH_GRADIENT {
        normal = unit_vector(mix(stored_gradient(unit, place), stored_gradient(unit, after), t));
    }
    if marching.is_moved != 0u {
        spans[at] = vec4(a * marching.quantum, b * marching.quantum, f32(axis), 0.0);
    }
    vertices[6u * at] = position.x;
    vertices[6u * at + 1u] = position.y;
    vertices[6u * at + 2u] = position.z;
    vertices[6u * at + 3u] = normal.x;
    vertices[6u * at + 4u] = normal.y;
    vertices[6u * at + 5u] = normal.z;
}

// The vertex on an edge of a unit.
fn vertex_on(unit: u32, axis: u32, place: vec3<u32>) -> u32 {
    let x = u32(axis != 0u && place.x == marching.side);
    let gone = towards(unit, sides_of(axis, place.y + points() * place.z) | x);
    let owner = beside[gone];
    // What was at a high side is at the owner's low side.
    let at = select(place, vec3(0u), vec3((gone & 1u) != 0u, (gone & 2u) != 0u, (gone & 4u) != 0u));
    let first = first_of(owner);
    let row = rows[first.z * row_count() + at.y + points() * at.z];
    var before = row.w + countOneBits(row[axis] & ((1u << at.x) - 1u));
    if axis > 0u {
        before += countOneBits(row.x);
    }
    if axis > 1u {
        before += countOneBits(row.y);
    }
    return first.x + before;
}

// Twin of table::corners: where an edge of a cell begins.
fn edge_place(edge: u32) -> vec3<u32> {
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
    // A unit can have triangles whose vertices are all its neighbours'.
    let is_there = is_unit(unit);
    if is_there {
        load(unit, local);
    }
    workgroupBarrier();
    let last = last_of(unit);
    let side = marching.side;
    let each = (side * side + GROUP - 1u) / GROUP;
    let begin = local * each;
    let end = min(begin + each, side * side);
    var own = 0u;
    if is_there {
        for (var nth = begin; nth < end; nth++) {
            own += triangles_in(cell_row(nth), last);
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
        for (var nth = begin; nth < end; nth++) {
            let row = cell_row(nth);
            var left = active_cells(row, last);
            while left != 0u {
                let x = firstTrailingBit(left);
                left &= left - 1u;
                let words = case_of(row, x);
                for (var i = 0u; i < 3u * triangle_count(words); i++) {
                    let edge = case_edge(words, i);
                    let place = vec3(x, row % points(), row / points()) + edge_place(edge);
                    triangles[at] = vertex_on(unit, edge / 4u, place);
                    at += 1u;
                }
            }
        }
    }
}
