//! Kept as an octree of bricks.

use super::options::{BuildTimes, Kept, Options, Site, checked};
use crate::BuildError;
use crate::memory::check_memory;
use argil_gpu::{GpuVolume, Order};
use argil_march::Show;
use argil_volume::{Dense, Lattice, Layout, Octree, OctreeSettings, Volume};

/// An octree to be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeOptions {
    /// Voxels along the longest side.
    pub resolution: u32,
    /// Bricks, levels, encoding.
    pub settings: OctreeSettings,
    /// How a GPU puts bricks in order.
    pub order: Order,
}

impl Default for OctreeOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            settings: OctreeSettings::default(),
            order: Order::default(),
        }
    }
}

impl Options for OctreeOptions {
    const WORD: &'static str = "octree";
    const ABOUT: &'static str = "Bricks of distances under a tree: the 2023 study's structure";

    fn at(resolution: u32) -> Self {
        Self {
            resolution,
            ..Self::default()
        }
    }

    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn shows(&self, show: Show) -> bool {
        matches!(show, Show::Bricks | Show::Nodes)
    }

    fn of(volume: &Volume) -> Option<Self> {
        let Volume::Octree(octree) = volume else {
            return None;
        };
        let lattice = octree.layout().lattice;
        let settings = octree.settings();
        // As deep as the box asked for: of a larger one that may be deeper.
        let free = OctreeSettings {
            depth: None,
            ..settings
        };
        let is_usual =
            Layout::new(lattice, &free).is_ok_and(|own| Some(own.depth) == settings.depth);
        Some(Self {
            resolution: lattice.size.max_element(),
            settings: if is_usual { free } else { settings },
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
        let layout = Layout::new(lattice, &self.settings)?;
        let bits = layout.encoding.bits;
        let cells = 12 * u64::from(layout.code_count());
        check_memory(engine, Dense::bytes_of(&lattice, bits, false) + cells)?;
        let keep = self.settings.keep;
        if let Some(field) = site.field {
            let made = GpuVolume::octree(field, program, layout, keep, self.order);
            let (volume, stages) = made.await?;
            return Ok((Kept::Gpu(volume), BuildTimes::of_stages(stages)));
        }
        let baked = Octree::bake_controlled(program, layout, keep, &engine.control);
        let (octree, stages) = baked.ok_or(BuildError::Cancelled)?;
        let stages = vec![
            ("select", stages.select),
            ("fill", stages.fill),
            ("tree", stages.tree),
        ];
        Ok((Kept::Cpu(octree.into()), BuildTimes::of_stages(stages)))
    }
}
