//! Light that surfaces receive: how much of the sun, and of the sky. `shade.wgsl` is the twin.
//!
//! *Theory.* The sun's shadow is soft where its ray comes close to the surface (after Quilez, "Soft shadows in
//! raymarched SDFs", 2010). The sky's light is reduced where the surface is nearer than an open one along the normal
//! (after Evans, "Fast approximations for global illumination on dynamic scenes", 2006).
//!
//! *Practice.* All samples of a tile are lit together. A block of 8×8 pixels sends one cone to the sun (`sun.rs`),
//! and a group of 4×4 pixels measures the sky where distances are linear for all of them (`sky.rs`). Shadows' rays
//! march in batches, as primary ones do.

mod bent;
mod frame_fog;
mod haze;
mod lamp_light;
mod lamp_rays;
mod lamp_shadows;
mod lamp_shape;
mod lamps;
mod light_source;
mod lobes;
mod more;
mod patches;
pub(crate) mod reflect;
mod shadow_rays;
mod sky;
pub(crate) mod sun;

use crate::camera::bounds_of;
use crate::ray_batch::Points;
use crate::surfaces::Surfaces;
use crate::tile::Tile;
use argil_abi::{self as abi, FrameUniform, GpuMaterial, Hit};
use argil_math::Aabb;
pub(crate) use light_source::LightSource;
use more::MoreLight;
use sky::SkyScratch;
pub use sun::SHADOW_STEPS;
use sun::SunScratch;

pub(crate) const GROUND: GpuMaterial = GpuMaterial {
    base_roughness: [0.46, 0.45, 0.43, 0.9],
    emission_metallic: [0.0, 0.0, 0.0, 0.0],
};

/// The samples of a tile and their light, with the buffers that this needs.
#[derive(Debug, Default)]
pub(crate) struct Light {
    pub surfaces: Surfaces,
    /// Samples that show the sky.
    pub sky_samples: Surfaces,
    pub materials: Vec<GpuMaterial>,
    /// The visible fraction of the sun and of the sky, one per surface.
    pub sun: Vec<f32>,
    pub sky: Vec<f32>,
    /// What only some images have.
    pub more: MoreLight,
    /// The surfaces whose materials the field gives, and these.
    unresolved: Vec<u32>,
    found: Vec<GpuMaterial>,
    sun_scratch: SunScratch,
    sky_scratch: SkyScratch,
}

impl Light {
    /// Evaluates materials and light for the samples of a tile, one frame each.
    pub(crate) fn gather(
        &mut self,
        frames: &[FrameUniform],
        tile: Tile,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
        hits: &[Vec<Hit>],
    ) {
        let Some(frame) = frames.first() else { return };
        self.surfaces
            .gather(frames, tile, hits, &mut self.sky_samples);
        self.look(source, points);
        let Self { surfaces, .. } = self;
        self.sky_scratch
            .gather(frame, surfaces, source, points, &mut self.sky);
        self.sun_scratch
            .gather(frame, surfaces, source, points, &mut self.sun);
        let samples = (&self.surfaces, &self.sky_samples);
        let (materials, sky) = (&self.materials, &mut self.sky);
        self.more
            .gather(frame, samples, materials, source, points, sky);
    }

    /// Looks up the materials. The ground has its own. The field gives what the source does not have.
    fn look(&mut self, source: &mut LightSource<'_, '_>, points: &mut Points) {
        let surfaces = &self.surfaces;
        self.materials.clear();
        self.materials.resize(surfaces.len(), GROUND);
        self.unresolved.clear();
        let solid = (0..surfaces.len()).filter(|&i| surfaces.kind[i] != abi::HIT_GROUND);
        self.unresolved.extend(solid.map(|i| i as u32));
        if let Some(air) = source.air {
            let palette = source.probe.program.materials();
            air.materials(surfaces, palette, &mut self.unresolved, &mut self.materials);
        }
        points.clear();
        for &i in &self.unresolved {
            points.push(surfaces.point(i as usize));
        }
        self.found.resize(self.unresolved.len(), GROUND);
        source.probe.materials(points, &mut self.found);
        for (&i, found) in self.unresolved.iter().zip(&self.found) {
            self.materials[i as usize] = *found;
        }
    }
}

/// Returns the box of all points whose distances an image uses, and the distance beyond which they do not matter.
pub(crate) fn light_reach(frame: &FrameUniform) -> (Aabb, f32) {
    let bounds = bounds_of(frame);
    let tap = sky::tap_height(frame.radius, sky::TAPS - 1);
    let bias = frame.normal_bias;
    let around = bounds.grown(tap + 2.0 * bias);
    // A shadow may be cast from farther away where it is wider, and no ray is longer than the box.
    let penumbra = 2.0 * bounds.half_diagonal() / sun::SHARPNESS;
    let lamps = lamp_shadows::reach(frame);
    (around, tap.max(penumbra).max(lamps))
}

/// Returns the height of the highest point above a surface that occlusion asks for, for a length of a primary ray.
pub(crate) fn tap_height_of(frame: &FrameUniform, length: f32) -> f32 {
    sky::tap_height(sky::reach_at(frame, length), sky::TAPS - 1)
}
