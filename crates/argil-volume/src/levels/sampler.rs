//! Reads levels at many points at once.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use super::page::{NO_PAGE, PAGE_VOXELS_LOG2, Page, octant_cells};
use super::requests::PageRequest;
use super::tree::Levels;
use crate::bricks::{center_of, is_brick, load_planes, load_voxels};
use crate::{CellLocations, NeighborPlanes, Texel, VoxelSamples};
use argil_field::LANES;
use glam::{DVec3, IVec3, Vec3};

/// Voxels along a page's side.
const PAGE_VOXELS: f32 = (1 << PAGE_VOXELS_LOG2) as f32;

/// The pages of points, and the positions in them.
#[derive(Debug)]
pub struct LevelLanes {
    /// The page of each point. Before a look-up, any page: the search begins there.
    pub page: [u32; LANES],
    /// The position in the page, in voxels of its level.
    pub place: [[f32; LANES]; 3],
    /// The edge of the page's voxels, in the scene's unit.
    pub voxel: [f32; LANES],
    /// By how many levels the page is too coarse although a finer one can exist. 0 if it is fine enough.
    pub gap: [f32; LANES],
    /// The octant of the page.
    pub octant: [u32; LANES],
    /// The cells, counted from the page's corner, and their words.
    pub at: CellLocations,
}

impl Default for LevelLanes {
    fn default() -> Self {
        Self {
            page: [0; LANES],
            place: [[0.0; LANES]; 3],
            voxel: [1.0; LANES],
            gap: [0.0; LANES],
            octant: [0; LANES],
            at: CellLocations::default(),
        }
    }
}

/// Levels, ready to be sampled by rays from one point.
#[derive(Debug)]
pub struct LevelSampler<'a, T> {
    levels: &'a Levels,
    pages: &'a [Page],
    words: &'a [u32],
    pool: &'a [T],
    count: u32,
    /// The voxel of level 0 that contains the camera, and the position in it.
    eye_voxel: IVec3,
    eye_inner: Vec3,
    voxel: f32,
    per_voxel: f32,
    /// The distance in voxels that one code step means, and the band in voxels.
    quantum: f32,
    band: f32,
    /// How much a distance can change over a voxel's edge, in voxels.
    steepness: f32,
    root: u32,
}

