//! Kept as sparse bricks.

use super::options::{BuildTimes, Kept, Options, Site, checked};
use crate::BuildError;
use crate::memory::budget_on;
use argil_gpu::GpuVolume;
use argil_march::Show;
use argil_volume::{BrickLayout, BrickSettings, Bricks, Lattice, Volume};

/// Sparse bricks to be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BricksOptions {
    /// Voxels along the longest side.
    pub resolution: u32,
    /// The edge of a voxel in the scene's unit, in place of that.
    pub voxel: Option<f32>,
    /// Bricks and encoding.
    pub settings: BrickSettings,
    /// Bytes that bricks and tables may take; as much as there is without it.
    pub memory_budget: Option<u64>,
}

impl Default for BricksOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            voxel: None,
            settings: BrickSettings::default(),
            memory_budget: None,
        }
    }
}

impl Options for BricksOptions {
    const WORD: &'static str = "bricks";
    const ABOUT: &'static str = "Sparse bricks of distances: the product's own structure";
    /// Voxels are counted from anywhere.
    const IS_ENDLESS: bool = true;

    fn at(resolution: u32) -> Self {
        Self {
            resolution,
            ..Self::default()
        }
    }

    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn voxel(&self) -> Option<f32> {
        self.voxel
    }

    fn memory_budget(&self) -> Option<u64> {
        self.memory_budget
    }

    fn shows(&self, show: Show) -> bool {
        show == Show::Bricks
    }

    fn of(volume: &Volume) -> Option<Self> {
        let Volume::Bricks(bricks) = volume else {
            return None;
        };
        let layout = bricks.layout();
        Some(Self {
            resolution: layout.lattice.size.max_element(),
            settings: BrickSettings {
                encoding: layout.encoding,
                brick: layout.brick,
            },
            ..Self::default()
        })
    }

    async fn build(
        &self,
        site: &Site<'_>,
        lattice: Lattice,
    ) -> Result<(Kept, BuildTimes), BuildError> {
        let Site {
            engine, program, ..
        } = *site;
        checked(self.settings.encoding)?;
        let layout = BrickLayout::new(lattice, &self.settings)?;
        let budget = budget_on(engine, self.memory_budget);
        let control = &engine.control;
        if let Some(field) = site.field {
            let made = GpuVolume::bricks_controlled(field, program, layout, budget, control);
            let (volume, stages) = made.await?;
            return Ok((Kept::Gpu(volume), BuildTimes::of_stages(stages)));
        }
        let (bricks, stages) = Bricks::bake_controlled(program, layout, budget, control)?;
        let stages = vec![
            ("prune", stages.prune),
            ("fill", stages.fill),
            ("settle", stages.settle),
        ];
        Ok((Kept::Cpu(bricks.into()), BuildTimes::of_stages(stages)))
    }
}
