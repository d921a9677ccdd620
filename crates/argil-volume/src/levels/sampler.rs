//! Reads levels at many points at once.

use super::page::{Page, octant_place};
use super::page_starts::PageStarts;
use super::requests::{PageAim, PageRequest};
use super::tree::Levels;
use crate::MISSING_BRICK;
use crate::bricks::{center_of, is_brick, load_planes, load_voxels};
use crate::{CellLocations, NeighborPlanes, Texel, VoxelGrid, VoxelSamples};
use argil_field::LANES;
use glam::{DVec3, IVec3, Vec3};
use std::sync::atomic::Ordering;

/// The pages of points, and the positions in them.
#[derive(Debug)]
pub struct LevelLanes {
    /// The page of each point. Before a look-up, any page: the search begins there.
    pub page: [u32; LANES],
    /// The edge of the page's voxels, in the scene's unit.
    pub voxel: [f32; LANES],
    /// By how many levels the cell is too coarse although a finer one can exist. 0 if it is fine enough.
    pub gap: [f32; LANES],
    /// What is missing, as in [`PageRequest::key`], or [`NO_REQUEST`].
    pub key: [u64; LANES],
    /// For lanes that lack something: the point that needs it.
    pub aim: [PageAim; LANES],
    /// The cells, counted from the page's corner, and their words. An index is a cell's.
    pub at: CellLocations,
}

impl Default for LevelLanes {
    fn default() -> Self {
        Self {
            page: [0; LANES],
            voxel: [1.0; LANES],
            gap: [0.0; LANES],
            key: [NO_REQUEST; LANES],
            aim: [PageAim {
                voxel: [0; 3],
                level: 0,
            }; LANES],
            at: CellLocations::default(),
        }
    }
}

impl LevelLanes {
    /// Creates lanes whose search begins at a page.
    pub fn at(page: u32) -> Self {
        Self {
            page: [page; LANES],
            ..Self::default()
        }
    }
}

/// Returns the voxel that contains a point, and the position in it, in voxels.
pub fn split_position(grid: &VoxelGrid, point: Vec3) -> (IVec3, Vec3) {
    let away = (point.as_dvec3() - grid.corner.as_dvec3()) / f64::from(grid.voxel_size);
    let limit = DVec3::splat(f64::from(1 << 30));
    let voxel = away.clamp(-limit, limit).floor();
    (voxel.as_ivec3(), (away - voxel).as_vec3())
}

/// Levels, ready to be sampled by rays from one point.
#[derive(Debug)]
pub struct LevelSampler<'a, T> {
    pub(super) levels: &'a Levels,
    pub(super) pages: &'a [Page],
    pub(super) words: &'a [u32],
    pub(super) children: &'a [u32],
    pool: &'a [T],
    count: u32,
    /// The voxel of level 0 that contains the camera, and the position in it.
    pub(super) eye_voxel: IVec3,
    eye_inner: Vec3,
    /// The first and the last voxel of level 0 along each axis.
    pub(super) held: [[i32; 2]; 3],
    pub(super) voxel: f32,
    per_voxel: f32,
    /// The distance in voxels that one code step means, and the band in voxels.
    quantum: f32,
    band: f32,
    /// How much a distance can change over a voxel's edge, in voxels.
    steepness: f32,
    pub(super) root: u32,
    frame: u32,
    /// Where searches begin, if that is known.
    pub(super) starts: Option<PageStarts>,
}

impl<'a, T: Texel> LevelSampler<'a, T> {
    /// Creates a sampler for rays from a point. Returns `None` if the samples have another type.
    pub fn new(levels: &'a Levels, eye: Vec3) -> Option<Self> {
        let layout = levels.layout().level(0);
        let grid = &layout.voxel_grid;
        let pool = levels.pool().of::<T>()?;
        let band = layout.encoding.band_width(grid, 0) / grid.voxel_size;
        let (eye_voxel, eye_inner) = split_position(grid, eye);
        // Searches read without bounds checks.
        let (cells, pages) = (8 * levels.pages().len(), levels.pages().len());
        let samples = u64::from(layout.brick_samples()) * levels.brick_count().max(1);
        let is_whole = levels.words().len() == cells
            && levels.children().len() == cells
            && pool.len() as u64 >= samples;
        (is_whole && pages > 0).then(|| Self {
            levels,
            pages: levels.pages(),
            words: levels.words(),
            children: levels.children(),
            pool,
            count: levels.brick_count() as u32,
            eye_voxel,
            eye_inner,
            held: [0, 1, 2].map(|axis: usize| {
                let (first, last) = levels.voxel_range();
                [first[axis], last[axis]]
            }),
            voxel: grid.voxel_size,
            per_voxel: 1.0 / grid.voxel_size,
            quantum: band / layout.encoding.format.max_code() as f32,
            band,
            steepness: 1.000_01 * levels.lipschitz(),
            root: levels.layout().root(),
            frame: levels.frame.load(Ordering::Relaxed),
            starts: None,
        })
    }

