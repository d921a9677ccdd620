//! What a ray hit.

use crate::HIT_KIND_BIT;

/// What a primary ray hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hit {
    /// Unit normal toward the viewer, then the length of the ray. All zero if nothing was hit.
    pub normal_t: [f32; 4],
    /// A `HIT_…`.
    pub kind: u32,
    /// Everything that the ray looked up: samples, nodes and cells. The normal's samples do not count.
    pub steps: u32,
    /// Of the steps, nodes of a tree that were visited.
    pub descents: u32,
    /// Of the steps, cells of a grid that were crossed.
    pub cells: u32,
    /// An id that is shown as a color: 1 and the index of a sparse brick's word, or the Morton code of an
    /// octree's brick or of a node above bricks; else 0.
    pub id: u32,
}

/// Bytes of a record that a GPU stores of a ray.
pub const RECORD_BYTES: u64 = 16;

/// The most records of a ray: its hit, what the sun lights there, and what it did.
pub const MAX_RECORDS: u64 = 3;

impl Hit {
    /// Returns the hit that a GPU stored in two records: what was hit, and what the ray did.
    ///
    /// ```
    /// use argil_abi::{HIT_INSIDE, HIT_KIND_BIT, Hit};
    /// // The second bit of the kind is in the normal's y.
    /// let surface = [0, 1.0f32.to_bits() | HIT_KIND_BIT, 0, 2.5f32.to_bits()];
    /// let hit = Hit::from_records(surface, [12, 0, 3, 7]);
    /// assert_eq!((hit.kind, hit.normal_t), (HIT_INSIDE, [0.0, 1.0, 0.0, 2.5]));
    /// assert_eq!([hit.steps, hit.descents, hit.cells, hit.id], [12, 0, 3, 7]);
    /// ```
    pub fn from_records(surface: [u32; 4], counts: [u32; 4]) -> Self {
        let bit = |axis: usize| u32::from(surface[axis] & HIT_KIND_BIT != 0) << axis;
        let [steps, descents, cells, id] = counts;
        let [x, y, z, t] = surface;
        let normal = [x, y, z].map(|word| f32::from_bits(word & !HIT_KIND_BIT));
        Self {
            normal_t: [normal[0], normal[1], normal[2], f32::from_bits(t)],
            kind: bit(0) | bit(1) | bit(2),
            steps,
            descents,
            cells,
            id,
        }
    }
}
