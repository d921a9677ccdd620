// GPU version of morton.rs.

fn spread_bits(value: u32) -> u32 {
    var v = value & 0x3ffu;
    v = (v | (v << 16u)) & 0x030000ffu;
    v = (v | (v << 8u)) & 0x0300f00fu;
    v = (v | (v << 4u)) & 0x030c30c3u;
    return (v | (v << 2u)) & 0x09249249u;
}

fn gathered_bits(value: u32) -> u32 {
    var v = value & 0x09249249u;
    v = (v | (v >> 2u)) & 0x030c30c3u;
    v = (v | (v >> 4u)) & 0x0300f00fu;
    v = (v | (v >> 8u)) & 0x030000ffu;
    return (v | (v >> 16u)) & 0x3ffu;
}

fn morton(cell: vec3<u32>) -> u32 {
    return spread_bits(cell.x) | (spread_bits(cell.y) << 1u) | (spread_bits(cell.z) << 2u);
}

fn cell_of(code: u32) -> vec3<u32> {
    return vec3(gathered_bits(code), gathered_bits(code >> 1u), gathered_bits(code >> 2u));
}
