//! The tree of pages.

use super::layout::LevelsLayout;
use super::page::{NO_PAGE, Page, octant_cells, octant_place};
use super::requests::{PageRequest, Requests};
use crate::Texels;
use crate::bricks::{BrickStore, places};
use crate::{BrickCell, SampleFormat};
use argil_abi::Instruction;
use argil_field::CELLS_PER_BATCH;
use glam::{IVec3, Vec3};
use std::sync::atomic::{AtomicU32, Ordering};

/// Bytes of a page without its bricks: its node, words, masks, and the frame that used it last.
pub(super) const PAGE_BYTES: u64 = 64 + 4 * CELLS_PER_BATCH as u64 + 16 + 4;

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
/// let before = levels.distance([0.5, 0.0, 0.0].into());
/// levels.request_all(0, [0.5, 0.0, 0.0].into());
/// levels.fill(&program, None);
/// let after = levels.distance([0.5, 0.0, 0.0].into());
/// assert!(after.abs() <= before.abs());
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
    /// The first block of the coarsest level, the number of blocks, and the page of each.
    pub(super) root_low: IVec3,
    pub(super) root_size: IVec3,
    pub(super) roots: Vec<u32>,
    pub(super) pages: Vec<Page>,
    pub(super) masks: Vec<u64>,
    /// For each slot, a bit for each cell that finer samples would tell more about.
    pub(super) open: Vec<u64>,
    pub(super) free: Vec<u32>,
    pub(super) store: BrickStore,
    /// Programs of pages that have been refined, until the next edit.
    pub(super) lists: Vec<Option<Box<[Instruction]>>>,
    /// The last frame that used each page.
    pub(super) used: Vec<AtomicU32>,
    /// The current frame. The first is 1.
    pub(super) frame: AtomicU32,
    /// Pages that this frame or a later one used are not evicted.
    pub(super) kept_since: u32,
    pub(super) requests: Requests,
}

impl Clone for Levels {
    fn clone(&self) -> Self {
        let value = |one: &AtomicU32| AtomicU32::new(one.load(Ordering::Relaxed));
        Self {
            roots: self.roots.clone(),
            pages: self.pages.clone(),
            masks: self.masks.clone(),
            open: self.open.clone(),
            free: self.free.clone(),
            store: self.store.clone(),
            lists: self.lists.clone(),
            used: self.used.iter().map(value).collect(),
            frame: value(&self.frame),
            requests: Requests::default(),
            ..*self
        }
    }
}

