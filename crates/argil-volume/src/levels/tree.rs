//! The tree of pages.

use super::kept_list::{KeptBySlot, PageCells};
use super::layout::LevelsLayout;

use super::page::{NO_PAGE, Page, is_page, octant_of, octant_place};
use super::requests::{PageRequest, Requests};
use super::source::StoredTiles;
use crate::MISSING_BRICK;
use crate::Texels;
use crate::bricks::{BrickStore, places};
use crate::{BrickCell, SampleFormat, is_brick};
use argil_abi::Instruction;
use glam::{IVec3, Vec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Bytes of a page without its bricks: its node, what is kept of its programs, and for each cell its word, its child,
/// and its last use.
pub(super) const PAGE_BYTES: u64 = 32
    + 8 * 12
    + KeptBySlot::<Arc<[Instruction]>>::SLOT_BYTES
    + KeptBySlot::<Arc<PageCells>>::SLOT_BYTES;

/// Bricks at many levels of detail, within a budget of memory.
///
/// ```
/// use argil_field::Program;
/// use argil_scene::{Scene, Shape};
/// use argil_volume::{BrickSettings, Levels, LevelsLayout, VoxelGrid};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(0.5))?;
/// let program = Program::lower(&scene)?;
/// let grid = VoxelGrid::fitting(program.aabb(), None, 1024)?;
/// let layout = LevelsLayout::new(grid, &BrickSettings::default())?;
/// let mut levels = Levels::bake(&program, layout, 64 << 20)?;
/// let point = [0.5, 0.01, 0.0].into();
/// let before = levels.distance(point);
/// while levels.request(0, point) {
///     levels.fill(&program, None);
/// }
/// let after = levels.distance(point);
/// assert!((after - program.distance(point)).abs() < 0.1 * (before - program.distance(point)).abs());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[doc(alias = "level of detail")]
#[doc(alias = "virtual texture")]
pub struct Levels {
    pub(super) layout: LevelsLayout,
    pub(super) lipschitz: f32,
    /// Maximum bytes.
    pub(super) budget: u64,
    /// The size of a voxel that a ray accepts, in pixels.
    pub(super) pixel_error: f32,
    /// The factor by which voxels may be larger than that, because memory is full.
    pub(super) coarsening: f32,
    /// The first page of the coarsest level, the number of pages, and the slot of each.
    pub(super) root_low: IVec3,
    pub(super) root_size: IVec3,
    pub(super) roots: Vec<u32>,
    pub(super) pages: Vec<Page>,
    /// For each cell, its page, or why it has none.
    pub(super) children: Vec<u32>,
    pub(super) free: Vec<u32>,
    pub(super) store: BrickStore,
    /// The program's revision that the following come from, or 0 before the first edit.
    pub(super) revision: u64,
    /// Programs of pages that have been refined, until the next edit.
    pub(super) lists: KeptBySlot<Arc<[Instruction]>>,
    /// What is known of the programs of their cells, until the next edit.
    pub(super) marks: KeptBySlot<Arc<PageCells>>,
    /// How often programs were looked up: they are kept by their last use.
    pub(super) list_clock: u32,
    /// The bytes of the scene's program.
    pub(super) program_bytes: u64,
    /// The mean bytes of the programs of pages that were baked last.
    pub(super) mean_list_bytes: u64,
    /// The last frame that used each cell.
    pub(super) used: Vec<AtomicU32>,
    /// The current frame. The first is 1.
    pub(super) frame: AtomicU32,
    /// What this frame or a later one used is not evicted.
    pub(super) kept_since: u32,
    pub(super) requests: Requests,
    /// Where pages come from that were baked before.
    pub(super) stored: Option<Box<StoredTiles>>,
    /// Hits of the current frame, and how many of them were too coarse.
    pub(super) hits: [AtomicU64; 2],
}

impl Clone for Levels {
    fn clone(&self) -> Self {
        let value = |one: &AtomicU32| AtomicU32::new(one.load(Ordering::Relaxed));
        Self {
            roots: self.roots.clone(),
            pages: self.pages.clone(),
            children: self.children.clone(),
            free: self.free.clone(),
            store: self.store.clone(),
            lists: self.lists.clone(),
            marks: self.marks.clone(),
            used: self.used.iter().map(value).collect(),
            frame: value(&self.frame),
            requests: Requests::default(),
            stored: self.stored.clone(),
            hits: Default::default(),
            ..*self
        }
    }
}

impl PartialEq for Levels {
    fn eq(&self, other: &Self) -> bool {
        self.layout == other.layout
            && (&self.roots, &self.pages, &self.children)
                == (&other.roots, &other.pages, &other.children)
            && self.store == other.store
    }
}

impl Levels {
    /// Creates levels without any page.
    pub(super) fn empty(layout: LevelsLayout, lipschitz: f32, budget: u64) -> Self {
        let pool = match layout.level(0).encoding.format {
            SampleFormat::Snorm8 => Texels::from_vec(vec![0i8; 729]),
            SampleFormat::Snorm16 => Texels::from_vec(vec![0i16; 729]),
        };
        let [low, high] = layout.root_pages();
        let size = high - low;
        Self {
            layout,
            lipschitz,
            budget,
            pixel_error: 1.0,
            coarsening: 1.0,
            root_low: low,
            root_size: size,
            roots: vec![NO_PAGE; size.element_product() as usize],
            pages: Vec::new(),
            children: Vec::new(),
            free: Vec::new(),
            store: BrickStore::of(pool),
            revision: 0,
            lists: KeptBySlot::default(),
            marks: KeptBySlot::default(),
            list_clock: 0,
            program_bytes: 0,
            mean_list_bytes: 0,
            used: Vec::new(),
            frame: AtomicU32::new(0),
            kept_since: 1,
            requests: Requests::default(),
            stored: None,
            hits: Default::default(),
        }
    }

    /// Returns the layout of all levels.
    pub fn layout(&self) -> &LevelsLayout {
        &self.layout
    }

    /// Returns the Lipschitz constant of the distances.
    pub fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Returns the maximum bytes.
    pub fn budget(&self) -> u64 {
        self.budget
    }

    /// Returns the size of a voxel that a ray accepts, in pixels.
    pub fn pixel_error(&self) -> f32 {
        self.pixel_error
    }

    /// Returns the size of a voxel that a ray accepts at present, in pixels. It is larger than [`Levels::pixel_error`]
    /// while memory is full, so that all of an image is equally sharp.
    pub fn effective_pixel_error(&self) -> f32 {
        self.pixel_error * self.coarsening
    }

    /// Sets the size of a voxel that a ray accepts, in pixels.
    pub fn set_pixel_error(&mut self, pixels: f32) {
        self.pixel_error = pixels.clamp(0.125, 1024.0);
    }

    /// Returns all pages, including free ones, by slot.
    pub fn pages(&self) -> &[Page] {
        &self.pages
    }

    /// Returns for each cell the slot of its page, or [`NO_PAGE`], [`FLAT_CELL`](super::FLAT_CELL)
    /// or [`UNKNOWN_CELL`](super::UNKNOWN_CELL).
    pub fn children(&self) -> &[u32] {
        &self.children
    }

    /// Returns the word of each cell: as in sparse bricks, or [`MISSING_BRICK`].
    pub fn words(&self) -> &[u32] {
        &self.store.words
    }

    /// Returns the samples, brick by brick.
    pub fn pool(&self) -> &Texels {
        &self.store.pool
    }

    /// Returns the first page of the coarsest level, the number of pages along each axis, and the slot of each, x
    /// fastest.
    pub fn roots(&self) -> (IVec3, IVec3, &[u32]) {
        (self.root_low, self.root_size, &self.roots)
    }

    /// Returns the number of bricks.
    pub fn brick_count(&self) -> u64 {
        self.store.cell_of_brick.len() as u64
    }

    /// Returns the number of bricks of each level, finest first.
    pub fn resident_bricks(&self) -> Vec<u64> {
        let mut counts = vec![0; self.layout.count() as usize];
        for &cell in &self.store.cell_of_brick {
            counts[self.pages[cell as usize / 8].level as usize] += 1;
        }
        counts
    }

    /// Returns the number of pages.
    pub fn page_count(&self) -> u64 {
        (self.pages.len() - self.free.len()) as u64
    }

    /// Whether a slot holds a page.
    pub(super) fn is_resident(&self, slot: u32) -> bool {
        let Some(page) = self.pages.get(slot as usize) else {
            return false;
        };
        match page.parent {
            NO_PAGE => self.root_slot(page.place()) == Some(slot),
            parent => self.children[parent as usize] == slot,
        }
    }

    /// Returns the bytes of everything.
    pub fn memory_bytes(&self) -> u64 {
        let words = size_of_val(&self.store.words[..]) as u64;
        PAGE_BYTES * self.pages.len() as u64 + self.store.memory_bytes() - words + self.list_bytes()
    }

    /// Returns the page of the coarsest level at a place.
    pub(super) fn root_slot(&self, place: IVec3) -> Option<u32> {
        let at = place - self.root_low;
        let is_held = at.cmpge(IVec3::ZERO).all() && at.cmplt(self.root_size).all();
        let index = at.x + self.root_size.x * (at.y + self.root_size.y * at.z);
        is_held
            .then(|| self.roots[index as usize])
            .filter(|&slot| slot != NO_PAGE)
    }

    /// Returns the finest known cell at a cell of a level: the cell itself, or a coarser one without a
    /// surface, that is flat, or that has no page.
    #[inline]
    pub(super) fn find(&self, level: u32, cell: IVec3) -> Option<u32> {
        let root = self.layout.root();
        let up = root.checked_sub(level)?;
        let mut slot = self.root_slot(cell >> (up + 1))?;
        let mut above = up;
        loop {
            let own = 8 * slot + octant_of((cell >> above) & 1);
            if above == 0 || !is_page(self.children[own as usize]) {
                return Some(own);
            }
            slot = self.children[own as usize];
            above -= 1;
        }
    }

    /// Returns the level of a cell.
    pub(super) fn level_of(&self, cell: u32) -> u32 {
        self.pages[cell as usize / 8].level
    }

    /// Returns the request that brings a cell of a level closer, given what [`Levels::find`] returned for it.
    #[inline]
    pub(super) fn request_for(
        &self,
        (level, place): (u32, IVec3),
        found: u32,
        distance: f32,
    ) -> Option<PageRequest> {
        let word = self.store.words[found as usize];
        let own = self.level_of(found);
        let gap = (own - level) as f32 + 1.0;
        if word == MISSING_BRICK {
            return Some(PageRequest::of_cell(found, gap, distance));
        }
        let is_open = is_brick(word) && self.children[found as usize] == NO_PAGE;
        if own == level || !is_open {
            return None;
        }
        let inner = octant_of((place >> (own - 1 - level)) & 1);
        Some(PageRequest::of_child(found, inner, gap, distance))
    }

    /// Begins a frame: what it uses is not evicted before the next [`Levels::fill`].
    pub fn begin_frame(&self) {
        self.frame.fetch_add(1, Ordering::Relaxed);
        for hits in &self.hits {
            hits.store(0, Ordering::Relaxed);
        }
    }

    /// Counts hits of a part of a frame, and how many of them were in a brick coarser than twice what the ray accepts,
    /// because a finer one was missing.
    pub fn count_hits(&self, hits: u64, coarse: u64) {
        self.hits[0].fetch_add(hits, Ordering::Relaxed);
        self.hits[1].fetch_add(coarse, Ordering::Relaxed);
    }

    /// Returns the share of the current frame's hits in bricks coarser than twice what the ray accepts, because finer
    /// ones were missing.
    pub fn coarse_share(&self) -> f64 {
        let [hits, coarse] = [0, 1].map(|i: usize| self.hits[i].load(Ordering::Relaxed) as f64);
        coarse / hits.max(1.0)
    }

    /// Returns the number of bricks that frames asked for since the last [`Levels::fill`].
    pub fn request_count(&self) -> usize {
        self.requests.len()
    }

    /// Notes the cells that a part of a frame used, and what it asked for.
    pub fn note(&self, used: &[u32], asked: &[PageRequest]) {
        let frame = self.frame.load(Ordering::Relaxed);
        // What is asked for must still have its page when it is baked.
        let asking = asked.iter().map(|request| request.place().0);
        for cell in used.iter().copied().chain(asking) {
            self.mark_used(cell, frame);
        }
        self.requests.add(asked);
    }

    /// Marks a cell as used by a frame. Most calls mark again what is marked already: they leave its cache line alone.
    #[inline(always)]
    pub(super) fn mark_used(&self, cell: u32, frame: u32) {
        let used = &self.used[cell as usize];
        if used.load(Ordering::Relaxed) != frame {
            used.store(frame, Ordering::Relaxed);
        }
    }

    /// Requests the next brick on the way to a level's brick at a point. Returns whether one is missing.
    pub fn request(&self, level: u32, point: Vec3) -> bool {
        let place = self.layout.level(level).cell_of(point);
        let Some(found) = self.find(level, place) else {
            return false;
        };
        let asked = self.request_for((level, place), found, 0.0);
        self.note(&[found], asked.as_slice());
        asked.is_some()
    }

    /// Returns the nearest cell with a resident brick among a cell and those that contain it. Those of the coarsest
    /// level are always resident.
    #[inline(always)]
    pub(super) fn resident_above(&self, mut cell: u32) -> u32 {
        while self.store.words[cell as usize] == MISSING_BRICK {
            let parent = self.pages[cell as usize / 8].parent;
            if parent == NO_PAGE {
                break;
            }
            cell = parent;
        }
        cell
    }

    /// Returns the stored distance at a point: interpolated in the finest resident brick, and a lower bound with the
    /// right sign elsewhere.
    pub fn distance(&self, point: Vec3) -> f32 {
        self.lookup(point).0
    }

    /// Returns the distance at a point, and whether it comes from a brick.
    pub(super) fn lookup(&self, point: Vec3) -> (f32, bool) {
        let finest = self.layout.level(0);
        let end = finest.voxel_grid.aabb();
        let held = point.clamp(end.min, end.max);
        let inside = finest
            .cell_of(held)
            .clamp(finest.first_cell(), finest.end_cell() - 1);
        let Some(found) = self.find(0, inside) else {
            return (argil_field::FAR, false);
        };
        let found = self.resident_above(found);
        let page = &self.pages[found as usize / 8];
        let layout = self.layout.level(page.level);
        let cell = 2 * page.place() + octant_place(found % 8);
        let voxel = layout.voxel_grid.voxel_size;
        let u = (held - layout.cell_box(cell).min) / voxel;
        match BrickCell::of(self.store.words[found as usize]) {
            BrickCell::Brick(brick) => {
                let quantum = layout.encoding.band_width(&layout.voxel_grid, 0)
                    / layout.encoding.format.max_code() as f32;
                (self.store.interpolated(brick, u) * quantum, true)
            }
            BrickCell::Empty { center, .. } => {
                let way = self.lipschitz * voxel * (u - 4.0).length();
                let left = (center.abs() - way).max(1e-30);
                (left.copysign(center), false)
            }
        }
    }

    /// Iterates over the slots of all pages, coarser ones first.
    pub(super) fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        let roots = self.roots.iter().copied().filter(|&s| s != NO_PAGE);
        let mut open: std::collections::VecDeque<u32> = roots.collect();
        std::iter::from_fn(move || {
            let slot = open.pop_front()?;
            let cells = 8 * slot as usize..8 * slot as usize + 8;
            let children = self.children[cells].iter().copied();
            open.extend(children.filter(|&child| is_page(child)));
            Some(slot)
        })
    }

    /// Iterates over the places of the coarsest level's pages.
    pub(super) fn root_places(&self) -> impl Iterator<Item = IVec3> + use<> {
        places(self.root_low, self.root_low + self.root_size - 1)
    }
}
