//! Levels of detail have no GPU version yet.

use crate::GpuError;
use crate::program::GpuProgram;
use crate::volume::{GpuVolume, Upload};
use crate::work::Work;
use argil_volume::Levels;

impl Upload for Levels {
    fn upload<'a>(&'a self, _: &'a GpuProgram) -> Work<'a, GpuVolume> {
        Box::pin(async { Err(GpuError::LevelsOnCpu) })
    }
}
