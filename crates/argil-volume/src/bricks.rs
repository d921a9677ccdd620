//! Sparse bricks: the product's own representation.
//!
//! *Theory.* Only cells near the surface need samples; what a ray wants to know elsewhere is how far it can go. So a grid
//! of cells holds, where there is no brick, how far the surface is from the cell's centre at least (what Barbier et al.,
//! "Lipschitz pruning", 2025, keep for far cells): less half of the cell's diagonal, no point of the cell falls short
//! of it. Bricks are as small as caches like them (8³ cells, after Lumen and GigaVoxels, Crassin 2009).
//!
//! ```text
//!   table   which blocks of 4³ cells there are: each has a slot; what has none is far from every surface
//!   masks   one for each slot: a bit for each cell with a brick
//!   words   one for each cell, slot by slot: a brick's place, or a distance and whether the whole block is empty
//!   materials, mixed   what bricks look like, see `material.rs`
//!   pool    (brick + 1)³ samples a brick, x fastest: its cells' corners, so that interpolation never leaves it
//! ```
//!
//! *For readers in shaders of their own.* The word of a cell with a brick is the brick's number. Any other word is a signed distance
//! (see [`center_of`]): no surface is nearer to the cell's centre than that. It says nothing of how far away one is: beside the
//! surface it can be near 0, and it is never more than [`BrickLayout::far_length`]. A point of the cell that is `r` from its
//! centre is free for `|d| − L · r`, where L is [`Bricks::lipschitz`]. Samples of a brick are distances over its band, and
//! within it those of the field; at the band's end they are cut off. After edits, [`Bricks::take_changes`] tells what to bring over.
//!
//! Blocks are counted from the lattice's corner in all directions: where there is surface there are blocks, and a world that
//! grows keeps what it has.
//!
//! *Practice.* Samples stand at voxels' corners, `corner + voxel · (i, j, k)`; neighbouring bricks have those of their
//! common side both. `build.rs` bakes on the CPU, `batch.rs` reads for rays. What differs from the literature: a brick is
//! dropped again where its own samples show that the surface cannot be in it. The tables hold the very resolution that was asked for.

mod batch;
mod block_list;
mod bounds;
mod brick;
mod build;
mod candidates;
mod cell_lists;
mod changes;
mod edit;
mod edits;
mod filler;
mod kept;
mod layout;
mod material;
mod octants;
mod plan;
mod pool;
mod reached;
mod table;
mod words;
mod work;

use crate::Texels;
use argil_abi::BRICK_MIXED;
use argil_field::{CELLS, Program};
use argil_math::Control;
use glam::{IVec3, Vec3};
use std::ops::Range;

pub use batch::{Beyond, BrickSampler, Corners, Located};
pub use block_list::{BlockList, emptied_around};
pub use bounds::BLOCK_WORDS;
pub use brick::Brick;
pub use build::BrickStagesMs;
pub use cell_lists::CellLists;
pub use changes::BrickChanges;
pub use edit::BrickEdit;
pub use edits::BrickEdits;
pub use layout::{BLOCK_SIDE, BrickLayout, BrickSettings, BricksError};
pub use plan::BlockPlan;
pub use table::{BlockTable, FAR_ENTRY, FAR_SLOTS, far_words};
pub use words::{Word, center_of, empty_word, is_brick, is_lonely};
pub use work::{EditWork, Unit};

/// A sparse volume of bricks.
#[derive(Clone, PartialEq)]
pub struct Bricks {
    layout: BrickLayout,
    /// By how much distances can change over a length of 1.
    lipschitz: f32,
    /// Which blocks there are.
    table: BlockTable,
    /// A bit for each cell of a slot's block that has a brick.
    masks: Vec<u64>,
    /// What is in each cell, slot by slot.
    words: Vec<u32>,
    /// Whose brick it is: the place of its cell's word.
    owners: Vec<u32>,
    /// What each brick looks like.
    materials: Vec<u32>,
    /// The materials of mixed bricks.
    mixed: Vec<[u32; 2]>,
    /// Which brick each of those is of.
    mixed_owners: Vec<u32>,
    pool: Texels,
    changes: changes::Noted,
}

impl Bricks {
    /// What edits have changed since this was last called, or since the bake: what a copy elsewhere, as on a renderer's own GPU, has
    /// to bring over. Its brick `n` is at `n · (brick + 1)³` samples of [`Bricks::pool`], its slot `n` at `64 n` of
    /// [`Bricks::words`].
    pub fn take_changes(&mut self) -> BrickChanges {
        self.changes.take(self.owners.len() as u32)
    }

