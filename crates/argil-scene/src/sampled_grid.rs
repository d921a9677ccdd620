//! Distances at the points of a grid, for solids without a formula: triangles, or stored volumes.

mod bytes;
mod heights;

use crate::{MAX_LENGTH, ValidationError};
use argil_math::Aabb;
use glam::{UVec3, Vec3, uvec3};
use rayon::prelude::*;
use std::fmt;

/// Intervals along the side of a cell with fine samples.
pub const SAMPLED_SIDE: u32 = 8;

/// Words before the table of cells: corner, reciprocal of a cell's edge, cells along each axis, 0. For heights: the
/// largest step along x and along z, the smallest and the largest height, posts along x, 0, posts along z, 0.
pub const SAMPLED_HEADER: usize = 8;

/// Maximum slope of a grid's distance.
const MAX_LIPSCHITZ: f32 = 100.0;

/// First bytes of a grid's file.
pub const GRID_MAGIC: [u8; 8] = *b"argilg01";

/// Maximum posts along a side of a height grid.
pub const MAX_POSTS: u32 = 2048;

/// Number of samples of a cell with fine samples.
const FINE: usize = 729;

/// Up to this many intervals from the surface, fine samples are the distance itself.
const NEAR: f32 = 2.0;

/// From this many intervals on, fine samples equal the interpolated coarse ones. All cells nearer to the surface
/// have fine samples.
const FAR: f32 = 8.0;

/// The source of a grid's samples.
pub trait DistanceSampler: Sync {
    /// Computes the signed distances of points that lie close together.
    fn distances(&self, points: &[Vec3], out: &mut [f32]);

