//! One texture over the whole box, as Claybook has it (Aaltonen, "GPU-based clay simulation and ray-tracing tech in
//! Claybook", 2018).
//!
//! *Theory.* A texel holds a distance clamped to a narrow band, so that a step of a ray is no longer than the band. On
//! mips the band doubles level by level: far from the surface a coarse level gives long steps. A coarse level tells
//! how far the surface is at least (see [`Encoding::fill`]).
//!
//! *Practice.* [`Dense::bake`] samples every level from the field itself, slabs in parallel, cells with what can matter in
//! each (`fill.rs`), straight into the texels. [`Dense::bake_whole`] evaluates everything everywhere. What differs from Claybook: it makes its mips from the finest level.

mod volume_kind;

use crate::encoding::encode;
use crate::{Encoding, SampleFormat, Sampler, Texel, Texels, VoxelGrid, bake_level};
use argil_field::{Evaluator, Program};
use argil_math::Control;
use glam::Vec3;
use rayon::prelude::*;

/// Fewest texels along the longest side of the coarsest mip.
const COARSEST: u32 = 4;

/// A dense volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Dense {
    voxel_grid: VoxelGrid,
    encoding: Encoding,
    levels: Vec<Texels>,
}

impl Dense {
    /// Sample a field on all levels, on rayon's current threads, each cell with what can matter there.
    pub fn bake(program: &Program, lattice: VoxelGrid, encoding: Encoding, mips: bool) -> Self {
        let how = (true, &Control::default());
        Self::bake_with(program, lattice, encoding, mips, how)
    }

    /// [`Dense::bake`], which can be stopped and tells how far it is: the stage "layers". `None` if it was cancelled.
    pub fn bake_with_control(
        program: &Program,
        lattice: VoxelGrid,
        encoding: Encoding,
        mips: bool,
        control: &Control,
    ) -> Option<Self> {
        let dense = Self::bake_with(program, lattice, encoding, mips, (true, control));
        (!control.is_cancelled()).then_some(dense)
    }

    /// The same texels with nothing pruned: what pruning is held against.
    pub fn bake_whole(
        program: &Program,
        lattice: VoxelGrid,
        encoding: Encoding,
        mips: bool,
    ) -> Self {
        let how = (false, &Control::default());
        Self::bake_with(program, lattice, encoding, mips, how)
    }

    fn bake_with(
        program: &Program,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        mips: bool,
        (pruned, control): (bool, &Control),
    ) -> Self {
        let levels = (0..Self::level_count(program, &voxel_grid, &encoding, mips))
            .map(|level| match encoding.format {
                SampleFormat::Snorm8 => {
                    bake_level::<i8>(program, &voxel_grid, &encoding, level, (pruned, control))
                }
                SampleFormat::Snorm16 => {
                    bake_level::<i16>(program, &voxel_grid, &encoding, level, (pruned, control))
                }
            })
            .collect();
        Self {
            voxel_grid,
            encoding,
            levels,
        }
    }

    /// From stored levels; `None` where there are none, or one has not the size that the lattice says.
    pub fn from_levels(
        lattice: VoxelGrid,
        encoding: Encoding,
        levels: Vec<Texels>,
    ) -> Option<Self> {
        let fits = |(level, texels): (usize, &Texels)| {
            let bytes = lattice.texel_count(level as u32) * encoding.format.bytes() as u64;
            texels.bits() == encoding.format && texels.bytes().len() as u64 == bytes
        };
        (!levels.is_empty() && levels.iter().enumerate().all(fits)).then_some(Self {
            voxel_grid: lattice,
            encoding,
            levels,
        })
    }

    /// Levels of detail of a volume: one, or with mips as many as tell something, down to four texels along the longest
    /// side.
    pub fn level_count(
        program: &Program,
        lattice: &VoxelGrid,
        encoding: &Encoding,
        mips: bool,
    ) -> u32 {
        let most = if mips { Self::max_levels(lattice) } else { 1 };
        let tells = |&level: &u32| encoding.fill(program, lattice, level).first_bias[3] < f32::MAX;
        1 + (1..most).take_while(tells).count() as u32
    }

    /// Levels of detail that a volume can have.
    pub fn max_levels(lattice: &VoxelGrid) -> u32 {
        (lattice.size.max_element() / COARSEST).max(1).ilog2() + 1
    }

    /// Bytes of all texels of a volume that is not there yet, at most.
    pub fn bytes_of(lattice: &VoxelGrid, bits: SampleFormat, mips: bool) -> u64 {
        (0..if mips { Self::max_levels(lattice) } else { 1 })
            .map(|level| lattice.texel_count(level) * bits.bytes() as u64)
            .sum()
    }

    /// Where the voxels lie.
    pub fn lattice(&self) -> &VoxelGrid {
        &self.voxel_grid
    }

    /// What texels mean.
    pub fn encoding(&self) -> &Encoding {
        &self.encoding
    }

    /// The texels of each level, the finest first.
    pub fn levels(&self) -> &[Texels] {
        &self.levels
    }

    /// Bytes of all texels.
    pub fn memory_bytes(&self) -> u64 {
        self.levels.iter().map(|t| t.bytes().len() as u64).sum()
    }

    /// Samplers of all levels; empty if the volume has texels of another type.
    pub fn samplers<T: Texel>(&self) -> Vec<Sampler<'_, T>> {
        self.levels
            .iter()
            .zip(0..)
            .filter_map(|(t, level)| Sampler::new(t.of()?, &self.voxel_grid, &self.encoding, level))
            .collect()
    }

    /// What is stored on a level at a point of the box: the signed distance on level 0, on others a length that the
    /// surface is away at least, where it is above 0. `None` for a level that is not there.
    pub fn distance(&self, level: u32, point: Vec3) -> Option<f32> {
        let texels = self.levels.get(level as usize)?;
        let (lattice, encoding) = (&self.voxel_grid, &self.encoding);
        match encoding.format {
            SampleFormat::Snorm8 => {
                let sampler = Sampler::<i8>::new(texels.of()?, lattice, encoding, level)?;
                Some(sampler.distance(point))
            }
            SampleFormat::Snorm16 => {
                let sampler = Sampler::<i16>::new(texels.of()?, lattice, encoding, level)?;
                Some(sampler.distance(point))
            }
        }
    }
}

fn bake_level<T: Texel>(
    program: &Program,
    lattice: &VoxelGrid,
    encoding: &Encoding,
    level: u32,
    (pruned, control): (bool, &Control),
) -> Texels {
    let words = encoding.fill(program, lattice, level);
    let grid = lattice.grid(level);
    if pruned {
        return bake_level::sample::<T>(program, &grid, &words, &|_| None, control);
    }
    let xs = grid.coordinates(0);
    let mut texels = vec![T::default(); lattice.texel_count(level) as usize];
    texels
        .par_chunks_mut(grid.layer_len())
        .enumerate()
        .for_each_init(
            || Evaluator::new(program),
            |evaluator, (k, layer)| {
                grid.sweep_layer(evaluator, &xs, k as u32, |range, d| {
                    encode(d, &words, &mut layer[range]);
                });
            },
        );
    Texels::from_vec(texels)
}
