// The cells of a unit, and the triangles of their cases.

// Returns the index of a row's first cell, given the number of the row.
fn cell_row(index: u32) -> u32 {
    return index % marching.side + points() * (index / marching.side);
}

// Returns the cells of a row that the surface passes through.
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

// Returns an edge of a case's triangles.
fn case_edge(case_words: vec2<u32>, index: u32) -> u32 {
    return select(case_words.x >> (4u * index), case_words.y >> (4u * (index - 8u)), index >= 8u) & 15u;
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