    /// Returns the unsigned distance of a point.
    fn unsigned_distance(&self, point: Vec3) -> f32 {
        let mut out = [0.0];
        self.distances(&[point], &mut out);
        out[0].abs()
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

/// A block of 9³ points, and the accuracy that it needs.
#[derive(Clone, Copy, Debug)]
pub struct SampledBlock {
    /// The first point.
    pub first: Vec3,
    /// Distance between points.
    pub step: f32,
    /// Signed distances at the block's corners, x fastest.
    pub corners: [f32; 8],
    /// Distances up to this value must be exact.
    pub near: f32,
    /// From this value on, only a lower bound is needed. Distances in between may be slightly too large.
    pub far: f32,
}

impl SampledBlock {
    /// Returns the position of the nth point.
    #[inline]
    pub fn position(&self, nth: usize) -> Vec3 {
        let inner = place_of(nth, UVec3::splat(SAMPLED_SIDE + 1));
        self.first + self.step * inner.as_vec3()
    }
}

/// A distance that is interpolated between samples.
///
/// *Theory.* Samples are fine near the surface and coarse elsewhere (adaptively sampled distance fields, Frisken et
/// al. 2000). They are interpolated linearly along each axis. Away from the surface, fine samples fade into the
/// interpolated coarse ones, so that nothing jumps where they meet. The gradient in a cell is a mean of the
/// gradients at its corners, which are differences along edges. The largest of them is the Lipschitz constant.
#[derive(Clone, PartialEq)]
#[doc(alias = "ADF")]
pub struct SampledGrid {
    /// What interpreters read, as numbers: the header; for each cell, 0 or one more than the position of its fine
    /// samples; the coarse samples at cell corners; the fine samples cell by cell. x is fastest.
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
        let cell = spacing * SAMPLED_SIDE as f32;
        let region = solid.grown(2.0 * spacing);
        let cells = (region.size() / cell).ceil().as_uvec3().max(UVec3::ONE);
        let corner = region.center() - 0.5 * cell * cells.as_vec3();
        let measure = |points: &[Vec3], out: &mut [f32]| {
            for (point, out) in points.iter().zip(out) {
                let beyond = (*point - solid.center()).abs() - half;
                let of_box = beyond.max(Vec3::ZERO).length() + beyond.max_element().min(0.0);
                // NaN stays NaN, which a maximum would hide.
                let own = distance(point.to_array());
                *out = if own < of_box { of_box } else { own };
            }
        };
        let grid = Self::sample(corner, cell, cells, solid, &measure);
        grid.check()?;
        if !grid.has_inside() {
            let reason = format!("is nowhere negative, as far as {resolution} samples find");
            return Err(ValidationError::new("distance", reason));
        }
        Ok(grid)
    }

    /// Samples a distance in cells from `corner` on. `solid` is the box of the solid.
    pub fn sample(
        corner: Vec3,
        cell: f32,
        cells: UVec3,
        solid: Aabb,
        measure: &dyn DistanceSampler,
    ) -> Self {
        let points = cells + 1;
        let at = |place: Vec3| corner + cell * place;
        let mut coarse = vec![0.0; volume(points)];
        coarse
            .par_chunks_mut(points.x as usize)
            .enumerate()
            .for_each(|(row, out)| {
                let (y, z) = (row as u32 % points.y, row as u32 / points.y);
                let places: Vec<Vec3> = (0..points.x)
                    .map(|x| at(uvec3(x, y, z).as_vec3()))
                    .collect();
                measure.distances(&places, out);
            });
        // The surface is no nearer to a cell's center than its corner tells.
        let half = 0.5 * 3f32.sqrt() * cell;
        let step = cell / SAMPLED_SIDE as f32;
        let far = FAR * step;
        let is_fine = |place: UVec3| {
            let known = corners(place).map(|p| coarse[index(p, points)].abs());
            if known.into_iter().fold(f32::INFINITY, f32::min) > 2.0 * half + far {
                return false;
            }
            measure.unsigned_distance(at(place.as_vec3() + 0.5)) <= half + far
        };
        let fine_cells: Vec<UVec3> = (0..volume(cells))
            .into_par_iter()
            .map(|i| place_of(i, cells))
            .filter(|&place| is_fine(place))
            .collect();
        let mut table = vec![0.0f32; volume(cells)];
        for (i, &place) in fine_cells.iter().enumerate() {
            table[index(place, cells)] = (i + 1) as f32;
        }
        let mut fine = vec![0.0; fine_cells.len() * FINE];
        fine.par_chunks_mut(FINE)
            .zip(&fine_cells)
            .for_each(|(out, &place)| {
                let own = corners(place).map(|p| coarse[index(p, points)]);
                let part = |i: usize| {
                    let inner = place_of(i, UVec3::splat(SAMPLED_SIDE + 1));
                    inner.as_vec3() / SAMPLED_SIDE as f32
                };
                let block = SampledBlock {
                    first: at(place.as_vec3()),
                    step,
                    corners: own,
                    near: NEAR * step,
                    far,
                };
                measure.sample_block(&block, out);
                for (i, out) in out.iter_mut().enumerate() {
                    *out = faded(*out, interpolate(own, part(i)), step);
                }
            });
        let mut words = vec![0.0; SAMPLED_HEADER];
        words[..3].copy_from_slice(&corner.to_array());
        words[3] = 1.0 / cell;
        words[4..7].copy_from_slice(&cells.as_vec3().to_array());
        words.extend_from_slice(&table);
        words.extend_from_slice(&coarse);
        words.extend_from_slice(&fine);
        Self::with(words, corner, cell, cells, solid)
    }

    fn with(words: Vec<f32>, corner: Vec3, cell: f32, cells: UVec3, solid: Aabb) -> Self {
        let mut grid = Self {
            words,
            corner,
            cell,
            cells,
            solid,
            lipschitz: 1.0,
        };
        grid.lipschitz = grid.steepest().max(1.0);
        grid
    }

    /// Creates a grid from stored words. Returns `None` if they are not a valid grid.
    pub fn from_words(words: Vec<f32>, solid: Aabb) -> Option<Self> {
        let head = words.get(..SAMPLED_HEADER)?;
        if head[5] == 0.0 {
            let posts = [head[4], head[6]].map(|n| n as u32);
            let own = Self::from_heights(posts, &words[SAMPLED_HEADER..])?;
            return (own.words == words).then_some(own);
        }
        let corner = Vec3::from_slice(head);
        let cell = 1.0 / head[3];
        let is_count = |n: &f32| (1.0..=512.0).contains(n) && n.fract() == 0.0;
        let is_fine = words.iter().all(|w| w.is_finite()) && cell > 0.0 && solid.is_finite();
        if !is_fine || !head[4..7].iter().all(is_count) {
            return None;
        }
        let cells = Vec3::from_slice(&head[4..7]).as_uvec3();
        let table = words.get(SAMPLED_HEADER..SAMPLED_HEADER + volume(cells))?;
        let mut count = 0;
        for &word in table {
            if word != 0.0 {
                count += 1;
                if word != count as f32 {
                    return None;
                }
            }
        }
        let length = SAMPLED_HEADER + volume(cells) + volume(cells + 1) + count * FINE;
        if words.len() != length {
            return None;
        }
        let grid = Self::with(words, corner, cell, cells, solid);
        let region = grid.region();
        let is_near = region.min.abs().max(region.max.abs()).max_element() <= 4.0 * MAX_LENGTH;
        let held = region.grown(1e-3 * cell);
        let is_held = held.contains(solid.min) && held.contains(solid.max);
        (is_near && is_held && grid.lipschitz <= MAX_LIPSCHITZ).then_some(grid)
    }

    /// Returns the words that interpreters read.
    pub fn words(&self) -> &[f32] {
        &self.words
    }

    /// Returns the box of the solid.
    pub fn solid(&self) -> Aabb {
        self.solid
    }

    /// Returns the box in which distances are stored.
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

    /// Whether any sample lies inside the solid.
    pub fn has_inside(&self) -> bool {
        let fixed = SAMPLED_HEADER + volume(self.cells);
        self.words[fixed..].iter().any(|&d| d < 0.0)
    }

    /// Returns the distance between fine samples.
    pub fn spacing(&self) -> f32 {
        self.cell / SAMPLED_SIDE as f32
    }

    /// Returns the number of cells with fine samples.
    pub fn fine_cells(&self) -> usize {
        let fixed = SAMPLED_HEADER + volume(self.cells) + volume(self.cells + 1);
        (self.words.len() - fixed) / FINE
    }

    /// Returns the largest gradient in any cell.
    fn steepest(&self) -> f32 {
        let table = &self.words[SAMPLED_HEADER..][..volume(self.cells)];
        let coarse = &self.words[SAMPLED_HEADER + volume(self.cells)..];
        let fine = &coarse[volume(self.cells + 1)..];
        let in_cell = |(i, &word): (usize, &f32)| {
            if word == 0.0 {
                let place = place_of(i, self.cells);
                let own = corners(place).map(|p| coarse[index(p, self.cells + 1)]);
                return steepest(own) / self.cell;
            }
            let mut greatest = 0.0f32;
            let own = &fine[(word as usize - 1) * FINE..][..FINE];
            let side = UVec3::splat(SAMPLED_SIDE + 1);
            for z in 0..SAMPLED_SIDE {
                for y in 0..SAMPLED_SIDE {
                    for x in 0..SAMPLED_SIDE {
                        let own = corners(uvec3(x, y, z)).map(|p| own[index(p, side)]);
                        greatest = greatest.max(steepest(own) / self.spacing());
                    }
                }
            }
            greatest
        };
        let all = table.par_iter().enumerate().map(in_cell);
        // Rounding of the samples themselves.
        all.reduce(|| 0.0, f32::max) * 1.0001
    }
}

/// Returns the longest gradient at a corner, for samples a unit apart.
fn steepest(v: [f32; 8]) -> f32 {
    let mut greatest = 0.0f32;
    for c in 0..8 {
        let along = |axis: usize| v[c | 1 << axis] - v[c & !(1 << axis)];
        let [x, y, z] = [along(0), along(1), along(2)];
        greatest = greatest.max(x * x + y * y + z * z);
    }
    greatest.sqrt()
}

/// Returns the value of a fine sample: the distance near the surface, which fades into the interpolated coarse
/// value with distance. It keeps its sign.
fn faded(d: f32, coarse: f32, step: f32) -> f32 {
    let share = ((d.abs() / step - NEAR) / (FAR - NEAR)).clamp(0.0, 1.0);
    let own = coarse * d.signum();
    let told = own.max(0.5 * d.abs());
    d.signum() * (d.abs() + (told - d.abs()) * share)
}

fn interpolate(v: [f32; 8], t: Vec3) -> f32 {
    let along = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let row = |i: usize| along(v[i], v[i + 1], t.x);
    along(along(row(0), row(2), t.y), along(row(4), row(6), t.y), t.z)
}

fn volume(n: UVec3) -> usize {
    n.x as usize * n.y as usize * n.z as usize
}

fn index(p: UVec3, n: UVec3) -> usize {
    (p.z as usize * n.y as usize + p.y as usize) * n.x as usize + p.x as usize
}

fn place_of(i: usize, n: UVec3) -> UVec3 {
    let i = i as u32;
    uvec3(i % n.x, i / n.x % n.y, i / n.x / n.y)
}

/// Returns the corners of a cell, x fastest.
fn corners(place: UVec3) -> [UVec3; 8] {
    std::array::from_fn(|c| place + uvec3(c as u32 & 1, c as u32 >> 1 & 1, c as u32 >> 2))
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
