//! Where a brick's samples are.

use super::BrickLayout;
use std::sync::LazyLock;

/// The offsets of a brick's samples, and of an octant's, in the order of the pool, along x, y and z.
pub(crate) struct SampleOffsets {
    pub brick: [Vec<f32>; 3],
    pub octant: [Vec<f32>; 3],
    /// Points between samples, in the brick and one voxel around it.
    pub between: [Vec<f32>; 3],
}

/// Points between samples along each axis.
pub(super) const BETWEEN: usize = 7;

impl SampleOffsets {
    /// Returns those of bricks of eight voxels a side.
    pub(super) fn of_eight() -> &'static Self {
        static EIGHT: LazyLock<SampleOffsets> = LazyLock::new(|| SampleOffsets::of(8));
        &EIGHT
    }

    pub(super) fn new(layout: &BrickLayout) -> Self {
        Self::of(layout.brick_size_voxels)
    }

    fn of(voxels: u32) -> Self {
        let of = |side: u32| {
            [1, side, side * side].map(|divisor| -> Vec<f32> {
                (0..side.pow(3))
                    .map(|i| (i / divisor % side) as f32)
                    .collect()
            })
        };
        Self {
            brick: of(voxels + 1),
            octant: of(voxels / 2 + 1),
            between: of(BETWEEN as u32).map(|own| {
                let step = (voxels + 2) as f32 / (BETWEEN - 1) as f32;
                own.into_iter().map(|place| place * step - 1.0).collect()
            }),
        }
    }
}
