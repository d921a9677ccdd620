//! The leaves of levels, for meshes: the cells without finer ones.

use super::bake::PageContext;
use super::fill::FillStats;
use super::kept_list::PageList;
use super::page::{NO_PAGE, is_page, octant_place};
use super::requests::PageRequest;
use super::tree::Levels;
use crate::{MISSING_BRICK, is_brick};
use argil_field::Program;
use glam::{DVec3, IVec3, Vec3};
use rustc_hash::FxHashMap;

/// A cell without finer ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafCell {
    /// The index of the cell: eight times its page's slot, plus its place.
    pub cell: u32,
    /// The level. 0 is the finest.
    pub level: u32,
    /// The minimum corner, in voxels of level 0.
    pub origin: IVec3,
}

impl LeafCell {
    /// Returns the index of the voxel that contains a voxel of level 0, from 0 to 511, x fastest.
    pub fn voxel_of(&self, voxel: IVec3) -> u32 {
        let at = ((voxel - self.origin) >> self.level).clamp(IVec3::ZERO, IVec3::splat(7));
        (at.x + 8 * (at.y + 8 * at.z)) as u32
    }
}

impl Levels {
    /// Bakes all cells whose voxels are larger than `size` times their distance from a point, wherever they are.
    /// Bakes nothing that rays asked for.
    pub fn refine_around(&mut self, program: &Program, eye: Vec3, size: f32) -> FillStats {
        let mut done = FillStats::default();
        loop {
            self.requests.take();
            self.begin_frame();
            let (mut used, mut asked) = (Vec::new(), Vec::new());
            for slot in self.slots() {
                let page = &self.pages[slot as usize];
                let layout = self.layout.level(page.level);
                for cell in 8 * slot..8 * slot + 8 {
                    let word = self.store.words[cell as usize];
                    if !is_brick(word) {
                        continue;
                    }
                    used.push(cell);
                    let child = self.children[cell as usize];
                    if word == MISSING_BRICK && !is_page(child) {
                        asked.push(PageRequest::of_cell(cell, 1.0, 0.0));
                        continue;
                    }
                    let held = layout.cell_box(2 * page.place() + octant_place(cell % 8));
                    let wanted = size * held.distance(eye);
                    if child == NO_PAGE && layout.voxel_grid.voxel_size > wanted && page.level > 0 {
                        let gap = page.level as f32;
                        asked.extend((0..8).map(|i| PageRequest::of_child(cell, i, gap, 0.0)));
                    }
                }
            }
            if asked.is_empty() {
                return done;
            }
            self.note(&used, &asked);
            let coarsening = self.coarsening;
            let own = self.fill(program, None);
            self.coarsening = coarsening;
            done += own;
            if own.is_full {
                return done;
            }
        }
    }

    /// Returns all leaves that have a brick.
    pub fn leaves(&self) -> Vec<LeafCell> {
        let cells = self.store.cell_of_brick.iter().copied();
        cells
            .filter(|&cell| !is_page(self.children[cell as usize]))
            .map(|cell| self.leaf(cell))
            .collect()
    }

    /// Describes a cell.
    pub fn leaf(&self, cell: u32) -> LeafCell {
        let page = &self.pages[cell as usize / 8];
        LeafCell {
            cell,
            level: page.level,
            origin: IVec3::from_array(page.origin) + (octant_place(cell % 8) << (3 + page.level)),
        }
    }

    /// Returns the leaf that contains a voxel of level 0, or `None` outside the world.
    pub fn leaf_at(&self, voxel: IVec3) -> Option<LeafCell> {
        let cell = self.find(0, voxel >> 3)?;
        Some(self.leaf(cell))
    }

    /// Whether a leaf has a brick.
    pub fn has_brick(&self, leaf: &LeafCell) -> bool {
        let word = self.store.words[leaf.cell as usize];
        is_brick(word) && word != MISSING_BRICK
    }

    /// Returns the codes of a leaf's 9³ samples, x fastest. Negative ones are inside. A code is a fraction of the band,
    /// which is a number of the leaf's voxels. Returns zeros for a leaf without a brick.
    pub fn leaf_samples(&self, leaf: &LeafCell) -> Box<[i16; 729]> {
        let mut out = Box::new([0i16; 729]);
        if !self.has_brick(leaf) {
            return out;
        }
        let from = self.store.words[leaf.cell as usize] as usize * 729;
        if let Some(all) = self.store.pool.of::<i16>() {
            out.copy_from_slice(&all[from..from + 729]);
        } else if let Some(all) = self.store.pool.of::<i8>() {
            for (out, &code) in out.iter_mut().zip(&all[from..from + 729]) {
                *out = code.into();
            }
        }
        out
    }

    /// Returns the code of a leaf's sample, counted from its corner. Returns 0 for a leaf without a brick.
    pub fn leaf_sample(&self, leaf: &LeafCell, at: IVec3) -> i16 {
        if !self.has_brick(leaf) {
            return 0;
        }
        let at = at.clamp(IVec3::ZERO, IVec3::splat(8));
        let index = (at.x + 9 * (at.y + 9 * at.z)) as usize;
        let place = self.store.words[leaf.cell as usize] as usize * 729 + index;
        match (self.store.pool.of::<i16>(), self.store.pool.of::<i8>()) {
            (Some(all), _) => all[place],
            (_, Some(all)) => all[place].into(),
            _ => 0,
        }
    }

    /// Returns a position in the scene's unit, given one in voxels of level 0.
    pub fn point_at(&self, voxels: DVec3) -> Vec3 {
        let grid = self.layout.finest_grid();
        (grid.corner.as_dvec3() + voxels * f64::from(grid.voxel_size)).as_vec3()
    }

    /// Returns the pruned programs of the pages of some cells, by slot. They are valid in the whole page.
    pub fn page_programs<'a>(
        &mut self,
        program: &'a Program,
        cells: impl IntoIterator<Item = u32>,
    ) -> FxHashMap<u32, PageList<'a>> {
        let mut slots: Vec<u32> = cells.into_iter().map(|cell| cell / 8).collect();
        slots.sort_unstable();
        slots.dedup();
        let context = PageContext::new(program, &self.layout);
        self.lists_of(&context, &slots)
    }
}
