//! Distances at the points of a grid, for solids without a formula: triangles, or stored volumes.

mod build;
mod bytes;
mod heights;
mod nest;
mod tight;
mod words;

use crate::{MAX_LENGTH, ValidationError};
use argil_math::Aabb;
use glam::{UVec3, Vec3};
use std::fmt;

/// Intervals along the side of a cell with fine samples.
pub const SAMPLED_SIDE: u32 = 8;

/// Words of a level's head: corner, reciprocal of a cell's edge, cells along each axis, and, in the first one, the number of
/// levels. For heights: the largest step along x and along z, the smallest and the largest height, posts along x, 0,
/// posts along z, 0.
pub const SAMPLED_HEADER: usize = 8;

/// Words between the heads and the samples: the number of cells of each kind, 0, the box of the solid, 0.
pub const SAMPLED_SUMMARY: usize = 16;

/// Maximum number of levels.
const MAX_SAMPLED_LEVELS: usize = 8;

/// Maximum slope of a grid's distance.
const MAX_LIPSCHITZ: f32 = 100.0;

/// First bytes of a grid's file.
pub const GRID_MAGIC: [u8; 8] = *b"argilg02";

/// Maximum posts along a side of a height grid.
pub const MAX_POSTS: u32 = 2048;

/// Number of samples of a cell that has all.
const FINE: usize = 729;

/// The source of a grid's samples.
pub trait DistanceSampler: Sync {
    /// Computes the signed distances of points that lie close together.
    fn distances(&self, points: &[Vec3], out: &mut [f32]);

    /// Computes the unsigned distances of points.
    fn unsigned_distances(&self, points: &[Vec3], out: &mut [f32]) {
        self.distances(points, out);
        for d in out {
            *d = d.abs();
        }
    }

    /// How many cells are asked for in one call. Points of one cell lie close together. A function that takes long to call
    /// wants many. From 1 to 4096.
    fn cells_at_once(&self) -> usize {
        1
    }

    /// Whether it knows distances of points outside of the first cells that are sampled. If not, there are no coarser levels
    /// around them, and outside the distance is a lower bound.
    fn knows_outside(&self) -> bool {
        true
    }

    /// How far off interpolated distances may be far from the surface, as a share of the distance to it. At 0, they are
    /// everywhere about as accurate as near it. Creases far away then have samples of their own.
    fn far_tolerance(&self) -> f32 {
        0.0
    }

    /// Whether the solid's box may be much larger than the solid. If so, the grid has the box of what samples find.
    fn has_loose_box(&self) -> bool {
        false
    }

    /// Computes the signed distances of a block's points, x fastest.
    fn sample_block(&self, block: &SampledBlock, out: &mut [f32]) {
        let places: Vec<Vec3> = (0..FINE).map(|i| block.position(i)).collect();
        self.distances(&places, out);
    }
}

impl<F: Fn(&[Vec3], &mut [f32]) + Sync> DistanceSampler for F {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        self(points, out);
    }
}

/// A block of 9³ points.
#[derive(Clone, Copy, Debug)]
pub struct SampledBlock {
    /// The first point.
    pub first: Vec3,
    /// Distance between points.
    pub step: f32,
    /// Signed distances at the block's corners, x fastest.
    pub corners: [f32; 8],
}

impl SampledBlock {
    /// Returns the position of the point at an index.
    #[inline]
    pub fn position(&self, index: usize) -> Vec3 {
        let inner = nest::place_of(index, UVec3::splat(SAMPLED_SIDE + 1));
        self.first + self.step * inner.as_vec3()
    }
}

/// A distance that is interpolated between samples.
///
/// *Theory.* Samples are fine near the surface and where the distance bends, and coarse elsewhere (adaptively sampled
/// distance fields, Frisken et al. 2000). Coarser levels around the first reach farther, as far as twice the solid's size.
/// All interpolate linearly along each axis. Where cells with different intervals meet, both have the values of the wider
/// one, so that nothing jumps. The gradient in a cell is a mean of the gradients at its corners, which are differences
/// along edges. The largest of them is the Lipschitz constant.
///
/// Beyond all levels, the distance is only a lower bound.
#[derive(Clone, PartialEq)]
#[doc(alias = "ADF")]
pub struct SampledGrid {
    /// What interpreters read, as numbers. x is fastest.
    words: Vec<f32>,
    corner: Vec3,
    cell: f32,
    cells: UVec3,
    solid: Aabb,
    lipschitz: f32,
}

