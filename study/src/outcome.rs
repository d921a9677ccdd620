//! The results of a case.

use crate::clock_range::ClockRange;
use argil::{RenderedImage, World};
use argil_metrics::ErrorStats;
use image::RgbImage;
use std::collections::BTreeMap;

/// The results of a case.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome {
    /// See [`crate::record::Record`].
    pub samples: BTreeMap<String, Vec<f64>>,
    /// See [`crate::record::Record`].
    pub values: BTreeMap<String, f64>,
    /// Images by name.
    pub pictures: Vec<(String, RgbImage)>,
}

impl Outcome {
    /// Stores a value, unless it is not finite. A check of a missing value fails.
    pub(crate) fn set(&mut self, name: &str, value: f64) {
        if value.is_finite() {
            self.values.insert(name.into(), value);
        }
    }

    /// Stores one of several samples, unless it is not finite.
    pub(crate) fn add(&mut self, name: &str, sample: f64) {
        if sample.is_finite() {
            self.samples.entry(name.into()).or_default().push(sample);
        }
    }

    /// Stores what the rays of an image did, if that was counted.
    pub(crate) fn add_statistics(&mut self, drawn: &RenderedImage) {
        let Some(statistics) = &drawn.statistics else {
            return;
        };
        for (name, spread) in [
            ("steps", statistics.steps),
            ("samples", statistics.samples),
            ("descents", statistics.descents),
            ("cells", statistics.cells),
        ] {
            self.add(&format!("{name}_mean"), spread.mean);
            if name == "steps" {
                self.add("steps_p95", spread.p95);
                self.add("steps_max", spread.max);
            }
        }
    }

    /// Stores the mean, the root mean square and the maximum of errors, in a unit.
    pub(crate) fn spread(&mut self, name: &str, spread: &ErrorStats, unit: f64) {
        self.set(&format!("{name}_mean"), spread.mean / unit);
        self.set(&format!("{name}_rms"), spread.rms / unit);
        self.set(&format!("{name}_max"), spread.max / unit);
    }

    /// Stores the clock of the GPU while the samples were taken.
    pub(crate) fn clocks(&mut self, range: ClockRange) {
        self.set("gpu_clock_mhz", range.median);
        self.set("gpu_clock_min_mhz", range.min);
        self.set("gpu_clock_max_mhz", range.max);
        if let Some(limit) = range.limit {
            self.set("gpu_clock_limit_mhz", limit);
        }
    }

    /// Stores facts about a world's representation.
    pub(crate) fn about(&mut self, world: &World) -> anyhow::Result<()> {
        self.set("memory_bytes", world.memory_bytes() as f64);
        let info = world.volume_info()?;
        if let Some(tree) = info.and_then(|info| info.octree) {
            self.set("bricks", tree.bricks as f64);
            self.set("nodes", tree.nodes as f64);
        }
        if let Some(sparse) = info.and_then(|info| info.bricks) {
            self.set("bricks", sparse.bricks as f64);
        }
        if let Some(argil::MeshCounts {
            triangles,
            vertices,
        }) = world.mesh_counts()
        {
            self.set("triangles", triangles as f64);
            self.set("vertices", vertices as f64);
        }
        Ok(())
    }
}
