//! One texture over the whole box, as in Claybook (Aaltonen, "GPU-based clay simulation and ray-tracing tech in
//! Claybook", 2018).
//!
//! *Theory.* A sample holds a distance clamped to a narrow band, so a ray's step is at most the band. The band
//! doubles with each mip: far from the surface, a coarse level gives long steps. Coarse levels store lower bounds
//! (see [`Encoding::fill`]).
//!
//! *Practice.* [`Dense::bake`] samples every level from the field itself, with slabs in parallel and a pruned
//! program per cell (`bake_level.rs`). [`Dense::bake_unpruned`] evaluates the whole program everywhere. Claybook makes
//! its mips from the finest level instead.

mod volume_kind;

use crate::encoding::encode;
use crate::{Encoding, SampleFormat, Sampler, Texel, Texels, VoxelGrid, bake_level};
use argil_field::{Evaluator, Program};
use argil_math::Control;
use glam::Vec3;
use rayon::prelude::*;

/// Minimum samples along the longest side of the coarsest mip.
const COARSEST: u32 = 4;

/// How a GPU fills the texture of a dense volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum DenseFill {
    /// A tile of 32³ samples per workgroup, and a column of 32 per thread.
    #[default]
    Tiled,
    /// The 2023 study's first method: one thread per workgroup, one sample per thread.
    Naive,
}

/// A dense volume: samples at the center of every voxel.
///
/// ```
/// use argil_field::Program;
/// use argil_scene::{Scene, Shape};
/// use argil_volume::{Dense, Encoding, VoxelGrid};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(0.5))?;
/// let program = Program::lower(&scene)?;
/// let grid = VoxelGrid::fitting(program.aabb(), None, 32)?;
/// let volume = Dense::bake(&program, grid, Encoding::default(), true);
/// assert!(volume.levels().len() > 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias = "3D texture")]
pub struct Dense {
    voxel_grid: VoxelGrid,
    encoding: Encoding,
    levels: Vec<Texels>,
}

impl Dense {
    /// Bakes all levels from a field with pruned programs, on rayon's current threads.
    pub fn bake(program: &Program, voxel_grid: VoxelGrid, encoding: Encoding, mips: bool) -> Self {
        let how = (true, &Control::default());
        Self::bake_with(program, voxel_grid, encoding, mips, how)
    }

    /// Bakes as [`Dense::bake`] does, reports progress as the stage "layers", and can be canceled. Returns `None`
    /// if it was.
    pub fn bake_with_control(
        program: &Program,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        mips: bool,
        control: &Control,
    ) -> Option<Self> {
        let dense = Self::bake_with(program, voxel_grid, encoding, mips, (true, control));
        (!control.is_cancelled()).then_some(dense)
    }

    /// Bakes the same samples without pruning, as a reference for tests.
    pub fn bake_unpruned(
        program: &Program,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        mips: bool,
    ) -> Self {
        let how = (false, &Control::default());
        Self::bake_with(program, voxel_grid, encoding, mips, how)
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

    /// Creates a volume from stored levels. Returns `None` if there are none, or if a level's size does not match
    /// the grid.
    pub fn from_levels(
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        levels: Vec<Texels>,
    ) -> Option<Self> {
        let fits = |(level, texels): (usize, &Texels)| {
            let bytes = voxel_grid.texel_count(level as u32) * encoding.format.bytes() as u64;
            texels.bits() == encoding.format && texels.bytes().len() as u64 == bytes
        };
        (!levels.is_empty() && levels.iter().enumerate().all(fits)).then_some(Self {
            voxel_grid,
            encoding,
            levels,
        })
    }

    /// Returns the number of levels: one, or with mips as many as are useful, down to four samples along the
    /// longest side.
    pub fn level_count(
        program: &Program,
        voxel_grid: &VoxelGrid,
        encoding: &Encoding,
        mips: bool,
    ) -> u32 {
        let most = if mips {
            Self::max_levels(voxel_grid)
        } else {
            1
        };
        let tells = |&level: &u32| {
            encoding.fill_uniform(program, voxel_grid, level).first_bias[3] < f32::MAX
        };
        1 + (1..most).take_while(tells).count() as u32
    }

    /// Returns the maximum number of levels.
    pub fn max_levels(voxel_grid: &VoxelGrid) -> u32 {
        (voxel_grid.size.max_element() / COARSEST).max(1).ilog2() + 1
    }

    /// Returns the maximum bytes of a volume before it is baked.
    pub fn bytes_of(voxel_grid: &VoxelGrid, bits: SampleFormat, mips: bool) -> u64 {
        (0..if mips {
            Self::max_levels(voxel_grid)
        } else {
            1
        })
            .map(|level| voxel_grid.texel_count(level) * bits.bytes() as u64)
            .sum()
    }

    /// Returns the voxel grid.
    pub fn voxel_grid(&self) -> &VoxelGrid {
        &self.voxel_grid
    }

    /// Returns the format and band of samples.
    pub fn encoding(&self) -> &Encoding {
        &self.encoding
    }

    /// Returns the samples of each level, finest first.
    pub fn levels(&self) -> &[Texels] {
        &self.levels
    }

    /// Returns the bytes of all samples.
    pub fn memory_bytes(&self) -> u64 {
        self.levels.iter().map(|t| t.bytes().len() as u64).sum()
    }

    /// Returns samplers of all levels, or none if the samples have another type.
    pub fn samplers<T: Texel>(&self) -> Vec<Sampler<'_, T>> {
        self.levels
            .iter()
            .zip(0..)
            .filter_map(|(t, level)| Sampler::new(t.of()?, &self.voxel_grid, &self.encoding, level))
            .collect()
    }

    /// Returns the stored value at a point of the box: the signed distance on level 0, and a lower bound of the
    /// unsigned distance on the others, if above 0. Returns `None` if the level does not exist.
    pub fn distance(&self, level: u32, point: Vec3) -> Option<f32> {
        let texels = self.levels.get(level as usize)?;
        let (voxel_grid, encoding) = (&self.voxel_grid, &self.encoding);
        match encoding.format {
            SampleFormat::Snorm8 => {
                let sampler = Sampler::<i8>::new(texels.of()?, voxel_grid, encoding, level)?;
                Some(sampler.distance(point))
            }
            SampleFormat::Snorm16 => {
                let sampler = Sampler::<i16>::new(texels.of()?, voxel_grid, encoding, level)?;
                Some(sampler.distance(point))
            }
        }
    }
}

fn bake_level<T: Texel>(
    program: &Program,
    voxel_grid: &VoxelGrid,
    encoding: &Encoding,
    level: u32,
    (pruned, control): (bool, &Control),
) -> Texels {
    let words = encoding.fill_uniform(program, voxel_grid, level);
    let grid = voxel_grid.grid(level);
    if pruned {
        return bake_level::sample::<T>(program, &grid, &words, &|_| None, control);
    }
    let xs = grid.coordinates(0);
    let mut texels = vec![T::default(); voxel_grid.texel_count(level) as usize];
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
