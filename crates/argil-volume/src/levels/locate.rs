//! Finds the cells of many points at once.
//!
//! *Practice.* Most points are in the page that their lane searched last, in one of its eight cells. All lanes take
//! these steps together, in plain loops that the compiler turns into SIMD. Only the others search one by one.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use super::page::{NO_PAGE, PAGE_VOXELS_LOG2, Page, is_page};
use super::page_starts::{ENTRIES, PageStarts};
use super::requests::PageAim;
use super::sampler::{LevelLanes, LevelSampler, NO_REQUEST};
use crate::{MISSING_BRICK, Texel, is_brick};
use argil_field::LANES;
use argil_math::set_indices;
use glam::IVec3;

/// What a search found.
struct Found {
    cell: u32,
    gap: f32,
    key: u64,
}

/// The pages of lanes: their corners, in voxels of level 0, and their levels.
struct LanePages {
    origin: [[i32; LANES]; 3],
    level: [u32; LANES],
}

impl LanePages {
    #[inline(always)]
    fn set(&mut self, i: usize, page: &Page) {
        for axis in 0..3 {
            self.origin[axis][i] = page.origin[axis];
        }
        self.level[i] = page.level;
    }
}

impl<T: Texel> LevelSampler<'_, T> {
    /// Finds the finest usable cells at points, on some levels or coarser ones: those that have a resident brick or
    /// no surface. Points are in voxels of level 0, counted from the camera's voxel. Points outside the world count as
    /// the nearest ones inside.
    #[inline(always)]
    pub fn locate(&self, points: [&[f32]; 3], wanted: &[u32], out: &mut LevelLanes) {
        let n = wanted.len().min(LANES);
        let wanted = &wanted[..n];
        // Whole voxels tell which cells contain a point, without rounding, whatever page a search comes from.
        let mut voxels = [[0i32; LANES]; 3];
        for axis in 0..3 {
            let (eye, [low, high]) = (self.eye_voxel[axis], self.held[axis]);
            for (voxel, away) in voxels[axis].iter_mut().zip(&points[axis][..n]) {
                let away = away.clamp(-1e9, 1e9).floor() as i32;
                *voxel = eye.wrapping_add(away).max(low).min(high);
            }
        }
        let mut pages = self.pages_of(&voxels, wanted, out);
        for i in 0..n {
            let bit = pages.level[i] + PAGE_VOXELS_LOG2 - 1;
            let half = |axis: usize| (voxels[axis][i] >> bit) as u32 & 1;
            out.at.index[i] = 8 * out.page[i] + (half(0) | half(1) << 1 | half(2) << 2);
        }
        self.load_words(n, out);
        let mut children = [0u32; LANES];
        for i in 0..n {
            // SAFETY: cells of pages have children, as the constructor checked.
            children[i] = unsafe { *self.children.get_unchecked(out.at.index[i] as usize) };
        }
        let mut goes_on = [0u8; LANES];
        for i in 0..n {
            let (word, child) = (out.at.word[i], children[i]);
            let can_be_finer = (pages.level[i] > wanted[i]) & (is_page(child) | (child == NO_PAGE));
            goes_on[i] = u8::from(is_brick(word) & (can_be_finer | (word == MISSING_BRICK)));
            out.gap[i] = 0.0;
            out.key[i] = NO_REQUEST;
        }
        for i in set_indices(&goes_on) {
            let voxel = [voxels[0][i], voxels[1][i], voxels[2][i]];
            let found = self.descend(voxel, wanted[i], (out.page[i], pages.level[i]));
            (out.gap[i], out.key[i], out.at.index[i]) = (found.gap, found.key, found.cell);
            out.aim[i] = PageAim {
                voxel,
                level: wanted[i],
            };
            out.page[i] = found.cell / 8;
            out.at.word[i] = self.words[found.cell as usize];
            pages.set(i, &self.pages[out.page[i] as usize]);
        }
        for axis in 0..3 {
            let (cells, inner) = (&mut out.at.cell[axis], &mut out.at.inner[axis]);
            for i in 0..n {
                let upper = (out.at.index[i] >> axis & 1) as f32;
                let origin = pages.origin[axis][i].wrapping_sub(self.eye_voxel[axis]);
                let place = (points[axis][i] - origin as f32) * inverse_power(pages.level[i]);
                cells[i] = upper;
                inner[i] = (place - 8.0 * upper).clamp(0.0, 8.0);
            }
        }
        for i in 0..n {
            out.voxel[i] = self.voxel * power(pages.level[i]);
        }
    }

    /// Moves each lane's search to a page that contains its voxel, on its wanted level or a coarser one. Returns these
    /// pages.
    #[inline(always)]
    fn pages_of(
        &self,
        voxels: &[[i32; LANES]; 3],
        wanted: &[u32],
        out: &mut LevelLanes,
    ) -> LanePages {
        let n = wanted.len();
        let mut pages = LanePages {
            origin: [[0; LANES]; 3],
            level: [0; LANES],
        };
        let last = self.pages.len() as u32 - 1;
        for i in 0..n {
            out.page[i] = out.page[i].min(last);
        }
        // SAFETY: no lane's page is greater than the last.
        let page_of = |slot: u32| unsafe { self.pages.get_unchecked(slot as usize) };
        for axis in 0..3 {
            for i in 0..n {
                pages.origin[axis][i] = page_of(out.page[i]).origin[axis];
            }
        }
        for i in 0..n {
            pages.level[i] = page_of(out.page[i]).level;
        }
        let mut leaves = [0u8; LANES];
        for i in 0..n {
            let side = 1 << (PAGE_VOXELS_LOG2 + pages.level[i]);
            let away = |axis: usize| voxels[axis][i].wrapping_sub(pages.origin[axis][i]) as u32;
            let is_inside = (away(0) < side) & (away(1) < side) & (away(2) < side);
            leaves[i] = u8::from(!(is_inside & (pages.level[i] >= wanted[i])));
        }
        // Lanes are near one another: where one went, the next ones often go.
        let mut near = out.page[0];
        for i in set_indices(&leaves) {
            let voxel = [voxels[0][i], voxels[1][i], voxels[2][i]];
            near = self.climb(voxel, wanted[i], near);
            let bottom = self.deepest(voxel, wanted[i], near);
            (near, out.page[i]) = (bottom, bottom);
            pages.set(i, &self.pages[bottom as usize]);
        }
        pages
    }

    /// Returns a page that contains a voxel, on the wanted level or a coarser one, going up from a page.
    #[inline(always)]
    fn climb(&self, voxel: [i32; 3], wanted: u32, mut slot: u32) -> u32 {
        loop {
            let page = &self.pages[slot as usize];
            let away = [0, 1, 2].map(|axis| voxel[axis].wrapping_sub(page.origin[axis]) as u32);
            let side = 1 << (PAGE_VOXELS_LOG2 + page.level);
            let is_inside = (away[0] < side) & (away[1] < side) & (away[2] < side);
            if is_inside && page.level >= wanted {
                return slot;
            }
            if page.parent == NO_PAGE {
                return if is_inside { slot } else { self.root_of(voxel) };
            }
            slot = page.parent / 8;
        }
    }

    /// Returns the finest page below a page that contains a voxel, down to the wanted level.
    #[inline(always)]
    fn deepest(&self, voxel: [i32; 3], wanted: u32, mut slot: u32) -> u32 {
        let mut level = self.pages[slot as usize].level;
        while level > wanted {
            let cell = 8 * slot + octant_of(voxel, level + PAGE_VOXELS_LOG2 - 1);
            let child = self.children[cell as usize];
            if !is_page(child) {
                break;
            }
            (slot, level) = (child, level - 1);
        }
        slot
    }

    /// Returns the finest cell at a voxel that has a resident brick or no surface, going down from a page.
    #[inline(always)]
    fn descend(&self, voxel: [i32; 3], wanted: u32, (mut slot, mut level): (u32, u32)) -> Found {
        loop {
            let cell = 8 * slot + octant_of(voxel, level + PAGE_VOXELS_LOG2 - 1);
            let found = Found {
                cell,
                gap: 0.0,
                key: NO_REQUEST,
            };
            let word = self.words[cell as usize];
            if !is_brick(word) {
                return found;
            }
            let child = self.children[cell as usize];
            if level > wanted && is_page(child) {
                (slot, level) = (child, level - 1);
                continue;
            }
            if word == MISSING_BRICK {
                return self.fall_back(cell, (level, wanted));
            }
            if level > wanted && child == NO_PAGE {
                let inner = octant_of(voxel, level + PAGE_VOXELS_LOG2 - 2);
                return Found {
                    gap: (level - wanted) as f32,
                    key: child_key(cell, inner),
                    ..found
                };
            }
            return found;
        }
    }

    /// Returns the finest resident brick above a cell whose brick is missing.
    #[inline(never)]
    fn fall_back(&self, missing: u32, (level, wanted): (u32, u32)) -> Found {
        let cell = self.levels.resident_above(missing);
        let page = &self.pages[cell as usize / 8];
        let gap = (page.level - wanted.min(level)) as f32;
        Found {
            cell,
            gap: gap.max(1.0),
            key: 16 * u64::from(missing),
        }
    }

    /// Loads the words of lanes' cells.
    #[inline(always)]
    fn load_words(&self, n: usize, out: &mut LevelLanes) {
        for i in 0..n {
            // SAFETY: cells of pages have words, as the constructor checked.
            out.at.word[i] = unsafe { *self.words.get_unchecked(out.at.index[i] as usize) };
        }
    }

    /// Sets a lane's cell, and the position of a point in it.
    #[inline(always)]
    pub(super) fn set_cell(&self, cell: u32, point: [f32; 3], i: usize, out: &mut LevelLanes) {
        let page = &self.pages[cell as usize / 8];
        for axis in 0..3 {
            let upper = (cell >> axis & 1) as f32;
            let origin = page.origin[axis].wrapping_sub(self.eye_voxel[axis]);
            let place = (point[axis] - origin as f32) * inverse_power(page.level);
            out.at.cell[axis][i] = upper;
            out.at.inner[axis][i] = (place - 8.0 * upper).clamp(0.0, 8.0);
        }
        out.page[i] = cell / 8;
        out.at.index[i] = cell;
        out.at.word[i] = self.words[cell as usize];
        out.voxel[i] = self.voxel * power(page.level);
    }

    /// Returns the page of the coarsest level that contains a voxel of level 0.
    fn root_of(&self, voxel: [i32; 3]) -> u32 {
        let (low, size, roots) = self.levels.roots();
        let at = (IVec3::from_array(voxel) >> (PAGE_VOXELS_LOG2 + self.root)) - low;
        let at = at.clamp(IVec3::ZERO, size - 1);
        roots[(at.x + size.x * (at.y + size.y * at.z)) as usize]
    }

    /// Returns the finest page that contains a voxel of level 0, on a level or a coarser one.
    pub(super) fn page_at(&self, voxel: [i32; 3], wanted: u32) -> u32 {
        self.deepest(voxel, wanted, self.root_of(voxel))
    }

    /// Returns any page, where a search can begin.
    pub fn any_page(&self) -> u32 {
        self.levels.roots().2[0]
    }
}

