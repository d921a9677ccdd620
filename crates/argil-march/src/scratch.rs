//! A thread's buffers.

use crate::wave::{Points, Wave};
use argil_abi::MaterialWords;

/// A thread's buffers, kept from tile to tile.
#[derive(Default)]
pub struct TileScratch {
    pub(crate) wave: Wave,
    pub(crate) points: Points,
    pub(crate) hits: Vec<u32>,
    pub(crate) shading: Shading,
}

/// Buffers of the shading pass.
#[derive(Default)]
pub(crate) struct Shading {
    /// The tile's pixels that show a surface.
    pub lit: Vec<u32>,
    pub materials: Vec<MaterialWords>,
    /// Of the solid's points alone.
    pub found: Vec<MaterialWords>,
    pub sun: Vec<f32>,
    pub sky: Vec<f32>,
    pub wave: Wave,
}
