//! Where samples are.

use argil_math::Aabb;
use argil_scene::SAMPLED_SIDE;
use glam::{UVec3, Vec3};

/// Maximum cells of 8³ voxels along a side.
const MAX_SIDE: f32 = 512.0;
/// Maximum cells.
const MAX_CELLS: f32 = (1 << 21) as f32;
/// Maximum cells between the origin and the solid. Beyond, places of voxels are not exact.
const FARTHEST: f32 = (1 << 20) as f32;
/// Room around the solid, in voxels.
const ROOM: f32 = 10.0;

/// Where samples may be: at all multiples of a voxel's size from an origin. With a voxel size alone, the origin is the scene's.
///
/// ```
/// use argil_field::SampleLattice;
/// let lattice = SampleLattice::from(0.05);
/// assert_eq!((lattice.origin, lattice.voxel_size), ([0.0; 3].into(), 0.05));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleLattice {
    /// The place of one sample, in the scene's space.
    pub origin: Vec3,
    /// The distance between samples, in the scene's unit.
    pub voxel_size: f32,
}

impl From<f32> for SampleLattice {
    fn from(voxel_size: f32) -> Self {
        Self {
            origin: Vec3::ZERO,
            voxel_size,
        }
    }
}

/// The samples of a solid.
#[derive(Clone, Copy)]
pub(super) struct Lattice {
    pub(super) corner: Vec3,
    /// Edge of a cell of 8³ voxels.
    pub(super) cell: f32,
    pub(super) cells: UVec3,
    pub(super) voxel: f32,
}

impl Lattice {
    /// Returns those of a solid, or else a voxel size that is possible, and not much larger than the least one.
    pub(super) fn around(solid: Aabb, samples: SampleLattice) -> Result<Self, f32> {
        let SampleLattice {
            origin,
            voxel_size: voxel,
        } = samples;
        let solid = Aabb::new(solid.min - origin, solid.max - origin);
        let found = Self::of_voxel(solid, voxel).ok_or_else(|| {
            let largest = solid.min.abs().max(solid.max.abs()).max_element();
            // Steps of 5 %, from too small a voxel on.
            let from = (voxel as f64).max(1e-8 * f64::from(largest));
            let sizes = (0..1000).map(|step| (from * 1.05f64.powi(step)) as f32);
            let mut possible = sizes.filter(|&size| Self::of_voxel(solid, size).is_some());
            possible.next().unwrap_or(f32::MAX)
        })?;
        Ok(Self {
            corner: origin + found.corner,
            ..found
        })
    }

    fn of_voxel(solid: Aabb, voxel: f32) -> Option<Self> {
        let cell = voxel * SAMPLED_SIDE as f32;
        let region = solid.grown(ROOM * voxel);
        let first = (region.min / cell).floor();
        // An even number of cells, as levels have.
        let cells = 2.0 * (0.5 * ((region.max / cell).ceil() - first)).ceil();
        let by_side = cells.max_element() / MAX_SIDE;
        let by_count = (cells.element_product() / MAX_CELLS).cbrt();
        let by_place = first.abs().max(first + cells).max_element() / FARTHEST;
        let excess = by_side.max(by_count).max(by_place);
        (excess <= 1.0).then(|| Self {
            corner: cell * first,
            cell,
            cells: cells.as_uvec3(),
            voxel,
        })
    }
}
