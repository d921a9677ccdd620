//! Distances at points of a grid, of what has no formula: triangles, or a stored volume.
//!
//! *Theory.* Samples are fine near the surface and coarse elsewhere (adaptively sampled distance fields, Frisken et al.
//! 2000), and interpolated linearly along each axis. Away from the surface the fine ones fade into what the coarse ones
//! tell, so that the distance has no jump where fine meets coarse. Its gradient in a cell is a mean of those at the corners, which are differences along
//! edges: the greatest of them is its Lipschitz constant.

mod heights;

use crate::{MAX_LENGTH, ValidationError};
use argil_math::Aabb;
use glam::{UVec3, Vec3, uvec3};
use rayon::prelude::*;
use std::fmt;

/// Samples' intervals along the side of a cell that has fine ones.
pub const SAMPLED_SIDE: u32 = 8;

/// Words before the table of cells: corner, reciprocal of a cell's edge, cells along each axis, 0. Of heights: the greatest step
/// along x and along z, the least and the greatest height, posts along x, 0, posts along z, 0.
pub const SAMPLED_HEADER: usize = 8;

/// By how much distances of a grid may change over a length of 1.
const MAX_LIPSCHITZ: f32 = 100.0;

/// What the file of a grid begins with.
pub const GRID_MAGIC: [u8; 8] = *b"argilg01";

/// Most posts along a side of a grid of heights.
pub const MAX_POSTS: u32 = 2048;

/// Samples of a cell that has fine ones.
const FINE: usize = 729;

/// Fine samples are the distance up to so many intervals from the surface.
const NEAR: f32 = 2.0;

/// From there on, fine samples are what the coarse ones tell; all cells that the surface is nearer to have some.
const FAR: f32 = 8.0;

/// What a grid is sampled from.
pub trait DistanceSampler: Sync {
    /// The signed distances of points that lie near one another.
    fn distances(&self, points: &[Vec3], out: &mut [f32]);

    /// The distance of a point, without its sign.
    fn length(&self, point: Vec3) -> f32 {
        let mut out = [0.0];
        self.distances(&[point], &mut out);
        out[0].abs()
    }

    /// Those of a block's points, x fastest.
    fn block(&self, block: &SampledBlock, out: &mut [f32]) {
        let places: Vec<Vec3> = (0..FINE).map(|i| block.place(i)).collect();
        self.distances(&places, out);
    }
}

impl<F: Fn(&[Vec3], &mut [f32]) + Sync> DistanceSampler for F {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        self(points, out);
    }
}

/// 9³ points, and what is wanted of them.
#[derive(Clone, Copy, Debug)]
pub struct SampledBlock {
    /// The first point.
    pub first: Vec3,
    /// Between points.
    pub step: f32,
    /// The signed distances at the block's corners, x fastest.
    pub corners: [f32; 8],
    /// Distances up to here are told exactly.
    pub near: f32,
    /// From here on, only that they are so long is used of distances. In between they may be somewhat longer than they are.
    pub far: f32,
}

impl SampledBlock {
    /// Where the nth point is.
    #[inline]
    pub fn place(&self, nth: usize) -> Vec3 {
        let inner = place_of(nth, UVec3::splat(SAMPLED_SIDE + 1));
        self.first + self.step * inner.as_vec3()
    }
}

