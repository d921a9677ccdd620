//! Samples a mesh's distances in a grid.

use super::{MeshSdf, block};
use crate::MeshReadError;
use crate::nearest::NearestSearch;
use argil_math::Control;
use argil_scene::{DistanceSampler, SampledBlock, SampledGrid};
use glam::Vec3;
use multiversion::multiversion;

impl MeshSdf {
    /// Samples the distances in a box with room around the mesh, with `resolution` samples along the mesh's longest
    /// side.
    ///
    /// # Errors
    /// If no sample is inside.
    pub fn sample(&self, resolution: u32) -> Result<SampledGrid, MeshReadError> {
        self.sample_with_control(resolution, &Control::default())
    }

    /// Samples as [`MeshSdf::sample`] does, and can be canceled. Its duration is not known in advance.
    ///
    /// # Errors
    /// If no sample is inside, or if it was canceled.
    pub fn sample_with_control(
        &self,
        resolution: u32,
        control: &Control,
    ) -> Result<SampledGrid, MeshReadError> {
        control.begin("distances to a mesh", 0);
        let spacing = self.aabb.size().max_element().max(1e-6) / resolution as f32;
        let watched = Watched {
            solid: self,
            control,
        };
        let grid = SampledGrid::sample_around(self.aabb, spacing, &watched);
        control.end();
        if control.is_cancelled() {
            return Err(MeshReadError::Cancelled);
        }
        if grid.has_inside() {
            Ok(grid)
        } else {
            Err(MeshReadError::Hollow { resolution })
        }
    }
}

/// A mesh that stops being measured once it is canceled.
struct Watched<'a> {
    solid: &'a MeshSdf,
    control: &'a Control,
}

impl DistanceSampler for Watched<'_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        if !self.control.is_cancelled() {
            DistanceSampler::distances(self.solid, points, out);
        }
    }

    fn unsigned_distances(&self, points: &[Vec3], out: &mut [f32]) {
        if self.control.is_cancelled() {
            out.fill(f32::INFINITY);
            return;
        }
        self.solid.unsigned_distances(points, out);
    }

    fn sample_block(&self, block: &SampledBlock, out: &mut [f32]) {
        if !self.control.is_cancelled() {
            DistanceSampler::sample_block(self.solid, block, out);
        }
    }
}

impl DistanceSampler for MeshSdf {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        MeshSdf::distances(self, points, out);
    }

    fn unsigned_distances(&self, points: &[Vec3], out: &mut [f32]) {
        for (&point, d) in points.iter().zip(out) {
            *d = NearestSearch::new(&self.surface.nearest).distance(point);
        }
    }

    fn sample_block(&self, block: &SampledBlock, out: &mut [f32]) {
        measure_block(self, block, out);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn measure_block(solid: &MeshSdf, block: &SampledBlock, out: &mut [f32]) {
    block::measure(solid, block, out);
}
