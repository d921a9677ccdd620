//! What is asked of the render worker, and its answers.

use crate::pipeline::Pipeline;
use argil::LevelsOptions;
use argil::gpu::ImageTextures;
use argil::render::{Camera, Percentiles, RenderMode};
use argil::volume::TileSource;
use std::sync::Arc;

/// A request for images.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RenderRequest {
    /// One pipeline, or two to compare.
    pub pipelines: Vec<Pipeline>,
    /// The render mode.
    pub show: RenderMode,
    /// Voxels along the longest side.
    pub resolution: u32,
    /// The camera.
    pub camera: Camera,
    /// Size in pixels.
    pub size: [u32; 2],
    /// Whether nothing is moving, so that the image is final.
    pub is_still: bool,
    /// Whether the final image is path traced.
    pub traces_paths: bool,
    /// Whether what rays do is counted.
    pub counts_rays: bool,
    /// Version of the document at the request.
    pub version: u64,
}

/// The pixels of an image.
#[derive(Clone, Debug)]
pub(crate) enum Pixels {
    /// On the CPU.
    Cpu {
        /// Three bytes of sRGB each.
        rgb: Vec<u8>,
        /// Distance along each ray to a solid; infinite without a hit.
        lengths: Vec<f32>,
    },
    /// In textures of the window's device.
    Gpu(Arc<ImageTextures>),
}

/// An image with its statistics.
#[derive(Clone, Debug)]
pub(crate) struct WorkerImage {
    /// The pipeline.
    pub pipeline: Pipeline,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The pixels.
    pub pixels: Pixels,
    /// Duration of rendering in milliseconds.
    pub frame_ms: f64,
    /// Total duration of edits since the last image in milliseconds. `None` without edits.
    pub edit_ms: Option<f64>,
    /// Steps of primary rays, if they were counted.
    pub steps: Option<Percentiles>,
    /// Memory of the representation.
    pub memory_bytes: u64,
    /// Number of bricks, if it has any.
    pub bricks: Option<u64>,
    /// Number of bricks that levels lack for this image, or 0 if there are few. It is not final before that.
    pub missing: u64,
    /// Number of pages that are not in the store, so that the image is coarser there.
    pub lost: u64,
    /// Number of paths per pixel, if it is path traced. Those that it lacks are missing.
    pub paths: Option<u32>,
    /// Number of triangles, for a mesh.
    pub triangles: Option<u64>,
}

/// The answer to a request.
#[derive(Debug)]
pub(crate) struct RenderAnswer {
    /// The request.
    pub request: RenderRequest,
    /// The images, or an error message.
    pub pictures: Result<Vec<WorkerImage>, String>,
    /// Duration from request to images in milliseconds.
    pub duration_ms: f64,
}

/// The tiles of a world in a store. They are of the scene that is loaded with them.
#[derive(Clone, Debug)]
pub(crate) struct StoredPages {
    /// Levels with the world's voxels.
    pub options: LevelsOptions,
    /// Where the pages come from.
    pub source: Arc<dyn TileSource>,
}
