//! Bakes pages, each with its own pruned program.

use super::layout::LevelsLayout;
use super::page::octant_place;
use crate::bricks::{BakedBlock, BlockContext, BrickBaker};
use crate::{BLOCK_SIDE, Texel};
use argil_abi::Instruction;
use argil_field::{Program, Pruner};
use glam::{IVec3, Vec3};

/// The largest deviation from a plane in a cell that is not refined, in voxels of level 0.
const FLAT: f32 = 0.125;

/// What all pages of a program share, level by level.
pub(super) struct PageContext<'a> {
    program: &'a Program,
    levels: Vec<BlockContext<'a>>,
}

/// The state of a thread.
pub(super) struct PageBaker<'a> {
    program: &'a Program,
    levels: &'a [BlockContext<'a>],
    pruner: Pruner<'a>,
    bakers: Vec<Option<BrickBaker<'a>>>,
}

impl<'a> PageContext<'a> {
    pub(super) fn new(program: &'a Program, layout: &LevelsLayout) -> Self {
        let tolerance = FLAT * layout.finest().voxel_grid.voxel_size;
        let levels = (0..layout.len())
            .map(|level| BlockContext::new(program, layout.level(level), tolerance));
        Self {
            program,
            levels: levels.collect(),
        }
    }

    pub(super) fn baker(&self) -> PageBaker<'_> {
        PageBaker {
            program: self.program,
            levels: &self.levels,
            pruner: Pruner::new(self.program),
            bakers: self.levels.iter().map(|_| None).collect(),
        }
    }
}

impl PageBaker<'_> {
    /// Returns the program of a page of the coarsest level.
    pub(super) fn root_list(&mut self, block: IVec3) -> Vec<Instruction> {
        let mut list = Vec::new();
        let all = self.program.instructions();
        let level = self.levels.len() - 1;
        self.prune(all, level, &[block], |_, pruner| {
            pruner.prune_into(all, 0, &mut list);
        });
        list
    }

    /// Returns the programs of some octants of a page, given the page's. All octants are classified together, so
    /// that a page's program depends on nothing but the whole program.
    pub(super) fn octant_lists(
        &mut self,
        level: u32,
        block: IVec3,
        list: &[Instruction],
        some: u8,
    ) -> [Vec<Instruction>; 8] {
        let mut lists: [Vec<Instruction>; 8] = Default::default();
        let blocks: [IVec3; 8] =
            std::array::from_fn(|octant| 2 * block + octant_place(octant as u32));
        self.prune(list, level as usize - 1, &blocks, |octant, pruner| {
            if some >> octant & 1 != 0 {
                pruner.prune_into(list, octant, &mut lists[octant]);
            }
        });
        lists
    }

    /// Classifies blocks of a level that share a program, and visits each.
    fn prune(
        &mut self,
        list: &[Instruction],
        level: usize,
        blocks: &[IVec3],
        mut visit: impl FnMut(usize, &mut Pruner<'_>),
    ) {
        let layout = &self.levels[level].layout;
        let middle = |block: &IVec3| layout.center(*block * BLOCK_SIDE as i32, BLOCK_SIDE);
        let centers: Vec<Vec3> = blocks.iter().map(middle).collect();
        let mut d = [0.0; 8];
        let radius = layout.half_diagonal(BLOCK_SIDE);
        let d = &mut d[..blocks.len()];
        self.pruner.classify_cells(list, &centers, radius, d);
        for nth in 0..blocks.len() {
            visit(nth, &mut self.pruner);
        }
    }

    /// Bakes a page with its program.
    pub(super) fn page<T: Texel>(
        &mut self,
        level: u32,
        block: IVec3,
        list: &[Instruction],
    ) -> BakedBlock<T> {
        let context = &self.levels[level as usize];
        let baker = self.bakers[level as usize].get_or_insert_with(|| context.baker());
        context.bake(block * BLOCK_SIDE as i32, list, &mut self.pruner, baker)
    }
}
