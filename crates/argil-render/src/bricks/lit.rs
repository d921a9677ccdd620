//! Bricks whose light reads the distances that they do not store from coarse levels.

use super::rays::BrickRays;
use super::trace_bricks;
use crate::probe::FieldProbe;
use crate::ray_batch::Points;
use crate::source::{DistanceSource, RayTracer, RenderSource};
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use argil_abi::{FrameUniform, GpuMaterial, Hit};
use argil_field::LANES;
use argil_volume::{Bricks, LevelLanes, LevelSampler, Levels};
use glam::Vec3;

/// Sparse bricks, and the levels that light reads.
#[derive(Clone, Copy, Debug)]
pub struct LitBricks<'a> {
    /// What rays march through.
    pub bricks: &'a Bricks,
    /// Coarse levels of the same scene.
    pub light: &'a Levels,
}

/// Bricks and light, ready to be marched.
struct LitRays<'a> {
    rays: BrickRays<'a>,
    light: Option<LevelSampler<'a, i16>>,
}

impl RenderSource for Bricks {
    fn tracer<'a>(&'a self, _: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        let rays = BrickRays::new(self)?;
        Some(Box::new(LitRays { rays, light: None }))
    }
}

impl RenderSource for LitBricks<'_> {
    fn tracer<'a>(&'a self, _: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        Some(Box::new(LitRays {
            rays: BrickRays::new(self.bricks)?,
            light: Some(LevelSampler::new(self.light, Vec3::ZERO)?),
        }))
    }
}

impl RayTracer for LitRays<'_> {
    fn needs_field(&self, _: u32) -> bool {
        false
    }

    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        probe: &mut FieldProbe<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    ) {
        trace_bricks(frame, tile, &self.rays, probe, scratch, out);
    }

    fn distance_source(&self) -> Option<&dyn DistanceSource> {
        Some(self)
    }
}

impl DistanceSource for LitRays<'_> {
    fn material(&self, point: Vec3, outward: Vec3, palette: &[GpuMaterial]) -> Option<GpuMaterial> {
        self.rays.look(point, outward, palette)
    }

    fn measure(&self, points: &mut Points) {
        let Points { x, y, z, d } = points;
        d.resize(x.len(), 0.0);
        let first_page = self.light.as_ref().map_or(0, LevelSampler::any_page);
        let mut lanes = LevelLanes::at(first_page);
        for first in (0..x.len()).step_by(LANES) {
            let r = first..(first + LANES).min(x.len());
            let p = [&x[r.clone()], &y[r.clone()], &z[r.clone()]];
            let light = self.light.as_ref().map(|light| (light, &mut lanes));
            self.rays.estimates(p, light, &mut d[r]);
        }
    }
}