impl fmt::Debug for SampledGrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "SampledGrid({} cells, {} words)",
            self.cells,
            self.words.len()
        )
    }
}

impl SampledGrid {
    /// Samples a function of points that returns a signed distance, or a value nowhere farther from 0 than the
    /// distance. `solid` is the box of the solid; anything outside it is cut off. `resolution` is the number of
    /// samples along its longest side, from 16 to 512.
    ///
    /// ```
    /// use argil_scene::{Brush, SampledGrid, Scene, Shape};
    /// let wave = |[x, y, z]: [f32; 3]| (x.hypot(z) - 0.8).max(y.abs() - 0.2 - 0.1 * (9.0 * x).sin()) * 0.7;
    /// let grid = SampledGrid::from_fn([[-0.8, -0.3, -0.8], [0.8, 0.3, 0.8]], 64, wave)?;
    /// let mut scene = Scene::new();
    /// scene.push(Brush::new(Shape::sampled("wave", grid)))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the box is empty or infinite, the resolution is out of range, the function returns a value that is not
    /// finite, or no sample is inside.
    pub fn from_fn(
        solid: [[f32; 3]; 2],
        resolution: u32,
        distance: impl Fn([f32; 3]) -> f32 + Sync,
    ) -> Result<Self, ValidationError> {
        mesh_resolution("resolution", resolution)?;
        let solid = Aabb::new(solid[0].into(), solid[1].into());
        let longest = solid.size().max_element();
        let is_box = solid.is_finite() && solid.size().min_element() >= 0.0 && longest > 0.0;
        if !is_box || solid.min.abs().max(solid.max.abs()).max_element() > MAX_LENGTH {
            let reason = format!(
                "{:?} to {:?} is not a valid box",
                solid.min.to_array(),
                solid.max.to_array()
            );
            return Err(ValidationError::new("solid", reason));
        }
        let half = 0.5 * solid.size();
        let spacing = longest / resolution as f32;
        let measure = |points: &[Vec3], out: &mut [f32]| {
            for (point, out) in points.iter().zip(out) {
                let beyond = (*point - solid.center()).abs() - half;
                let of_box = beyond.max(Vec3::ZERO).length() + beyond.max_element().min(0.0);
                // NaN stays NaN, which a maximum would hide.
                let value = distance(point.to_array());
                *out = if value < of_box { of_box } else { value };
            }
        };
        let grid = Self::sample_around(solid, spacing, &measure);
        grid.check()?;
        if !grid.has_inside() {
            let reason = format!("is nowhere negative, as far as {resolution} samples find");
            return Err(ValidationError::new("distance", reason));
        }
        Ok(grid)
    }

    /// Returns the words that interpreters read.
    pub fn words(&self) -> &[f32] {
        &self.words
    }

    /// Returns the box of the solid.
    pub fn solid(&self) -> Aabb {
        self.solid
    }

    /// Returns the box of the finest level.
    pub fn region(&self) -> Aabb {
        Aabb::new(self.corner, self.corner + self.cell * self.cells.as_vec3())
    }

    /// Returns the Lipschitz constant of the distance.
    pub fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Checks that distances are finite, and do not change too fast.
    ///
    /// # Errors
    /// If they are not, or do.
    pub fn check(&self) -> Result<(), ValidationError> {
        if !self.words.iter().all(|word| word.is_finite()) {
            return Err(ValidationError::new("distance", "is not finite everywhere"));
        }
        if self.lipschitz > MAX_LIPSCHITZ {
            let reason = format!(
                "changes by {} over a length of 1: no more than {MAX_LIPSCHITZ} is taken, scale it",
                self.lipschitz
            );
            return Err(ValidationError::new("distance", reason));
        }
        Ok(())
    }

    /// Returns the distance between fine samples.
    pub fn spacing(&self) -> f32 {
        self.cell / SAMPLED_SIDE as f32
    }
}

/// Checks the resolution of a mesh.
pub(crate) fn mesh_resolution(path: &str, value: u32) -> Result<(), ValidationError> {
    if (16..=512).contains(&value) {
        Ok(())
    } else {
        Err(ValidationError::new(
            path,
            format!("{value} is not from 16 to 512"),
        ))
    }
}