    /// Sample a field, on rayon's current threads; what the stages took.
    ///
    /// # Errors
    /// If the bricks and tables would take more than `budget` bytes.
    pub fn bake(
        program: &Program,
        layout: BrickLayout,
        budget: Option<u64>,
    ) -> Result<(Self, BrickStagesMs), BricksError> {
        Self::bake_controlled(program, layout, budget, &Control::default())
    }

    /// [`Bricks::bake`], which can be stopped and tells how far it is: the stages "blocks" and "bricks".
    ///
    /// # Errors
    /// As there, and if it was cancelled.
    pub fn bake_controlled(
        program: &Program,
        layout: BrickLayout,
        budget: Option<u64>,
        control: &Control,
    ) -> Result<(Self, BrickStagesMs), BricksError> {
        let baked = build::bake(program, layout, budget, control);
        baked.map(|(bricks, _, stages)| (bricks, stages))
    }

    /// The same, with the lists of what can matter in cells near the surface, which a bake makes anyway.
    ///
    /// # Errors
    /// As [`Bricks::bake`].
    pub fn bake_with_lists(
        program: &Program,
        layout: BrickLayout,
        budget: Option<u64>,
    ) -> Result<(Self, CellLists, BrickStagesMs), BricksError> {
        build::bake(program, layout, budget, &Control::default())
    }

    /// The same, which can be stopped and tells how far it is.
    ///
    /// # Errors
    /// As [`Bricks::bake_controlled`].
    pub fn bake_with_lists_controlled(
        program: &Program,
        layout: BrickLayout,
        budget: Option<u64>,
        control: &Control,
    ) -> Result<(Self, CellLists, BrickStagesMs), BricksError> {
        build::bake(program, layout, budget, control)
    }

