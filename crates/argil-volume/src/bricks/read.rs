//! Reads bricks one by one, by cell, and by point.

use super::brick::Brick;
use super::cell::BrickCell;
use super::sampler::BrickSampler;
use super::table::places;
use super::tables::Bricks;
use argil_field::CELLS_PER_BATCH;
use glam::{IVec3, Vec3};
use std::ops::Range;

impl Bricks {
    /// Iterates over all bricks in the order of the pool.
    ///
    /// ```
    /// use argil_field::Program;
    /// use argil_scene::{Brush, Scene, Shape};
    /// use argil_volume::{BrickLayout, Bricks, VoxelGrid};
    /// let mut scene = Scene::new();
    /// scene.push(Brush::new(Shape::sphere(1.0))).unwrap();
    /// let program = Program::lower(&scene)?;
    /// let layout = BrickLayout::new(VoxelGrid::fitting(program.aabb(), None, 64)?, &Default::default())?;
    /// let (bricks, _) = Bricks::bake(&program, layout, None)?;
    /// for brick in bricks.iter() {
    ///     let first = brick.distances().next().expect("samples");
    ///     let exact = program.distance(brick.position(0));
    ///     let band = layout.encoding().band_width(layout.voxel_grid(), 0);
    ///     assert!((first - exact.clamp(-band, band)).abs() < 1e-4 * band);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Brick<'_>> + '_ {
        (0..self.store.cell_of_brick.len()).map(|index| Brick {
            bricks: self,
            index: index as u32,
        })
    }

    /// Returns the words of all cells from one to before another, x fastest, for a shader of your own: see
    /// `docs/march-bricks.md` in the repository. [`BrickCell::of`] decodes them.
    ///
    /// ```
    /// # use argil_volume::{BrickLayout, BrickSettings, Bricks, VoxelGrid, BrickCell};
    /// # let mut scene = argil_scene::Scene::new();
    /// # scene.push(argil_scene::Brush::new(argil_scene::Shape::sphere(1.0)))?;
    /// # let program = argil_field::Program::lower(&scene)?;
    /// # let voxel_grid = VoxelGrid::fitting(program.aabb(), None, 64)?;
    /// # let (bricks, _) = Bricks::bake(&program, BrickLayout::new(voxel_grid, &BrickSettings::default())?, None)?;
    /// let [low, high] = [bricks.layout().first_cell(), bricks.layout().end_cell()];
    /// let words = bricks.words_between(low, high);
    /// assert_eq!(words.len(), (high - low).element_product() as usize);
    /// let count = words.iter().filter(|&&word| matches!(BrickCell::of(word), BrickCell::Brick(_))).count();
    /// assert_eq!(count, bricks.len());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn words_between(&self, low: IVec3, high: IVec3) -> Vec<u32> {
        let places = places(low, high - 1);
        places
            .map(|cell| self.store.words[self.word_index(cell)])
            .collect()
    }

    /// Whether a point lies in a cell with a brick.
    pub fn has_brick(&self, point: Vec3) -> bool {
        matches!(self.cell(self.layout.cell_of(point)), BrickCell::Brick(_))
    }

    /// Returns the stored distance at a point of the box: interpolated in a brick, and a lower bound with the right
    /// sign elsewhere.
    pub fn distance(&self, point: Vec3) -> f32 {
        let mut out = [0.0];
        match self.layout.encoding.format {
            crate::SampleFormat::Snorm8 => self.sampled::<i8>(point, &mut out),
            crate::SampleFormat::Snorm16 => self.sampled::<i16>(point, &mut out),
        }
        out[0]
    }

    fn sampled<T: crate::Texel>(&self, p: Vec3, out: &mut [f32; 1]) {
        if let Some(sampler) = BrickSampler::<T>::new(self) {
            sampler.distances([&[p.x], &[p.y], &[p.z]], 0.0, out);
        }
    }

    /// Counts the cells in which other bricks of the same voxels differ: whether there is a brick, its samples, its
    /// materials. The order of the pool and the box do not matter. With other voxels, all cells differ.
    pub fn differing_cells(&self, other: &Self) -> u64 {
        let measures = |own: &Self| {
            let voxel_grid = own.layout.voxel_grid;
            (
                voxel_grid.corner,
                voxel_grid.voxel_size,
                own.layout.brick_size_voxels,
                own.layout.encoding.format,
            )
        };
        if measures(self) != measures(other) {
            return (self.len() + other.len()) as u64;
        }
        let bytes = self.layout.brick_bytes() as usize;
        let samples = |bricks: &Self, brick: u32| -> Range<usize> {
            let from = brick as usize * bytes;
            from..(from + bytes).min(bricks.store.pool.bytes().len())
        };
        let differ = |own: u32, theirs: u32| match (BrickCell::of(own), BrickCell::of(theirs)) {
            (BrickCell::Brick(a), BrickCell::Brick(b)) => {
                self.store.pool.bytes()[samples(self, a)]
                    != other.store.pool.bytes()[samples(other, b)]
                    || self.brick_material(a) != other.brick_material(b)
            }
            (BrickCell::Empty { .. }, BrickCell::Empty { .. }) => false,
            _ => true,
        };
        let of_slot = |bricks: &Self, slot: usize| {
            slot * CELLS_PER_BATCH..((slot + 1) * CELLS_PER_BATCH).min(bricks.store.words.len())
        };
        let mut count = 0;
        for (slot, block) in self.table.blocks() {
            let theirs = other.table.slot(block) as usize;
            let own = &self.store.words[of_slot(self, slot)];
            let theirs = &other.store.words[of_slot(other, theirs)];
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
}
