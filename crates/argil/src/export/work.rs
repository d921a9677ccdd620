//! What both kinds of formats share.

use super::options::ExportError;
use std::io::{Seek, Write};
use std::path::PathBuf;
use web_time::Instant;

/// The box of the voxels with values, and their number.
pub(super) type Written = (Option<[[i32; 3]; 2]>, u64);

/// What volumes are written to. Code for a trait object is compiled with this crate, not with its caller.
pub(super) trait ExportSink: Write + Seek {}

impl<W: Write + Seek> ExportSink for W {}

/// Measures stages.
pub(super) struct ExportStages {
    begin: Instant,
    last: Instant,
    pub(super) all: Vec<(&'static str, f64)>,
}

impl ExportStages {
    pub(super) fn new() -> Self {
        let now = Instant::now();
        Self {
            begin: now,
            last: now,
            all: Vec::new(),
        }
    }

    /// Returns the milliseconds since the beginning.
    pub(super) fn total_ms(&self) -> f64 {
        self.begin.elapsed().as_secs_f64() * 1e3
    }

    pub(super) fn done(&mut self, stage: &'static str) {
        let now = Instant::now();
        let ms = (now - self.last).as_secs_f64() * 1e3;
        self.all.push((stage, ms));
        self.last = now;
    }
}

pub(super) fn write_failed(source: std::io::Error) -> ExportError {
    ExportError::Write {
        path: PathBuf::new(),
        source,
    }
}

/// Returns the density of a distance.
pub(super) fn density(distance: f32, half_width: f32) -> f32 {
    (-distance / half_width).clamp(0.0, 1.0)
}

/// Returns the columns and rows of layers in the image of a flip-book: nearly as many of both, and at least as many as layers.
pub(super) fn tiles(layers: u32) -> [u32; 2] {
    let columns = f64::from(layers).sqrt().ceil() as u32;
    [columns, layers.div_ceil(columns.max(1))]
}
