// GPU version of bricks.rs: marching cubes over units of cells, one workgroup each. A unit is a brick, or a part of
// a dense volume. Units are counted, the counts are summed, then each unit writes its vertices and triangles. A row
// of samples is a row of bits. A vertex belongs to the unit that has its edge at a low side. The volume's
// shader locates samples.

const GROUP: u32 = 64u;
// Rows of the samples of 16³ cells.
const MOST_ROWS: u32 = 289u;

// Vertices, triangles and non-empty units before a unit, within one workgroup.
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

// Loads the neighbors of a unit, and the signs of its samples.
fn load(unit: u32, local: u32) {
    if local < 8u {
        beside[local] = unit_beside(unit, vec3(local & 1u, (local >> 1u) & 1u, local >> 2u));
    }
    let n = points();
    let last = last_of(unit);
    for (var row = local; row < row_count(); row += GROUP) {
        // Beyond the volume the last samples repeat, so that no edge crosses there.
        var inside = 0u;
        for (var x = 0u; x < n; x++) {
            let place = min(vec3(x, row % n, row / n), last);
            inside |= select(0u, 1u, stored_at(unit, place) < marching.iso) << x;
        }
        bits[row] = inside;
    }
}

// Returns true if a row contains samples of the unit.
fn has_row(row: u32, last: vec3<u32>) -> bool {
    return row % points() <= last.y && row / points() <= last.z;
}

// Returns the crossed edges along an axis that begin in a row.
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

// Returns the high sides, other than the axis's own and x, on which the edges of a row lie.
fn sides_of(axis: u32, row: u32) -> u32 {
    let y = u32(axis != 1u && row % points() == marching.side) << 1u;
    let z = u32(axis != 2u && row / points() == marching.side) << 2u;
    return y | z;
}

// Returns the direction of an edge's owner for some high sides; 0 is this unit. For two sides: both, the higher
// axis, the lower axis.
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

// Returns those edges that the unit owns.
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
