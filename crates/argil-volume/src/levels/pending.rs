//! The state of levels for edits in place.

use super::layout::LevelsLayout;
use super::page::{NO_PAGE, Page};
use crate::{PendingEdits, TooFarError, VoxelGrid};
use argil_field::{IncrementalProgram, PartGrid, Program};
use argil_math::Aabb;
use glam::{IVec3, Vec3};
use rustc_hash::FxHashSet;
use std::any::Any;
use web_time::{Duration, Instant};

/// The layout of levels, and the boxes in which edits changed what each level stores.
#[derive(Debug)]
pub struct LevelsPendingEdits {
    pub(super) layout: LevelsLayout,
    boxes: Vec<Vec<Aabb>>,
    /// Whether the world has grown so much that it needs coarser levels.
    is_outgrown: bool,
    /// Whether all edits come from the program's last update, which knows what it touched.
    has_known_changes: bool,
    /// The pages that are baked already, of the level that ran out of time.
    baked: FxHashSet<(u32, IVec3)>,
    /// How long a thread took for a page lately, if it is known.
    page_time: Option<Duration>,
}

/// Maximum pages that a thread bakes between two looks at the clock.
const PAGES_AT_ONCE: usize = 4;

/// Maximum pages along a side of the coarsest level. A world that grows beyond it is built again, with more levels.
const MAX_ROOT_PAGES: i32 = 16;

impl LevelsPendingEdits {
    pub(super) fn of(layout: LevelsLayout) -> Self {
        Self {
            layout,
            boxes: vec![Vec::new(); layout.count() as usize],
            is_outgrown: false,
            has_known_changes: false,
            baked: FxHashSet::default(),
            page_time: None,
        }
    }

    /// Returns the edits of levels, if these are.
    pub fn downcast_ref(edits: &dyn PendingEdits) -> Option<&Self> {
        (edits as &dyn Any).downcast_ref()
    }

    /// Returns the edits of levels, to change them.
    pub fn downcast_mut(edits: &mut dyn PendingEdits) -> Option<&mut Self> {
        (edits as &mut dyn Any).downcast_mut()
    }

    /// Whether all edits come from the program's last update, and it knows what it touched.
    pub(super) fn has_known_changes(&self) -> bool {
        self.has_known_changes
    }

    pub(super) fn is_done(&self) -> bool {
        self.boxes.iter().all(Vec::is_empty)
    }

    /// Returns the boxes of a level.
    pub(super) fn boxes(&self, level: u32) -> &[Aabb] {
        &self.boxes[level as usize]
    }

    /// Notes that a level is done.
    pub(super) fn finish(&mut self, level: u32) {
        self.boxes[level as usize].clear();
        self.baked.retain(|(other, _)| *other != level);
    }

    /// Whether a page was baked before time ran out.
    pub(super) fn has_baked(&self, page: &Page) -> bool {
        self.baked.contains(&(page.level, page.place()))
    }

    /// Returns how many pages to bake before the next look at the clock: 0 if one would take longer than there is time.
    pub(super) fn pages_within(&self, until: Option<Instant>) -> usize {
        let Some(until) = until else {
            return usize::MAX;
        };
        let left = until.saturating_duration_since(Instant::now());
        let of_each = match self.page_time {
            Some(time) => (left.as_nanos() / time.as_nanos().max(1)) as usize,
            None => usize::from(!left.is_zero()),
        };
        of_each.min(PAGES_AT_ONCE) * rayon::current_num_threads()
    }

    /// Notes how long it took to bake pages.
    pub(super) fn note_duration(&mut self, duration: Duration, pages: usize) {
        let rounds = pages.div_ceil(rayon::current_num_threads()).max(1);
        let before = self.page_time.unwrap_or_default() / 2;
        self.page_time = Some((duration / rounds as u32).max(before));
    }

    /// Notes pages that are baked. From now on, boxes tell what remains.
    pub(super) fn note_baked(&mut self, pages: impl Iterator<Item = Page>) {
        self.baked
            .extend(pages.map(|page| (page.level, page.place())));
        self.has_known_changes = false;
    }
}

impl PendingEdits for LevelsPendingEdits {
    fn voxel_grid(&self) -> &VoxelGrid {
        self.layout.finest_grid()
    }

    fn margins(&self, program: &Program) -> [f32; 2] {
        self.layout.level(0).margins(program)
    }

    fn min_margins(&self, program: &Program) -> [f32; 2] {
        self.layout.level(0).min_margins(program)
    }

    fn parts(&self, program: &Program) -> PartGrid {
        self.layout.level(0).parts(program)
    }

    fn grow_to(&mut self, solid: Aabb) -> Result<bool, TooFarError> {
        let grid = self.layout.finest_grid();
        let edge = 1 << (super::page::PAGE_VOXELS_LOG2 + self.layout.root());
        let grown = grid.grown_to(solid, edge)?;
        let is_larger = grown != *grid;
        let layout = self.layout.with_grid(grown);
        let [low, high] = layout.root_pages();
        self.is_outgrown = (high - low).max_element() > MAX_ROOT_PAGES;
        if self.is_outgrown {
            return Ok(false);
        }
        self.layout = layout;
        Ok(is_larger)
    }

    fn merge(&mut self, live: &IncrementalProgram, _: &[[Aabb; 2]]) -> bool {
        if self.is_outgrown {
            return false;
        }
        self.has_known_changes = self.is_done() && live.jumps_added().is_empty();
        let boxes_before: Vec<usize> = self.boxes.iter().map(Vec::len).collect();
        for level in 0..self.layout.count() {
            let layout = self.layout.level(level);
            let [_, far] = layout.margins(live.program());
            let jumps = far + layout.cell_length();
            let own = &mut self.boxes[level as usize];
            match live.changed_boxes(far) {
                Some(boxes) => own.extend(boxes),
                // It is not known what changed.
                None => own.push(Aabb::ALL),
            }
            own.extend(live.jumps_added().iter().map(|one| one.grown(jumps)));
        }
        let (boxes, layout) = (&self.boxes, &self.layout);
        self.baked.retain(|&(level, place)| {
            let held = layout.edited_box(&Page::new(level, place, NO_PAGE));
            let new = &boxes[level as usize][boxes_before[level as usize]..];
            new.iter().all(|one| one.intersection(held).is_empty())
        });
        true
    }

    fn sort_by_distance(&mut self, _: Vec3) {}

    fn remaining_blocks(&self) -> u64 {
        self.boxes.iter().map(|boxes| boxes.len() as u64).sum()
    }

    fn clear(&mut self) {
        self.boxes.iter_mut().for_each(Vec::clear);
        self.baked.clear();
    }
}
