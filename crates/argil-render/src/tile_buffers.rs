//! The buffers of a thread.

use crate::ray_batch::{Points, RayBatch, RaySetup};
use crate::ray_stats::RayCounts;
use argil_abi::{GpuMaterial, Hit};
use std::any::Any;

/// The buffers of a thread, kept from tile to tile and from image to image.
#[derive(Debug, Default)]
pub struct TileScratch {
    pub(crate) starts: RaySetup,
    pub(crate) wave: RayBatch,
    pub(crate) own: SourceScratch,
    pub(crate) points: Points,
    pub(crate) hits: Vec<u32>,
    pub(crate) shading: Shading,
}

/// Buffers that only one kind of source needs, created when first asked for.
#[derive(Debug, Default)]
pub(crate) struct SourceScratch(Vec<Box<dyn Any + Send>>);

impl SourceScratch {
    /// Returns the buffers of a type.
    pub(crate) fn of<T: Default + Send + 'static>(&mut self) -> &mut T {
        let place = self.0.iter().position(|one| one.is::<T>());
        let place = place.unwrap_or_else(|| {
            self.0.push(Box::new(T::default()));
            self.0.len() - 1
        });
        let own = self.0[place].downcast_mut();
        own.expect("the place was found by its type")
    }
}

/// A thread's result for a tile, before it goes into the image.
#[derive(Default)]
pub(crate) struct TilePicture {
    pub hits: Vec<Hit>,
    pub colors: Vec<[f32; 4]>,
    pub rgb: Vec<u8>,
    pub counts: RayCounts,
}

/// Buffers of the shading pass.
#[derive(Debug, Default)]
pub(crate) struct Shading {
    /// The tile's pixels that show a surface.
    pub lit: Vec<u32>,
    pub materials: Vec<GpuMaterial>,
    /// The solid's points whose materials the field gives: their indices among the materials, and the results.
    pub unresolved: Vec<u32>,
    pub found: Vec<GpuMaterial>,
    pub sun: Vec<f32>,
    pub sky: Vec<f32>,
    pub wave: RayBatch,
}