impl PartialEq for Levels {
    fn eq(&self, other: &Self) -> bool {
        self.layout == other.layout
            && (&self.roots, &self.pages, &self.masks) == (&other.roots, &other.pages, &other.masks)
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
        let [low, high] = layout.root_blocks();
        let size = high - low;
        Self {
            layout,
            lipschitz,
            budget,
            pixel_error: 1.0,
            root_low: low,
            root_size: size,
            roots: vec![NO_PAGE; size.element_product() as usize],
            pages: Vec::new(),
            masks: Vec::new(),
            open: Vec::new(),
            free: Vec::new(),
            store: BrickStore::of(pool),
            lists: Vec::new(),
            used: Vec::new(),
            frame: AtomicU32::new(0),
            kept_since: 1,
            requests: Requests::default(),
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

    /// Sets the size of a voxel that a ray accepts, in pixels.
    pub fn set_pixel_error(&mut self, pixels: f32) {
        self.pixel_error = pixels.clamp(0.125, 1024.0);
    }

    /// Returns all pages, including free ones. Their indices are slots, with 64 [words](Levels::words) each.
    pub fn pages(&self) -> &[Page] {
        &self.pages
    }

    /// Returns the mask of each slot: a bit for each cell with a brick.
    pub fn masks(&self) -> &[u64] {
        &self.masks
    }

    /// Returns the words of all slots.
    pub fn words(&self) -> &[u32] {
        &self.store.words
    }

    /// Returns the samples, brick by brick.
    pub fn pool(&self) -> &Texels {
        &self.store.pool
    }

    /// Returns the first block of the coarsest level, the number of blocks along each axis, and the page of each, x
    /// fastest.
    pub fn roots(&self) -> (IVec3, IVec3, &[u32]) {
        (self.root_low, self.root_size, &self.roots)
    }

    /// Returns the number of bricks.
    pub fn brick_count(&self) -> u64 {
        self.store.cell_of_brick.len() as u64
    }

    /// Returns the number of resident pages of each level, finest first.
    pub fn resident_pages(&self) -> Vec<u64> {
        let mut counts = vec![0; self.layout.len() as usize];
        for (slot, page) in self.pages.iter().enumerate() {
            if self.is_resident(slot as u32) {
                counts[page.level as usize] += 1;
            }
        }
        counts
    }

    /// Whether a slot holds a page.
    pub fn is_resident(&self, slot: u32) -> bool {
        let page = &self.pages[slot as usize];
        match page.parent {
            NO_PAGE => self.root_slot(page.block()) == Some(slot),
            parent => self.pages[parent as usize].children.contains(&slot),
        }
    }

    /// Returns the bytes of everything.
    pub fn memory_bytes(&self) -> u64 {
        let words = size_of_val(&self.store.words[..]) as u64;
        let lists: usize = self
            .lists
            .iter()
            .flatten()
            .map(|l| size_of_val(&l[..]))
            .sum();
        PAGE_BYTES * self.pages.len() as u64 + self.store.memory_bytes() - words + lists as u64
    }

    /// Returns the page of a block of the coarsest level.
    pub(super) fn root_slot(&self, block: IVec3) -> Option<u32> {
        let at = block - self.root_low;
        let is_held = at.cmpge(IVec3::ZERO).all() && at.cmplt(self.root_size).all();
        let place = at.x + self.root_size.x * (at.y + self.root_size.y * at.z);
        is_held
            .then(|| self.roots[place as usize])
            .filter(|&slot| slot != NO_PAGE)
    }

    /// Returns the finest resident page of a level or a coarser one that contains a block of that level.
    pub fn find(&self, level: u32, block: IVec3) -> Option<u32> {
        let root = self.layout.root();
        let mut slot = self.root_slot(block >> root.checked_sub(level)?)?;
        loop {
            let page = &self.pages[slot as usize];
            if page.level <= level {
                return Some(slot);
            }
            let inner = (block >> (page.level - 1 - level)) & 1;
            let octant = inner.x + 2 * inner.y + 4 * inner.z;
            match page.children[octant as usize] {
                NO_PAGE => return Some(slot),
                child => slot = child,
            }
        }
    }

    /// Returns the octants of a page that can have finer pages: finer samples would tell more about a cell.
    pub(super) fn open_octants(&self, slot: u32) -> u8 {
        let mask = self.open[slot as usize];
        (0..8).fold(0, |all, octant| {
            all | u8::from(mask & octant_cells(octant) != 0) << octant
        })
    }

    /// Returns the block of a page's octant.
    pub(super) fn child_block(&self, slot: u32, octant: u32) -> IVec3 {
        2 * self.pages[slot as usize].block() + octant_place(octant)
    }

    /// Returns the number of pages that frames asked for since the last [`Levels::fill`].
    pub fn request_count(&self) -> usize {
        self.requests.len()
    }

    /// Begins a frame: pages that it uses are not evicted before the next [`Levels::fill`].
    pub fn begin_frame(&self) {
        self.frame.fetch_add(1, Ordering::Relaxed);
    }

    /// Notes the pages that a part of a frame used, and what it asked for. Pages above them are used as well.
    pub fn note(&self, used: &[u32], asked: &[PageRequest]) {
        let frame = self.frame.load(Ordering::Relaxed);
        for &slot in used {
            let mut at = slot;
            while at != NO_PAGE {
                let stamp = &self.used[at as usize];
                if stamp.load(Ordering::Relaxed) == frame {
                    break;
                }
                stamp.store(frame, Ordering::Relaxed);
                at = self.pages[at as usize].parent;
            }
        }
        self.requests.add(asked);
    }

    /// Requests the page of a level that contains a point, and those above it that are missing. Returns whether
    /// one is missing.
    pub fn request_all(&self, level: u32, point: Vec3) -> bool {
        let Some(slot) = self.find(level, self.block_of(level, point)) else {
            return false;
        };
        let page = self.pages[slot as usize];
        if page.level <= level {
            return false;
        }
        let inner = self.block_of(page.level - 1, point) & 1;
        let octant = (inner.x + 2 * inner.y + 4 * inner.z) as u32;
        let is_missing = self.open_octants(slot) >> octant & 1 != 0;
        if is_missing {
            let gap = (page.level - level) as f32;
            self.note(&[slot], &[PageRequest::new(slot, octant, gap, 0.0)]);
        }
        is_missing
    }

    /// Returns the block of a level that contains a point.
    pub fn block_of(&self, level: u32, point: Vec3) -> IVec3 {
        self.layout.level(level).cell_of(point) >> 2
    }

    /// Returns the stored distance at a point: interpolated in a brick of the finest resident page, and a lower bound
    /// with the right sign elsewhere.
    pub fn distance(&self, point: Vec3) -> f32 {
        self.lookup(point).0
    }

    /// Returns the distance at a point, and whether it comes from a brick.
    pub(super) fn lookup(&self, point: Vec3) -> (f32, bool) {
        let layout = self.layout.level(0);
        let end = layout.voxel_grid.aabb();
        let held = point.clamp(end.min, end.max);
        let Some(slot) = self.find(0, self.block_of(0, held)) else {
            return (argil_field::FAR, false);
        };
        let page = &self.pages[slot as usize];
        let layout = self.layout.level(page.level);
        let first = page.block() * 4;
        let cell = layout.cell_of(held).clamp(first, first + 3);
        let inner = cell - first;
        let word = self.store.words
            [slot as usize * CELLS_PER_BATCH + (inner.x + 4 * inner.y + 16 * inner.z) as usize];
        let voxel = layout.voxel_grid.voxel_size;
        let u = (held - layout.cell_box(cell).min) / voxel;
        match BrickCell::of(word) {
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

    /// Iterates over the slots of all resident pages.
    pub fn resident(&self) -> impl Iterator<Item = u32> + '_ {
        let mut open: Vec<u32> = self
            .roots
            .iter()
            .copied()
            .filter(|&s| s != NO_PAGE)
            .collect();
        std::iter::from_fn(move || {
            let slot = open.pop()?;
            let children = self.pages[slot as usize].children;
            open.extend(children.into_iter().filter(|&child| child != NO_PAGE));
            Some(slot)
        })
    }

    /// Iterates over the blocks of the coarsest level.
    pub(super) fn root_places(&self) -> impl Iterator<Item = IVec3> + use<> {
        places(self.root_low, self.root_low + self.root_size - 1)
    }
}
