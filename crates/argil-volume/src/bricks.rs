//! Sparse bricks: the product's own representation.
//!
//! *Theory.* Only cells near the surface need samples; what a ray wants to know elsewhere is how far it can go. So a grid
//! of cells holds, where there is no brick, how far the surface is from the cell's centre at least (what Barbier et al.,
//! "Lipschitz pruning", 2025, keep for far cells): less half of the cell's diagonal, no point of the cell falls short
//! of it. Bricks are as small as caches like them (8³ cells, after Lumen and GigaVoxels, Crassin 2009).
//!
//! ```text
//!   masks   one for each block of 4³ cells: a bit for each cell with a brick
//!   words   one for each cell, block by block: a brick's place, or a distance and whether the whole block is empty
//!   materials, mixed   what bricks look like, see `material.rs`
//!   pool    (brick + 1)³ samples a brick, x fastest: its cells' corners, so that interpolation never leaves it
//! ```
//!
//! *Practice.* Samples stand at voxels' corners, `corner + voxel · (i, j, k)`; neighbouring bricks have those of their
//! common side both. `build.rs` bakes on the CPU, `batch.rs` reads for rays. What differs from the literature: a brick is
//! dropped again where its own samples show that the surface cannot be in it. The tables hold the very resolution that was asked for.

mod batch;
mod block_list;
mod build;
mod cell_lists;
mod edit;
mod filler;
mod layout;
mod material;
mod octants;
mod pool;
mod words;
mod work;

use crate::Texels;
use argil_abi::BRICK_MIXED;
use argil_field::Program;
use glam::{UVec3, Vec3};
use std::ops::Range;

pub use batch::{Beyond, BrickSampler, Corners, Located};
pub use block_list::BlockList;
pub use build::BrickStagesMs;
pub use cell_lists::CellLists;
pub use edit::BrickEdit;
pub use layout::{BLOCK_SIDE, BrickLayout, BrickSettings, BricksError};
pub use words::{Word, center_of, empty_word, is_brick, is_lonely};
pub use work::{EditWork, Unit};

/// A sparse volume of bricks.
#[derive(Clone, PartialEq)]
pub struct Bricks {
    layout: BrickLayout,
    /// By how much distances can change over a length of 1.
    lipschitz: f32,
    /// A bit for each cell of a block that has a brick.
    masks: Vec<u64>,
    /// What is in each cell, block by block.
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
}

impl Bricks {
    /// Sample a field, on rayon's current threads; what the stages took.
    ///
    /// # Errors
    /// If the bricks and tables would take more than `budget` bytes.
    pub fn bake(
        program: &Program,
        layout: BrickLayout,
        budget: Option<u64>,
    ) -> Result<(Self, BrickStagesMs), BricksError> {
        build::bake(program, layout, budget).map(|(bricks, _, stages)| (bricks, stages))
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
        build::bake(program, layout, budget)
    }

    /// From stored parts; what is wrong with them where they do not fit one another.
    pub fn from_parts(
        layout: BrickLayout,
        lipschitz: f32,
        words: Vec<u32>,
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
        if words.len() as u64 != layout.word_count() {
            return Err("there are not as many cells as the volume has");
        }
        if layout.check_count((length / samples) as u64).is_err() {
            return Err("it has more bricks than can be");
        }
        let mut owners = vec![u32::MAX; length / samples];
        let mut masks = vec![0u64; words.len() / 64];
        for (at, &word) in words.iter().enumerate() {
            if let Word::Brick(brick) = Word::of(word) {
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
            materials,
            mixed,
            layout,
            lipschitz,
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

    /// What is in each cell, block by block.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// A bit for each cell with a brick, a mask for each block.
    pub fn masks(&self) -> &[u64] {
        &self.masks
    }

    /// Whose each brick is: the place of its cell's word.
    pub fn owners(&self) -> &[u32] {
        &self.owners
    }

    /// The bricks' samples, brick by brick. Where there is no brick at all, there is one of zeros.
    pub fn pool(&self) -> &Texels {
        &self.pool
    }

    /// Number of bricks.
    pub fn len(&self) -> usize {
        self.owners.len()
    }

    /// Whether there is no brick.
    pub fn is_empty(&self) -> bool {
        self.owners.is_empty()
    }

    /// In how many cells other bricks of the same layout differ: whether there is a brick, its samples, what it looks like.
    /// Where bricks stand in the pool makes no difference.
    pub fn differing_cells(&self, other: &Self) -> u64 {
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
        let words = self.words.iter().zip(&other.words);
        words
            .filter(|(own, theirs)| differ(**own, **theirs))
            .count() as u64
    }

    /// Bytes of everything.
    pub fn memory_bytes(&self) -> u64 {
        let tables = size_of_val(&self.masks[..])
            + size_of_val(&self.words[..])
            + size_of_val(&self.owners[..])
            + size_of_val(&self.materials[..])
            + size_of_val(&self.mixed[..])
            + size_of_val(&self.mixed_owners[..]);
        tables as u64 + self.pool.bytes().len() as u64
    }

    /// What is in a cell of the grid.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn cell(&self, cell: UVec3) -> Word {
        Word::of(self.words[self.layout.word_index(cell)])
    }

    /// Whether a point lies in a cell with a brick.
    pub fn has_brick(&self, point: Vec3) -> bool {
        let at = ((point - self.layout.lattice.corner) / self.layout.cell_length()).floor();
        let is_in = at.cmpge(Vec3::ZERO).all() && at.cmplt(self.layout.grid.as_vec3()).all();
        is_in && matches!(self.cell(at.as_uvec3()), Word::Brick(_))
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