    /// From stored parts, with 64 words for each slot of the table; what is wrong with them where they do not fit one another.
    pub fn from_parts(
        layout: BrickLayout,
        lipschitz: f32,
        (mut table, mut words): (BlockTable, Vec<u32>),
        (materials, mixed): (Vec<u32>, Vec<[u32; 2]>),
        pool: Texels,
    ) -> Result<Self, &'static str> {
        if !(1.0..=1e6).contains(&lipschitz) {
            return Err("its Lipschitz constant makes no sense");
        }
        let samples = layout.brick_samples() as usize;
        if pool.bits() != layout.encoding.bits {
            return Err("the samples have another width");
        }
        let length = pool.bytes().len() / pool.bits().bytes();
        if !length.is_multiple_of(samples) || length == 0 {
            return Err("half a brick is left");
        }
        if words.len() != table.slots() * CELLS {
            return Err("there are not as many cells as the blocks have");
        }
        let [low, high] = layout.block_range();
        table.cover(low, high);
        words[..FAR_SLOTS as usize * CELLS].copy_from_slice(&far_words(layout.far_length()));
        if layout.check_count((length / samples) as u64).is_err() {
            return Err("it has more bricks than can be");
        }
        let mut owners = vec![u32::MAX; length / samples];
        let mut masks = vec![0u64; words.len() / CELLS];
        let mut is_there = vec![false; table.slots()];
        for (slot, block) in table.blocks() {
            is_there[slot] = true;
            if layout.lattice.is_cut && (block.cmplt(low).any() || block.cmpge(high).any()) {
                return Err("a block is outside of the box");
            }
        }
        for (at, &word) in words.iter().enumerate() {
            if let Word::Brick(brick) = Word::of(word) {
                if !is_there[at / CELLS] {
                    return Err("a brick is in no block");
                }
                match owners.get_mut(brick as usize) {
                    Some(owner) if *owner == u32::MAX => *owner = at as u32,
                    Some(_) => return Err("a brick is in two cells"),
                    None => return Err("a cell's brick is not there"),
                }
                masks[at / 64] |= 1 << (at % 64);
            }
        }
        if owners.len() > 1 && owners.contains(&u32::MAX) {
            return Err("a brick is in no cell");
        }
        if owners == [u32::MAX] {
            owners.clear();
        }
        if materials.len() != owners.len() || !mixed.len().is_multiple_of(material::PLACES) {
            return Err("there are not as many materials as bricks");
        }
        let blocks = (mixed.len() / material::PLACES) as u32;
        let is_beyond = |&m: &u32| m & BRICK_MIXED != 0 && m & !BRICK_MIXED >= blocks;
        if materials.iter().any(is_beyond) {
            return Err("a mixed brick's materials are not there");
        }
        Ok(Self {
            mixed_owners: pool::owners_of_mixed(&materials, &mixed),
            changes: changes::Noted::default(),
            materials,
            mixed,
            layout,
            lipschitz,
            table,
            masks,
            words,
            owners,
            pool,
        })
    }

    /// Its measures.
    pub fn layout(&self) -> &BrickLayout {
        &self.layout
    }

    /// By how much distances can change over a length of 1.
    pub fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Which blocks there are, and their slots.
    pub fn table(&self) -> &BlockTable {
        &self.table
    }

    /// What is in each cell, slot by slot; the first slots are of no block and tell of what is far.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// A bit for each cell with a brick, a mask for each slot.
    pub fn masks(&self) -> &[u64] {
        &self.masks
    }

    pub(crate) fn set_cut(&mut self, is_cut: bool) {
        self.layout.lattice.is_cut = is_cut;
    }

    /// The same voxels over a larger box. Nothing is sampled.
    pub fn grow(&mut self, layout: BrickLayout) {
        let same = (self.layout.lattice.corner, self.layout.lattice.voxel)
            == (layout.lattice.corner, layout.lattice.voxel);
        if same && self.layout.brick == layout.brick {
            self.layout.lattice = layout.lattice;
            let [low, high] = layout.block_range();
            self.table.cover(low, high);
        }
    }

    /// Whose each brick is: the place of its cell's word.
    pub fn owners(&self) -> &[u32] {
        &self.owners
    }

    /// The bricks' samples, brick by brick. Where there is no brick at all, there is one of zeros.
    pub fn pool(&self) -> &Texels {
        &self.pool
    }

    /// All bricks, in the order of the pool.
    ///
    /// ```
    /// use argil_field::Program;
    /// use argil_scene::{Brush, Scene, Shape};
    /// use argil_volume::{BrickLayout, Bricks, Lattice};
    /// let mut scene = Scene::new();
    /// scene.push(Brush::new(Shape::sphere(1.0))).unwrap();
    /// let program = Program::lower(&scene)?;
    /// let layout = BrickLayout::new(Lattice::holding(program.aabb(), None, 64)?, &Default::default())?;
    /// let (bricks, _) = Bricks::bake(&program, layout, None)?;
    /// for brick in bricks.iter() {
    ///     let first = brick.distances().next().expect("samples");
    ///     let exact = program.distance(brick.place(0));
    ///     let band = layout.encoding.range_length(&layout.lattice, 0);
    ///     assert!((first - exact.clamp(-band, band)).abs() < 1e-4 * band);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Brick<'_>> + '_ {
        (0..self.owners.len()).map(|index| Brick {
            bricks: self,
            index: index as u32,
        })
    }

    /// Number of bricks.
    pub fn len(&self) -> usize {
        self.owners.len()
    }

    /// Whether there is no brick.
    pub fn is_empty(&self) -> bool {
        self.owners.is_empty()
    }

    /// In how many cells other bricks of the same voxels differ: whether there is a brick, its samples, what it looks like.
    /// Where bricks stand in the pool makes no difference, nor does the box. Of other voxels, all cells differ.
    pub fn differing_cells(&self, other: &Self) -> u64 {
        let measures = |own: &Self| {
            let lattice = own.layout.lattice;
            (
                lattice.corner,
                lattice.voxel,
                own.layout.brick,
                own.layout.encoding.bits,
            )
        };
        if measures(self) != measures(other) {
            return (self.len() + other.len()) as u64;
        }
        let bytes = self.layout.brick_bytes() as usize;
        let samples = |bricks: &Self, brick: u32| -> Range<usize> {
            let from = brick as usize * bytes;
            from..(from + bytes).min(bricks.pool.bytes().len())
        };
        let differ = |own: u32, theirs: u32| match (Word::of(own), Word::of(theirs)) {
            (Word::Brick(a), Word::Brick(b)) => {
                self.pool.bytes()[samples(self, a)] != other.pool.bytes()[samples(other, b)]
                    || self.look(a) != other.look(b)
            }
            (Word::Empty { .. }, Word::Empty { .. }) => false,
            _ => true,
        };
        let of_slot =
            |bricks: &Self, slot: usize| slot * CELLS..((slot + 1) * CELLS).min(bricks.words.len());
        let mut count = 0;
        for (slot, block) in self.table.blocks() {
            let theirs = other.table.slot(block) as usize;
            let own = &self.words[of_slot(self, slot)];
            let theirs = &other.words[of_slot(other, theirs)];
            let pairs = own.iter().zip(theirs);
            count += pairs
                .filter(|(own, theirs)| differ(**own, **theirs))
                .count() as u64;
        }
        for (slot, block) in other.table.blocks() {
            if self.table.find(block).is_none() {
                count += u64::from(other.masks[slot].count_ones());
            }
        }
        count
    }

    /// The words of all cells from one to before another, x fastest, as a shader of one's own reads them: see `docs/march-bricks.md` of
    /// the repository. What each means [`Word::of`] tells.
    ///
    /// ```
    /// # use argil_volume::{BrickLayout, BrickSettings, Bricks, Lattice, Word};
    /// # let mut scene = argil_scene::Scene::new();
    /// # scene.push(argil_scene::Brush::new(argil_scene::Shape::sphere(1.0)))?;
    /// # let program = argil_field::Program::lower(&scene)?;
    /// # let lattice = Lattice::holding(program.aabb(), None, 64)?;
    /// # let (bricks, _) = Bricks::bake(&program, BrickLayout::new(lattice, &BrickSettings::default())?, None)?;
    /// let [low, high] = [bricks.layout().low(), bricks.layout().high()];
    /// let words = bricks.words_between(low, high);
    /// assert_eq!(words.len(), (high - low).element_product() as usize);
    /// let count = words.iter().filter(|&&word| matches!(Word::of(word), Word::Brick(_))).count();
    /// assert_eq!(count, bricks.len());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn words_between(&self, low: IVec3, high: IVec3) -> Vec<u32> {
        let places = table::places(low, high - 1);
        places
            .map(|cell| self.words[self.word_index(cell)])
            .collect()
    }

    /// Bytes of everything.
    pub fn memory_bytes(&self) -> u64 {
        let tables = size_of_val(&self.masks[..])
            + size_of_val(&self.words[..])
            + size_of_val(&self.owners[..])
            + size_of_val(&self.materials[..])
            + size_of_val(&self.mixed[..])
            + size_of_val(&self.mixed_owners[..]);
        self.table.memory_bytes() + tables as u64 + self.pool.bytes().len() as u64
    }

    /// Where a cell's word stands.
    #[inline]
    pub fn word_index(&self, cell: IVec3) -> usize {
        let side = BLOCK_SIDE as i32;
        let block = cell.div_euclid(IVec3::splat(side));
        let inner = cell - block * side;
        self.table.slot(block) as usize * CELLS
            + (inner.x + side * (inner.y + side * inner.z)) as usize
    }

    /// The cell whose word stands there, of a block.
    pub fn cell_at(&self, index: usize) -> IVec3 {
        self.table.cell(index / CELLS) + inner_cell(index % CELLS)
    }

    /// What is in a cell, wherever it is.
    pub fn cell(&self, cell: IVec3) -> Word {
        Word::of(self.words[self.word_index(cell)])
    }

    /// Whether a point lies in a cell with a brick.
    pub fn has_brick(&self, point: Vec3) -> bool {
        matches!(self.cell(self.layout.cell_of(point)), Word::Brick(_))
    }

    /// What is stored for a point of the box: in a brick the interpolated distance, else one that is of its sign and never
    /// longer.
    pub fn distance(&self, point: Vec3) -> f32 {
        let mut out = [0.0];
        match self.layout.encoding.bits {
            crate::Bits::Eight => self.sampled::<i8>(point, &mut out),
            crate::Bits::Sixteen => self.sampled::<i16>(point, &mut out),
        }
        out[0]
    }

    fn sampled<T: crate::Texel>(&self, p: Vec3, out: &mut [f32; 1]) {
        if let Some(sampler) = BrickSampler::<T>::new(self) {
            sampler.distances([&[p.x], &[p.y], &[p.z]], 0.0, out);
        }
    }
}

/// Where a cell lies in its block.
pub(crate) fn inner_cell(nth: usize) -> IVec3 {
    let nth = nth as i32;
    IVec3::new(nth % 4, nth / 4 % 4, nth / 16)
}
