use glam::UVec3;

/// Returns the Morton code of a cell: the bits of x, y and z interleaved, x lowest, ten of each (Morton 1966; bits
/// spread by the masks of Karras, "Thinking parallel, part III", 2012). `morton.wgsl` is the twin.
///
/// Cells in ascending order of codes follow a Z-shaped curve, on which the eight cells of an octree's node are
/// neighbors: `code >> 3` is the node's own code.
///
/// ```
/// use argil_math::{morton_cell, morton};
/// assert_eq!(morton([1, 0, 1].into()), 0b101);
/// assert_eq!(morton_cell(0b110_101), [1, 2, 3].into());
/// ```
pub fn morton(cell: UVec3) -> u32 {
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}

/// Returns the cell of a Morton code.
pub fn morton_cell(code: u32) -> UVec3 {
    UVec3::new(gathered(code), gathered(code >> 1), gathered(code >> 2))
}

/// Inserts two zeros between the low ten bits.
fn spread(v: u32) -> u32 {
    let v = v & 0x3ff;
    let v = (v | v << 16) & 0x0300_00ff;
    let v = (v | v << 8) & 0x0300_f00f;
    let v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

/// Gathers every third bit, from the lowest.
fn gathered(v: u32) -> u32 {
    let v = v & 0x0924_9249;
    let v = (v | v >> 2) & 0x030c_30c3;
    let v = (v | v >> 4) & 0x0300_f00f;
    let v = (v | v >> 8) & 0x0300_00ff;
    (v | v >> 16) & 0x3ff
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_bits_interleaved_and_come_back() {
        for i in 0..100_000u32 {
            let h = i.wrapping_mul(2_654_435_761);
            let cell = UVec3::new(h & 0x3ff, h >> 10 & 0x3ff, h >> 20 & 0x3ff);
            let code = (0..10).fold(0, |code, bit| {
                let of = |v: u32, axis: u32| (v >> bit & 1) << (3 * bit + axis);
                code | of(cell.x, 0) | of(cell.y, 1) | of(cell.z, 2)
            });
            assert_eq!(morton(cell), code);
            assert_eq!(morton_cell(code), cell);
        }
    }
}