impl<'a, T: Texel> LevelSampler<'a, T> {
    /// Creates a sampler for rays from a point. Returns `None` if the samples have another type.
    pub fn new(levels: &'a Levels, eye: Vec3) -> Option<Self> {
        let layout = levels.layout().level(0);
        let grid = &layout.voxel_grid;
        let pool = levels.pool().of::<T>()?;
        let band = layout.encoding.band_width(grid, 0) / grid.voxel_size;
        let away = (eye.as_dvec3() - grid.corner.as_dvec3()) / f64::from(grid.voxel_size);
        let limit = DVec3::splat(f64::from(1 << 30));
        let eye_voxel = away.clamp(-limit, limit).floor();
        Some(Self {
            levels,
            pages: levels.pages(),
            words: levels.words(),
            pool,
            count: levels.brick_count() as u32,
            eye_voxel: eye_voxel.as_ivec3(),
            eye_inner: (away - eye_voxel).as_vec3(),
            voxel: grid.voxel_size,
            per_voxel: 1.0 / grid.voxel_size,
            quantum: band / layout.encoding.format.max_code() as f32,
            band,
            steepness: 1.000_01 * levels.lipschitz(),
            root: levels.layout().root(),
        })
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

    /// Returns a position for a way from the camera, in the scene's unit along an axis: see [`LevelSampler::locate`].
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

    /// Finds the finest resident pages of some levels or coarser ones that contain points. Points are in voxels of
    /// level 0, counted from the camera's voxel. Points outside the world count as the nearest ones inside.
    #[inline(always)]
    pub fn locate(&self, points: [&[f32]; 3], wanted: &[u32], out: &mut LevelLanes) {
        let n = wanted.len().min(LANES);
        for i in 0..n {
            let point = [points[0][i], points[1][i], points[2][i]];
            let (slot, place) = self.search(point, wanted[i], out.page[i]);
            out.page[i] = slot;
            let page = &self.pages[slot as usize];
            let mut index = 0;
            for axis in 0..3 {
                let own = place[axis].clamp(0.0, PAGE_VOXELS);
                let cell = (own * 0.125).min(3.0).floor();
                out.place[axis][i] = own;
                out.at.cell[axis][i] = cell;
                out.at.inner[axis][i] = own - 8.0 * cell;
                index += (cell as u32) << (2 * axis);
            }
            let index = slot * 64 + index;
            out.at.index[i] = index;
            out.at.word[i] = self.words[index as usize];
            out.voxel[i] = self.voxel * power(page.level);
            let octant = octant_of(place);
            out.octant[i] = octant;
            let is_coarse = page.level > wanted[i]
                && self.levels.open[slot as usize] & octant_cells(octant) != 0;
            out.gap[i] = if is_coarse {
                (page.level - wanted[i]) as f32
            } else {
                0.0
            };
        }
    }

    /// Returns the page of a point, and the position in it.
    #[inline(always)]
    fn search(&self, point: [f32; 3], wanted: u32, from: u32) -> (u32, [f32; 3]) {
        let mut slot = from;
        let mut place;
        loop {
            let page = &self.pages[slot as usize];
            place = self.place_in(page, point);
            let is_inside = place.iter().all(|p| (0.0..PAGE_VOXELS).contains(p));
            if is_inside && page.level >= wanted {
                break;
            }
            if page.parent == NO_PAGE {
                if !is_inside {
                    slot = self.root_of(page, place);
                    place = self.place_in(&self.pages[slot as usize], point);
                }
                break;
            }
            slot = page.parent;
        }
        loop {
            let page = &self.pages[slot as usize];
            if page.level <= wanted {
                break;
            }
            let child = page.children[octant_of(place) as usize];
            if child == NO_PAGE {
                break;
            }
            slot = child;
            place = self.place_in(&self.pages[slot as usize], point);
        }
        (slot, place)
    }

    /// Returns the position of a point in a page, in voxels of its level.
    #[inline(always)]
    fn place_in(&self, page: &Page, point: [f32; 3]) -> [f32; 3] {
        let scale = 1.0 / power(page.level);
        [0, 1, 2].map(|axis| {
            let origin = page.origin[axis].wrapping_sub(self.eye_voxel[axis]);
            (point[axis] - origin as f32) * scale
        })
    }

    /// Returns the page of the coarsest level for a position relative to another one.
    fn root_of(&self, page: &Page, place: [f32; 3]) -> u32 {
        let (low, size, roots) = self.levels.roots();
        let at = page.block() - low;
        let at = [0, 1, 2].map(|axis: usize| {
            let away = (place[axis] * (1.0 / PAGE_VOXELS)).floor();
            // NaN becomes 0.
            let away = away.clamp(-1e6, 1e6) as i32;
            (at[axis] + away).clamp(0, size[axis] - 1)
        });
        roots[(at[0] + size.x * (at[1] + size.y * at[2])) as usize]
    }

    /// Returns any page, where a search can begin.
    pub fn any_page(&self) -> u32 {
        self.levels.roots().2[0]
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
            let cell = [0, 1, 2].map(|a: usize| lanes.at.cell[a][i] as i32);
            self.neighbor(lanes.page[i], cell, axis, goes_up, &mut asked.borrow_mut())
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
        slot: u32,
        mut cell: [i32; 3],
        axis: usize,
        goes_up: bool,
        asked: &mut Vec<PageRequest>,
    ) -> Option<u32> {
        cell[axis] += if goes_up { 1 } else { -1 };
        let mut slot = slot;
        if !(0..4).contains(&cell[axis]) {
            let page = &self.pages[slot as usize];
            let mut block = page.block();
            block[axis] += if goes_up { 1 } else { -1 };
            cell[axis] &= 3;
            slot = self.levels.find(page.level, block)?;
            let found = &self.pages[slot as usize];
            if found.level > page.level {
                let inner = (block >> (found.level - 1 - page.level)) & 1;
                let octant = (inner.x + 2 * inner.y + 4 * inner.z) as u32;
                if self.levels.open[slot as usize] & octant_cells(octant) != 0 {
                    let gap = (found.level - page.level) as f32;
                    asked.push(PageRequest::new(slot, octant, gap, 0.0));
                }
                return None;
            }
        }
        let index = cell[0] + 4 * cell[1] + 16 * cell[2];
        let word = self.words[(slot * 64 + index as u32) as usize];
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

/// Returns 2 to the power of a level.
#[inline(always)]
fn power(level: u32) -> f32 {
    f32::from_bits((127 + level) << 23)
}

/// Returns the octant of a position in a page.
#[inline(always)]
fn octant_of(place: [f32; 3]) -> u32 {
    let half = 0.5 * PAGE_VOXELS;
    u32::from(place[0] >= half)
        | u32::from(place[1] >= half) << 1
        | u32::from(place[2] >= half) << 2
}
