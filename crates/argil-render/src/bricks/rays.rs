//! Bricks of either sample format, ready to be marched.

use super::cones::ConeDistances;
use argil_abi::GpuMaterial;
use argil_field::LANES;
use argil_volume::{BrickSampler, Bricks, EstimateLanes, LevelSampler, SampleFormat};
use glam::Vec3;
use multiversion::multiversion;

/// Bricks, ready to be marched.
pub(crate) enum BrickRays<'a> {
    Eight(BrickSampler<'a, i8>, &'a Bricks),
    Sixteen(BrickSampler<'a, i16>, &'a Bricks),
}

impl<'a> BrickRays<'a> {
    pub(super) fn new(bricks: &'a Bricks) -> Option<Self> {
        match bricks.layout().encoding.format {
            SampleFormat::Snorm8 => BrickSampler::new(bricks).map(|s| Self::Eight(s, bricks)),
            SampleFormat::Snorm16 => BrickSampler::new(bricks).map(|s| Self::Sixteen(s, bricks)),
        }
    }

    /// Computes lower bounds of the signed distance around points in the scene's space. Interpolation is off by at
    /// most half of a voxel's diagonal.
    pub(super) fn clearances(&self, points: [&[f32]; 3], out: &mut [f32]) {
        let margin = 0.5 * 3f32.sqrt() * self.voxel();
        match self {
            Self::Eight(sampler, _) => clearances_i8(sampler, points, margin, out),
            Self::Sixteen(sampler, _) => clearances_i16(sampler, points, margin, out),
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
            Self::Eight(sampler, _) => estimates_i8(sampler, points, light, lanes, out),
            Self::Sixteen(sampler, _) => estimates_i16(sampler, points, light, lanes, out),
        }
    }

    /// Returns the material at a point in a brick.
    pub(super) fn look(
        &self,
        point: Vec3,
        outward: Vec3,
        palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        let (Self::Eight(_, bricks) | Self::Sixteen(_, bricks)) = self;
        bricks.material(point, outward, palette)
    }

    /// Looks up the materials of points of surfaces, and returns which are in bricks.
    pub(super) fn materials(
        &self,
        points: [&[f32]; 3],
        outward: [&[f32]; 3],
        palette: &[GpuMaterial],
        out: &mut [GpuMaterial],
    ) -> [bool; LANES] {
        match self {
            Self::Eight(sampler, _) => materials_i8(sampler, points, outward, palette, out),
            Self::Sixteen(sampler, _) => materials_i16(sampler, points, outward, palette, out),
        }
    }

    pub(super) fn voxel(&self) -> f32 {
        match self {
            Self::Eight(sampler, _) => sampler.layout().voxel_grid.voxel_size,
            Self::Sixteen(sampler, _) => sampler.layout().voxel_grid.voxel_size,
        }
    }

    pub(super) fn bounds(&self) -> argil_math::Aabb {
        match self {
            Self::Eight(sampler, _) => sampler.layout().voxel_grid.aabb(),
            Self::Sixteen(sampler, _) => sampler.layout().voxel_grid.aabb(),
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

// `multiversion` does not accept generic functions, so each sample type has a wrapper.

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn clearances_i8(
    sampler: &BrickSampler<'_, i8>,
    points: [&[f32]; 3],
    margin: f32,
    out: &mut [f32],
) {
    sampler.distances(points, margin, out);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn clearances_i16(
    sampler: &BrickSampler<'_, i16>,
    points: [&[f32]; 3],
    margin: f32,
    out: &mut [f32],
) {
    sampler.distances(points, margin, out);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn materials_i8(
    sampler: &BrickSampler<'_, i8>,
    points: [&[f32]; 3],
    outward: [&[f32]; 3],
    palette: &[GpuMaterial],
    out: &mut [GpuMaterial],
) -> [bool; LANES] {
    sampler.materials(points, outward, palette, out)
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn materials_i16(
    sampler: &BrickSampler<'_, i16>,
    points: [&[f32]; 3],
    outward: [&[f32]; 3],
    palette: &[GpuMaterial],
    out: &mut [GpuMaterial],
) -> [bool; LANES] {
    sampler.materials(points, outward, palette, out)
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn estimates_i8(
    sampler: &BrickSampler<'_, i8>,
    points: [&[f32]; 3],
    light: Option<&LevelSampler<'_, i16>>,
    lanes: &mut EstimateLanes,
    out: &mut [f32],
) {
    sampler.estimates(points, light, lanes, out);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn estimates_i16(
    sampler: &BrickSampler<'_, i16>,
    points: [&[f32]; 3],
    light: Option<&LevelSampler<'_, i16>>,
    lanes: &mut EstimateLanes,
    out: &mut [f32],
) {
    sampler.estimates(points, light, lanes, out);
}
