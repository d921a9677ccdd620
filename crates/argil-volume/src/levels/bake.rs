//! Measures and samples the cells of pages, each with its own pruned program.

use super::kept_list::{PageCells, PageList};
use super::layout::LevelsLayout;
use super::page::Page;
use crate::MISSING_BRICK;
use crate::Texel;
use crate::bricks::{BrickBaker, CellContext, CellNearness, PartPruner};
use argil_abi::Instruction;
use argil_field::{Program, Pruner};
use std::sync::Arc;

/// The largest deviation from a plane in a cell that is not refined, in voxels of level 0.
const FLAT: f32 = 0.125;

/// What all pages of a program share, level by level.
pub(super) struct PageContext<'a> {
    program: &'a Program,
    levels: Vec<CellContext<'a>>,
}

/// The state of a thread.
pub(super) struct PageBaker<'a> {
    levels: &'a [CellContext<'a>],
    pruner: Pruner<'a>,
    bakers: Vec<Option<BrickBaker<'a>>>,
    /// What the bakers of all levels share, because it grows with the longest program.
    part_pruner: Option<PartPruner<'a>>,
    /// The program of a cell.
    list: Vec<Instruction>,
}

/// A page to bake: where it is, its program, and the cells to sample, one bit each.
pub(super) struct PageJob<'a> {
    pub page: Page,
    pub list: PageList<'a>,
    pub cells: u8,
    /// What is known of its cells' programs.
    pub kept: Option<Arc<PageCells>>,
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
    /// What was found of its cells' programs, if it was not known.
    pub marks: Option<Arc<PageCells>>,
}

impl<T> Default for BakedPage<T> {
    fn default() -> Self {
        Self {
            words: [0; 8],
            clear: [0; 8],
            cells: Vec::new(),
            texels: Vec::new(),
            mixed: Vec::new(),
            marks: None,
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
        let levels = (0..layout.count()).map(|level| {
            let own = (layout.level(level), layout.is_wide(level));
            CellContext::new(program, own, tolerance)
        });
        Self {
            program,
            levels: levels.collect(),
        }
    }

    /// Measures the cells of a page: the distances at their centers. The pruner then knows their programs.
    pub(super) fn classify(
        &self,
        page: &Page,
        list: &[Instruction],
        pruner: &mut Pruner<'_>,
    ) -> [f32; 8] {
        let context = &self.levels[page.level as usize];
        let site = context.site(2 * page.place(), list);
        site.classify(context, list, pruner)
    }

    pub(super) fn program(&self) -> &'a Program {
        self.program
    }

    /// Returns the program of the whole scene.
    pub(super) fn whole(&self) -> PageList<'a> {
        PageList::Whole(self.program.instructions())
    }

    pub(super) fn pruner(&self) -> Pruner<'_> {
        Pruner::new(self.program)
    }

    pub(super) fn baker(&self) -> PageBaker<'_> {
        PageBaker {
            levels: &self.levels,
            pruner: Pruner::new(self.program),
            bakers: self.levels.iter().map(|_| None).collect(),
            part_pruner: None,
            list: Vec::new(),
        }
    }
}

impl PageBaker<'_> {
    /// Returns the programs of some of a page's cells, one bit each, given the page's. Also returns what was measured
    /// for that, if it was not known.
    pub(super) fn cell_lists(
        &mut self,
        page: &Page,
        list: &[Instruction],
        cells: u8,
        kept: Option<&PageCells>,
    ) -> ([Arc<[Instruction]>; 8], Option<Arc<PageCells>>) {
        let mut lists: [Arc<[Instruction]>; 8] = Default::default();
        let made = kept.is_none().then(|| self.measure(page, list));
        let own = kept.or(made.as_deref());
        for cell in (0..8).filter(|cell| cells >> cell & 1 != 0) {
            self.list.clear();
            if let Some(own) = own {
                let into = &mut self.list;
                self.pruner.prune_marked_into(list, &own.marks, cell, into);
            }
            lists[cell] = self.list[..].into();
        }
        (lists, made)
    }

    /// Returns the cells of a page that a surface can pass through, one bit each, and what was measured.
    pub(super) fn near_cells(&mut self, page: &Page, list: &[Instruction]) -> (u8, Arc<PageCells>) {
        let measured = self.measure(page, list);
        let context = &self.levels[page.level as usize];
        let site = context.site(2 * page.place(), list);
        let mut near = 0;
        for (cell, &distance) in (0u32..).zip(&measured.distances) {
            let is_near = match site.nearness(context, cell, distance) {
                CellNearness::Clear => false,
                CellNearness::Near => true,
                CellNearness::Doubtful => {
                    self.list.clear();
                    let (marks, into) = (&measured.marks, &mut self.list);
                    self.pruner
                        .prune_marked_into(list, marks, cell as usize, into);
                    !site.is_clear_in_parts(context, cell, &self.list)
                }
            };
            near |= u8::from(is_near) << cell;
        }
        (near, measured)
    }

    /// Measures the cells of a page.
    fn measure(&mut self, page: &Page, list: &[Instruction]) -> Arc<PageCells> {
        let context = &self.levels[page.level as usize];
        let site = context.site(2 * page.place(), list);
        let distances = site.classify(context, list, &mut self.pruner);
        let marks = self.pruner.cell_marks();
        PageCells { distances, marks }.into()
    }

    /// Measures a page, and samples some of its cells.
    pub(super) fn page<T: Texel>(&mut self, job: &PageJob<'_>) -> BakedPage<T> {
        let (measured, is_new) = match &job.kept {
            Some(kept) => (kept.clone(), false),
            None => (self.measure(&job.page, &job.list), true),
        };
        let mut made = BakedPage::default();
        let level = job.page.level as usize;
        let context = &self.levels[level];
        let baker = self.bakers[level].get_or_insert_with(|| context.baker());
        baker.pruner = self.part_pruner.take();
        let site = context.site(2 * job.page.place(), &job.list);
        for (cell, &distance) in (0u32..).zip(&measured.distances) {
            let index = cell as usize;
            let word = site.empty_word(distance);
            (made.clear[index], made.words[index]) = (word, word);
            let near = site.nearness(context, cell, distance);
            if near == CellNearness::Clear {
                continue;
            }
            let is_asked = job.cells >> cell & 1 != 0;
            if is_asked || near == CellNearness::Doubtful {
                self.list.clear();
                let (marks, into) = (&measured.marks, &mut self.list);
                self.pruner.prune_marked_into(&job.list, marks, index, into);
            }
            let is_doubtful = near == CellNearness::Doubtful;
            if is_doubtful && site.is_clear_in_parts(context, cell, &self.list) {
                continue;
            }
            made.words[index] = MISSING_BRICK;
            if !is_asked {
                continue;
            }
            let into = (&mut made.texels, &mut made.mixed);
            let brick = site.sample(context, cell, &self.list, baker, into);
            made.cells.push(BakedCell {
                cell,
                brick: brick.map(|brick| (brick.material, brick.is_flat)),
            });
        }
        self.part_pruner = baker.pruner.take();
        made.marks = is_new.then_some(measured);
        made
    }
}
