//! Bricks whose light reads the distances that they do not store from coarse levels.

use super::rays::BrickRays;
use super::trace_bricks;
use crate::probe::FieldProbe;
use crate::ray_batch::Points;
use crate::source::{DistanceSource, RayTracer, RenderSource};
use crate::surfaces::Surfaces;
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use argil_abi::{FrameUniform, GpuMaterial, Hit};
use argil_field::LANES;
use argil_volume::{Bricks, EstimateLanes, LevelSampler, Levels};
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
            light: Some(LevelSampler::new(self.light, Vec3::ZERO)?.with_starts()),
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
    fn materials(
        &self,
        surfaces: &Surfaces,
        palette: &[GpuMaterial],
        wanted: &mut Vec<u32>,
        out: &mut [GpuMaterial],
    ) {
        let mut kept = 0;
        for first in (0..wanted.len()).step_by(LANES) {
            let n = LANES.min(wanted.len() - first);
            let mut lanes = [[[0.0; LANES]; 3]; 2];
            for (lane, &i) in wanted[first..first + n].iter().enumerate() {
                let (p, outward) = (surfaces.point(i as usize), surfaces.outward(i as usize));
                for axis in 0..3 {
                    (lanes[0][axis][lane], lanes[1][axis][lane]) = (p[axis], outward[axis]);
                }
            }
            let mut found = [None; LANES];
            let of = lanes
                .each_ref()
                .map(|group| group.each_ref().map(|lane| &lane[..n]));
            self.rays.materials(of, palette, &mut found[..n]);
            for (lane, found) in found[..n].iter().enumerate() {
                let i = wanted[first + lane];
                match found {
                    Some(found) => out[i as usize] = *found,
                    None => {
                        wanted[kept] = i;
                        kept += 1;
                    }
                }
            }
        }
        wanted.truncate(kept);
    }

    fn measure(&self, points: &mut Points) {
        let Points { x, y, z, d, source } = points;
        d.resize(x.len(), 0.0);
        let lanes: &mut EstimateLanes = source.of();
        for first in (0..x.len()).step_by(LANES) {
            let r = first..(first + LANES).min(x.len());
            let p = [&x[r.clone()], &y[r.clone()], &z[r.clone()]];
            self.rays
                .estimates(p, self.light.as_ref(), lanes, &mut d[r]);
        }
    }
}