/// A distance that is interpolated between samples.
#[derive(Clone, PartialEq)]
pub struct SampledGrid {
    /// What interpreters read, all numbers: the header, of each cell 0 or one more than the place of its fine samples, the
    /// coarse samples at cells' corners, the fine ones cell by cell; x fastest.
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
    /// Sample a function of points: a signed distance, negative inside, or what is nowhere farther from 0 than that. `solid` is the box that
    /// what is solid lies in; what reaches beyond it is cut. `resolution` is samples along its longest side, from 16 to 512.
    ///
    /// ```
    /// use argil_scene::{Brush, SampledGrid, Scene, Shape};
    /// let wave = |[x, y, z]: [f32; 3]| (x.hypot(z) - 0.8).max(y.abs() - 0.2 - 0.1 * (9.0 * x).sin()) * 0.7;
    /// let grid = SampledGrid::of([[-0.8, -0.3, -0.8], [0.8, 0.3, 0.8]], 64, wave)?;
    /// let mut scene = Scene::new();
    /// scene.push(Brush::new(Shape::sampled("wave", grid)))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the box is empty or without end, the resolution is another, the function gives no numbers, or nothing is inside.
    pub fn of(
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
                "{:?} to {:?} is no box",
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
                // No number stays none, as what is greatest would not.
                let own = distance(point.to_array());
                *out = if own < of_box { of_box } else { own };
            }
        };
        let grid = Self::sample(corner, cell, cells, solid, &measure);
        if !grid.words.iter().all(|word| word.is_finite()) {
            return Err(ValidationError::new(
                "distance",
                "is no finite number somewhere",
            ));
        }
        if grid.lipschitz > MAX_LIPSCHITZ {
            let reason = format!(
                "changes by {} over a length of 1: no more than {MAX_LIPSCHITZ} is taken, scale it",
                grid.lipschitz
            );
            return Err(ValidationError::new("distance", reason));
        }
        if !grid.has_inside() {
            let reason = format!("is nowhere negative, as far as {resolution} samples find");
            return Err(ValidationError::new("distance", reason));
        }
        Ok(grid)
    }

    /// Sample a distance in cells from `corner` on; `solid` is a box around the solid.
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
        // The surface is no nearer to a cell's middle than a corner tells.
        let half = 0.5 * 3f32.sqrt() * cell;
        let step = cell / SAMPLED_SIDE as f32;
        let far = FAR * step;
        let is_fine = |place: UVec3| {
            let known = corners(place).map(|p| coarse[index(p, points)].abs());
            if known.into_iter().fold(f32::INFINITY, f32::min) > 2.0 * half + far {
                return false;
            }
            measure.length(at(place.as_vec3() + 0.5)) <= half + far
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
                measure.block(&block, out);
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

    /// From words that were kept; `None` where they make no grid.
    pub fn from_words(words: Vec<f32>, solid: Aabb) -> Option<Self> {
        let head = words.get(..SAMPLED_HEADER)?;
        if head[5] == 0.0 {
            let posts = [head[4], head[6]].map(|n| n as u32);
            let own = Self::of_heights(posts, &words[SAMPLED_HEADER..])?;
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

    /// The grid as the bytes of a file: [`GRID_MAGIC`], the box around the solid, and its [words](Self::words), all little-endian `f32`.
    pub fn to_bytes(&self) -> Vec<u8> {
        let solid = [self.solid.min, self.solid.max].map(|corner| corner.to_array());
        let words = solid.as_flattened().iter().chain(&self.words);
        let mut bytes = GRID_MAGIC.to_vec();
        bytes.extend(words.flat_map(|word| word.to_le_bytes()));
        bytes
    }

    /// From the bytes of a file; `None` if they are not those of a whole grid.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (words, rest) = bytes.strip_prefix(&GRID_MAGIC)?.as_chunks::<4>();
        let words: Vec<f32> = words.iter().map(|&word| f32::from_le_bytes(word)).collect();
        let (solid, words) = words.split_at_checked(6)?;
        let [min, max] = [0, 3].map(|at| Vec3::from_slice(&solid[at..]));
        let grid = Self::from_words(words.to_vec(), Aabb::new(min, max))?;
        rest.is_empty().then_some(grid)
    }

    /// What interpreters read.
    pub fn words(&self) -> &[f32] {
        &self.words
    }

    /// A box around the solid.
    pub fn solid(&self) -> Aabb {
        self.solid
    }

    /// The box in which distances are stored.
    pub fn region(&self) -> Aabb {
        Aabb::new(self.corner, self.corner + self.cell * self.cells.as_vec3())
    }

    /// By how much the distance can change over a length of 1.
    pub fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Whether any sample is inside.
    pub fn has_inside(&self) -> bool {
        let fixed = SAMPLED_HEADER + volume(self.cells);
        self.words[fixed..].iter().any(|&d| d < 0.0)
    }

    /// Between fine samples.
    pub fn spacing(&self) -> f32 {
        self.cell / SAMPLED_SIDE as f32
    }

    /// Cells with fine samples.
    pub fn fine_cells(&self) -> usize {
        let fixed = SAMPLED_HEADER + volume(self.cells) + volume(self.cells + 1);
        (self.words.len() - fixed) / FINE
    }

    /// The greatest gradient in any cell.
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

/// The longest gradient at a corner, of samples a length of 1 apart.
fn steepest(v: [f32; 8]) -> f32 {
    let mut greatest = 0.0f32;
    for c in 0..8 {
        let along = |axis: usize| v[c | 1 << axis] - v[c & !(1 << axis)];
        let [x, y, z] = [along(0), along(1), along(2)];
        greatest = greatest.max(x * x + y * y + z * z);
    }
    greatest.sqrt()
}

/// What a fine sample holds: the distance near the surface, more and more of what the coarse samples tell farther off, and
/// that alone from where cells without fine samples may begin. It keeps its sign.
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

/// A cell's corners, x fastest.
fn corners(place: UVec3) -> [UVec3; 8] {
    std::array::from_fn(|c| place + uvec3(c as u32 & 1, c as u32 >> 1 & 1, c as u32 >> 2))
}

/// How finely a mesh is sampled.
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
