//! Bricks of either sample format, ready to be marched.

use super::cones::ConeDistances;
use crate::both_formats::of_both_formats;
use argil_abi::GpuMaterial;
use argil_volume::{BrickSampler, Bricks, EstimateLanes, LevelSampler, SampleFormat, Texel};

/// Bricks, ready to be marched.
pub(crate) enum BrickRays<'a> {
    Eight(BrickSampler<'a, i8>),
    Sixteen(BrickSampler<'a, i16>),
}

impl<'a> BrickRays<'a> {
    pub(super) fn new(bricks: &'a Bricks) -> Option<Self> {
        match bricks.layout().encoding().format {
            SampleFormat::Snorm8 => BrickSampler::new(bricks).map(Self::Eight),
            SampleFormat::Snorm16 => BrickSampler::new(bricks).map(Self::Sixteen),
        }
    }

    /// Computes lower bounds of the signed distance around points in the scene's space. Interpolation is off by at
    /// most half of a voxel's diagonal.
    pub(super) fn clearances(&self, points: [&[f32]; 3], out: &mut [f32]) {
        let margin = 0.5 * 3f32.sqrt() * self.voxel();
        match self {
            Self::Eight(sampler) => clearances_i8(sampler, points, margin, out),
            Self::Sixteen(sampler) => clearances_i16(sampler, points, margin, out),
        }
    }

    /// Estimates the signed distances at points in the scene's space.
    pub(super) fn estimates(
        &self,
        points: [&[f32]; 3],
        light: Option<&LevelSampler<'_, i16>>,
        lanes: &mut EstimateLanes,
        out: &mut [f32],
    ) {
        match self {
            Self::Eight(sampler) => estimates_i8(sampler, points, light, lanes, out),
            Self::Sixteen(sampler) => estimates_i16(sampler, points, light, lanes, out),
        }
    }

    /// Looks up the materials at points of surfaces, given these and the outward directions. Outside bricks there is none.
    pub(super) fn materials(
        &self,
        surfaces: [[&[f32]; 3]; 2],
        palette: &[GpuMaterial],
        out: &mut [Option<GpuMaterial>],
    ) {
        match self {
            Self::Eight(sampler) => materials_i8(sampler, surfaces, palette, out),
            Self::Sixteen(sampler) => materials_i16(sampler, surfaces, palette, out),
        }
    }

    pub(super) fn voxel(&self) -> f32 {
        match self {
            Self::Eight(sampler) => sampler.layout().voxel_grid().voxel_size,
            Self::Sixteen(sampler) => sampler.layout().voxel_grid().voxel_size,
        }
    }

    pub(super) fn bounds(&self) -> argil_math::Aabb {
        match self {
            Self::Eight(sampler) => sampler.layout().voxel_grid().aabb(),
            Self::Sixteen(sampler) => sampler.layout().voxel_grid().aabb(),
        }
    }
}

impl ConeDistances for &BrickRays<'_> {
    fn bounds(&self) -> argil_math::Aabb {
        BrickRays::bounds(self)
    }

    fn clearances(&mut self, points: [&[f32]; 3], _: &[f32], out: &mut [f32], voxel: &mut [f32]) {
        BrickRays::clearances(self, points, out);
        voxel.fill(self.voxel());
    }
}

#[inline(always)]
fn clearances<T: Texel>(
    sampler: &BrickSampler<'_, T>,
    points: [&[f32]; 3],
    margin: f32,
    out: &mut [f32],
) {
    sampler.distances(points, margin, out);
}

#[inline(always)]
fn materials<T: Texel>(
    sampler: &BrickSampler<'_, T>,
    surfaces: [[&[f32]; 3]; 2],
    palette: &[GpuMaterial],
    out: &mut [Option<GpuMaterial>],
) {
    sampler.materials(surfaces, palette, out);
}

#[inline(always)]
fn estimates<T: Texel>(
    sampler: &BrickSampler<'_, T>,
    points: [&[f32]; 3],
    light: Option<&LevelSampler<'_, i16>>,
    lanes: &mut EstimateLanes,
    out: &mut [f32],
) {
    sampler.estimates(points, light, lanes, out);
}

of_both_formats! {
    BrickSampler;
    clearances: clearances_i8, clearances_i16(points: [&[f32]; 3], margin: f32, out: &mut [f32]);
    materials: materials_i8, materials_i16(
        surfaces: [[&[f32]; 3]; 2],
        palette: &[GpuMaterial],
        out: &mut [Option<GpuMaterial>],
    );
    estimates: estimates_i8, estimates_i16(
        points: [&[f32]; 3],
        light: Option<&LevelSampler<'_, i16>>,
        lanes: &mut EstimateLanes,
        out: &mut [f32],
    );
}
