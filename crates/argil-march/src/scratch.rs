//! A thread's buffers.

use crate::bricks::Near;
use crate::cones::Cones;
use crate::slabs::Slabs;
use crate::statistics::Counts;
use crate::wave::{Points, Starts, Wave};
use argil_abi::{Hit, MaterialWords};
use glam::Vec3;

/// A thread's buffers, kept from tile to tile and from picture to picture.
#[derive(Default)]
pub struct TileScratch {
    pub(crate) starts: Starts,
    pub(crate) wave: Wave,
    pub(crate) cones: Cones,
    pub(crate) near: Near,
    pub(crate) slabs: Slabs,
    pub(crate) points: Points,
    pub(crate) hits: Vec<u32>,
    /// Of each pixel, where triangles are drawn.
    pub(crate) directions: Vec<Vec3>,
    pub(crate) shading: Shading,
}

/// What a thread makes of a tile before it goes into the picture.
#[derive(Default)]
pub(crate) struct TilePicture {
    pub hits: Vec<Hit>,
    pub colors: Vec<[f32; 4]>,
    pub rgb: Vec<u8>,
    pub counts: Counts,
}

/// Buffers of the shading pass.
#[derive(Default)]
pub(crate) struct Shading {
    /// The tile's pixels that show a surface.
    pub lit: Vec<u32>,
    pub materials: Vec<MaterialWords>,
    /// Of the solid's points whose materials are evaluated: places among the materials, and what is found.
    pub untold: Vec<u32>,
    pub found: Vec<MaterialWords>,
    pub sun: Vec<f32>,
    pub sky: Vec<f32>,
    pub wave: Wave,
}
