//! The buffers of a thread.

use crate::ray_batch::{Points, RayBatch, RaySetup};
use crate::ray_stats::RayCounts;
use crate::source_scratch::SourceScratch;
use argil_abi::Hit;

/// The buffers of a thread, kept from tile to tile and from image to image.
#[derive(Debug, Default)]
pub struct TileScratch {
    pub(crate) starts: RaySetup,
    pub(crate) wave: RayBatch,
    pub(crate) source: SourceScratch,
    pub(crate) points: Points,
    pub(crate) hits: Vec<u32>,
}

/// A thread's result for a tile, before it goes into the image.
#[derive(Default)]
pub(crate) struct TilePicture {
    /// One for each sample that is lit with others.
    pub hits: Vec<Vec<Hit>>,
    pub colors: Vec<[f32; 4]>,
    pub rgb: Vec<u8>,
    pub counts: RayCounts,
}
