//! Measures and samples the cells of pages, each with its own pruned program.

use super::layout::LevelsLayout;
use super::page::{Page, octant_cells, page_cell};
use crate::MISSING_BRICK;
use crate::bricks::{BrickBaker, CellContext, PartPruner};
use crate::{BLOCK_SIDE, Texel};
use argil_abi::Instruction;
use argil_field::{CELLS_PER_BATCH, Program, Pruner};
use glam::IVec3;
use std::sync::Arc;

/// The largest deviation from a plane in a cell that is not refined, in voxels of level 0.
const FLAT: f32 = 0.125;

/// Programs of more instructions are pruned for one cell at a time.
const LONG_LIST: usize = 1 << 16;

/// What all pages of a program share, level by level.
pub(super) struct PageContext<'a> {
    program: &'a Program,
    levels: Vec<CellContext<'a>>,
}

/// The state of a thread.
pub(super) struct PageBaker<'a> {
    program: &'a Program,
    levels: &'a [CellContext<'a>],
    pruner: Pruner<'a>,
    bakers: Vec<Option<BrickBaker<'a>>>,
    /// What the bakers of all levels share, because it grows with the longest program.
    part_pruner: Option<PartPruner<'a>>,
}

/// A page to bake: where it is, its program, and the cells to sample, one bit each.
pub(super) struct PageJob {
    pub page: Page,
    pub list: Arc<[Instruction]>,
    pub cells: u8,
    /// The cells to measure, one bit each. Words of others are not set.
    pub measured: u8,
}

/// A sampled cell.
pub(super) struct BakedCell {
    pub cell: u32,
    /// The brick's material and whether it is flat, or `None` if no surface passes through the cell.
    pub brick: Option<(u32, bool)>,
}

/// A measured page, and the bricks of some of its cells.
pub(super) struct BakedPage<T> {
    /// The words of cells without a surface, and [`MISSING_BRICK`] for the others.
    pub words: [u32; 8],
    /// The words that cells get if their samples show that they have no surface.
    pub clear: [u32; 8],
    pub cells: Vec<BakedCell>,
    pub texels: Vec<T>,
    pub mixed: Vec<[u32; 2]>,
}

impl<T> Default for BakedPage<T> {
    fn default() -> Self {
        Self {
            words: [0; 8],
            clear: [0; 8],
            cells: Vec::new(),
            texels: Vec::new(),
            mixed: Vec::new(),
        }
    }
}

impl<T> BakedPage<T> {
    /// Returns the number of bricks.
    pub(super) fn bricks(&self) -> u64 {
        self.cells.iter().filter(|own| own.brick.is_some()).count() as u64
    }
}

impl<'a> PageContext<'a> {
    pub(super) fn new(program: &'a Program, layout: &LevelsLayout) -> Self {
        let tolerance = FLAT * layout.finest().voxel_grid.voxel_size;
        let levels = (0..layout.count())
            .map(|level| CellContext::new(program, layout.level(level), tolerance));
        Self {
            program,
            levels: levels.collect(),
        }
    }

    pub(super) fn pruner(&self) -> Pruner<'_> {
        Pruner::new(self.program)
    }

    pub(super) fn baker(&self) -> PageBaker<'_> {
        PageBaker {
            program: self.program,
            levels: &self.levels,
            pruner: Pruner::new(self.program),
            bakers: self.levels.iter().map(|_| None).collect(),
            part_pruner: None,
        }
    }
}

impl PageBaker<'_> {
    /// Returns the program of a page of the coarsest level.
    pub(super) fn root_list(&mut self, place: IVec3) -> Arc<[Instruction]> {
        let mut list = Vec::new();
        let all = self.program.instructions();
        let Some(context) = self.levels.last() else {
            return list.into();
        };
        let side = BLOCK_SIDE / 2;
        let center = context.layout.center(place * side as i32, side);
        let radius = context.layout.half_diagonal(side);
        self.pruner
            .classify_cells(all, &[center], radius, &mut [0.0]);
        self.pruner.prune_into(all, 0, &mut list);
        list.into()
    }

    /// Returns the programs of some of a page's cells, one bit each, given the page's. Cells without a surface have
    /// none.
    pub(super) fn cell_lists(
        &mut self,
        page: &Page,
        list: &[Instruction],
        cells: u8,
    ) -> [Arc<[Instruction]>; 8] {
        let mut lists: [Arc<[Instruction]>; 8] = Default::default();
        let context = &self.levels[page.level as usize];
        let (block, octant) = page.block();
        let mut words = [0; CELLS_PER_BATCH];
        let own = octant_cells(octant);
        let is_asked = |inner: &u8| cells >> page_cell(*inner) & 1 != 0;
        let some = (0..64u8).filter(|inner| own >> inner & 1 != 0 && is_asked(inner));
        let some = some.fold(0, |some, inner| some | 1u64 << inner);
        let found = context.measure(block, (list, some), &mut self.pruner, &mut words);
        for (inner, range) in found.cells {
            lists[page_cell(inner) as usize] = found.instructions[range].into();
        }
        lists
    }

    /// Measures a page, and samples some of its cells.
    pub(super) fn page<T: Texel>(&mut self, job: &PageJob) -> BakedPage<T> {
        let level = job.page.level as usize;
        let context = &self.levels[level];
        let baker = self.bakers[level].get_or_insert_with(|| context.baker());
        baker.pruner = self.part_pruner.take();
        let (block, octant) = job.page.block();
        let is_measured = |inner: &u8| job.measured >> page_cell(*inner) & 1 != 0;
        let own = octant_cells(octant);
        let own = (0..64u8)
            .filter(|inner| own >> inner & 1 != 0 && is_measured(inner))
            .fold(0, |some, inner| some | 1u64 << inner);
        let mut made = BakedPage::default();
        // The programs of all cells are in memory at once, so long ones come cell by cell.
        let is_long = job.list.len() > LONG_LIST;
        let single = (0..64).map(|inner| own & 1 << inner);
        let batches = single.filter(|&one| is_long && one != 0);
        for some in batches.chain((!is_long).then_some(own)) {
            let mut words = [0; CELLS_PER_BATCH];
            let listed = (&job.list[..], some);
            let found = context.measure(block, listed, &mut self.pruner, &mut words);
            for inner in (0..64u8).filter(|inner| some >> inner & 1 != 0) {
                let cell = page_cell(inner) as usize;
                (made.clear[cell], made.words[cell]) =
                    (words[usize::from(inner)], words[usize::from(inner)]);
            }
            for (inner, range) in &found.cells {
                let cell = page_cell(*inner);
                made.words[cell as usize] = MISSING_BRICK;
                if job.cells >> cell & 1 == 0 {
                    continue;
                }
                let list = &found.instructions[range.clone()];
                let into = (&mut made.texels, &mut made.mixed);
                let brick = context.sample((block, *inner), list, baker, into);
                made.cells.push(BakedCell {
                    cell,
                    brick: brick.map(|brick| (brick.material, brick.is_flat)),
                });
            }
        }
        self.part_pruner = baker.pruner.take();
        made
    }
}