impl<T: Texel> LevelSampler<'_, T> {
    /// Prepares for points that have little to do with one another: their searches begin at the finest page of their
    /// place, if there are few pages, and else near that.
    pub fn with_starts(mut self) -> Self {
        let [low, high] = [0, 1].map(|end| IVec3::from_array(self.held.map(|range| range[end])));
        let mut edge_log2 = PAGE_VOXELS_LOG2;
        let (first, size) = loop {
            let (first, last) = (low >> edge_log2, high >> edge_log2);
            let size = last - first + 1;
            if size.as_vec3().element_product() <= ENTRIES as f32 {
                break (first, size);
            }
            edge_log2 += 1;
        };
        let mut pages = Vec::new();
        for z in 0..size.z {
            for y in 0..size.y {
                for x in 0..size.x {
                    let voxel = (first + IVec3::new(x, y, z)) << edge_log2;
                    let wanted = edge_log2 - PAGE_VOXELS_LOG2;
                    pages.push(self.page_at(voxel.to_array(), wanted));
                }
            }
        }
        self.starts = Some(PageStarts {
            pages,
            edge_log2,
            first: first.to_array(),
            size: size.to_array(),
        });
        self
    }

    /// Sets the pages at which the searches of points begin: see [`LevelSampler::locate`].
    #[inline(always)]
    pub fn set_starts(&self, points: [&[f32]; 3], out: &mut LevelLanes) {
        let Some(starts) = &self.starts else { return };
        let n = points[0].len().min(LANES);
        let mut at = [0i32; LANES];
        for axis in (0..3).rev() {
            let (eye, first, size) = (self.eye_voxel[axis], starts.first[axis], starts.size[axis]);
            for i in 0..n {
                let away = points[axis][i].clamp(-1e9, 1e9).floor() as i32;
                let cube = (eye.wrapping_add(away) >> starts.edge_log2) - first;
                at[i] = at[i] * size + cube.max(0).min(size - 1);
            }
        }
        for i in 0..n {
            out.page[i] = starts.pages[at[i] as usize];
        }
    }
}

/// Returns 2 to the power of a level.
#[inline(always)]
fn power(level: u32) -> f32 {
    f32::from_bits((127 + level) << 23)
}

/// Returns 1 through 2 to the power of a level.
#[inline(always)]
fn inverse_power(level: u32) -> f32 {
    f32::from_bits((127 - level) << 23)
}

/// Returns the octant of a voxel, given the bit of its coordinates that tells the half.
#[inline(always)]
fn octant_of(voxel: [i32; 3], bit: u32) -> u32 {
    let [x, y, z] = voxel.map(|c| (c >> bit) as u32 & 1);
    x | y << 1 | z << 2
}

#[inline(always)]
fn child_key(cell: u32, inner: u32) -> u64 {
    16 * u64::from(cell) + 8 + u64::from(inner)
}