    /// Returns what a lane lacks, at a distance from the camera.
    #[inline(always)]
    pub fn request_of(&self, lanes: &LevelLanes, i: usize, distance: f32) -> Option<PageRequest> {
        (lanes.key[i] != NO_REQUEST).then(|| PageRequest {
            key: lanes.key[i],
            gap: lanes.gap[i],
            distance,
            aim: Some(lanes.aim[i]),
        })
    }

    /// Marks a lane's cell as used by the current frame.
    #[inline(always)]
    pub fn mark_used(&self, lanes: &LevelLanes, i: usize) {
        self.levels.mark_used(lanes.at.index[i], self.frame);
    }

    /// Returns the levels.
    pub fn levels(&self) -> &'a Levels {
        self.levels
    }

    /// Returns the edge of a voxel of level 0.
    pub fn voxel(&self) -> f32 {
        self.voxel
    }

    /// Returns the band, in voxels of any level.
    pub fn band_voxels(&self) -> f32 {
        self.band
    }

    /// Returns the distance that one code step means, in voxels of any level.
    pub fn quantum(&self) -> f32 {
        self.quantum
    }

    /// Returns how far an interpolated distance can be from the true one, in voxels of any level.
    pub fn error_voxels(&self) -> f32 {
        0.5 * 3f32.sqrt() * self.steepness
    }

    /// Returns a position for an offset from the camera, in the scene's unit along an axis: see [`LevelSampler::locate`].
    #[inline(always)]
    pub fn position(&self, axis: usize, away: f32) -> f32 {
        self.eye_inner[axis] + away * self.per_voxel
    }

    /// Returns the coarsest level's number, and a level for voxels of a size in the scene's unit at most.
    #[inline(always)]
    pub fn level_of(&self, size: f32) -> u32 {
        let ratio = size * self.per_voxel;
        // The exponent is the logarithm, rounded down.
        let exponent = (ratio.to_bits() >> 23) as i32 - 127;
        exponent.clamp(0, self.root as i32) as u32
    }

    /// Loads the corner samples of the voxels that contain the points. The result is arbitrary for points in cells
    /// without a brick.
    #[inline(always)]
    pub fn voxel_samples(&self, at: &CellLocations, n: usize, out: &mut VoxelSamples) {
        load_voxels(self.pool, (self.count, 8), at, n, out);
    }

    /// Loads the samples beyond the faces of a lane's voxel: see [`crate::BrickSampler::neighbor_planes`]. Adds a
    /// request if a neighbor is not resident.
    #[inline(always)]
    pub fn neighbor_planes(
        &self,
        lanes: &LevelLanes,
        corners: &VoxelSamples,
        i: usize,
        fraction: [f32; 3],
        out: &mut NeighborPlanes,
        asked: &mut Vec<PageRequest>,
    ) {
        let asked = std::cell::RefCell::new(asked);
        let neighbor = |axis: usize, goes_up: bool| {
            self.neighbor(lanes.at.index[i], axis, goes_up, &mut asked.borrow_mut())
        };
        load_planes(
            self.pool,
            8,
            lanes.at.word[i],
            corners,
            i,
            fraction,
            neighbor,
            out,
        );
    }

    /// Returns the brick of the cell next to another one, on the same level.
    #[inline(always)]
    fn neighbor(
        &self,
        cell: u32,
        axis: usize,
        goes_up: bool,
        asked: &mut Vec<PageRequest>,
    ) -> Option<u32> {
        let is_upper = cell >> axis & 1 != 0;
        let beside = if is_upper != goes_up {
            cell ^ 1 << axis
        } else {
            let page = &self.pages[cell as usize / 8];
            let mut place = 2 * page.place() + octant_place(cell % 8);
            place[axis] += if goes_up { 1 } else { -1 };
            let found = self.levels.find(page.level, place)?;
            if self.levels.level_of(found) != page.level {
                asked.extend(self.levels.request_for((page.level, place), found, 0.0));
                return None;
            }
            found
        };
        let word = self.words[beside as usize];
        if word == MISSING_BRICK {
            asked.push(PageRequest::of_cell(beside, 1.0, 0.0));
            return None;
        }
        is_brick(word).then_some(word)
    }

    /// Returns a lower bound of the signed distance for a lane in a cell without a brick, in the scene's unit.
    #[inline(always)]
    pub fn empty_cell_distance(&self, lanes: &LevelLanes, i: usize) -> f32 {
        let center = center_of(lanes.at.word[i]);
        let (x, y, z) = (
            lanes.at.inner[0][i] - 4.0,
            lanes.at.inner[1][i] - 4.0,
            lanes.at.inner[2][i] - 4.0,
        );
        let way = self.steepness * lanes.voxel[i] * (x * x + y * y + z * z).sqrt();
        let left = center.abs() - way;
        // Never quite 0, so that the sign survives.
        let left = if left > 1e-30 { left } else { 1e-30 };
        if center < 0.0 { -left } else { left }
    }
}

/// The key of no request.
pub const NO_REQUEST: u64 = u64::MAX;
