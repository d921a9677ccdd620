//! Light reads distances and materials from levels, on voxels somewhat larger than those of rays.

use super::rays::{FormatSampler, LevelRays, either};
use crate::both_formats::of_both_formats;
use crate::ray_batch::Points;
use crate::source::{ByLength, DistanceSource};
use crate::surfaces::Surfaces;
use argil_abi::{FrameUniform, GpuMaterial};
use argil_field::LANES;
use argil_volume::{LevelLanes, LevelSampler, PageRequest, Texel, VoxelSamples, is_brick};
use glam::Vec3;

/// Voxels of light, in those of rays.
const LIGHT_VOXELS: f32 = argil_abi::LIGHT_VOXELS;
/// The shortest step of a shadow's ray, in voxels of light.
const MIN_STEP_VOXELS: f32 = argil_abi::MIN_STEP_VOXELS;
/// How far above the surface light is gathered, in voxels of rays.
const LIFT_VOXELS: f32 = argil_abi::LIFT_VOXELS;

impl LevelRays<'_> {
    /// Returns the stored material at a point of the surface, given the outward direction.
    fn material(&self, point: Vec3, outward: Vec3, palette: &[GpuMaterial]) -> Option<GpuMaterial> {
        either!(self, sampler => {
            let away = point - Vec3::from(self.eye);
            let wanted = [sampler.level_of(self.size * away.length())];
            let place = [0, 1, 2].map(|axis: usize| [sampler.position(axis, away[axis])]);
            let mut lanes = LevelLanes::at(sampler.any_page());
            sampler.locate_bricks([&place[0], &place[1], &place[2]], &wanted, &mut lanes);
            sampler.material(&lanes, 0, outward, palette)
        })
    }
}

impl DistanceSource for LevelRays<'_> {
    fn materials(
        &self,
        surfaces: &Surfaces,
        palette: &[GpuMaterial],
        wanted: &mut Vec<u32>,
        out: &mut [GpuMaterial],
    ) {
        wanted.retain(|&i| {
            let i = i as usize;
            let found = self.material(surfaces.point(i), surfaces.outward(i), palette);
            found.map(|found| out[i] = found).is_none()
        });
    }

    fn measure(&self, points: &mut Points) {
        let Points { x, y, z, d, .. } = points;
        d.resize(x.len(), 0.0);
        let mut lanes = LevelLanes::at(either!(self, sampler => sampler.any_page()));
        let (mut used, mut asked) = ([0; LANES], Vec::new());
        for first in (0..x.len()).step_by(LANES) {
            let r = first..(first + LANES).min(x.len());
            let p = [&x[r.clone()], &y[r.clone()], &z[r.clone()]];
            let place = (self.eye, LIGHT_VOXELS * self.size);
            let out = &mut d[r];
            let count = out.len();
            let scratch = (&mut lanes, &mut asked);
            match &self.sampler {
                FormatSampler::Eight(s) => estimates_i8(s, place, p, scratch, out),
                FormatSampler::Sixteen(s) => estimates_i16(s, place, p, scratch, out),
            }
            used[..count].copy_from_slice(&lanes.at.index[..count]);
            self.levels().note(&used[..count], &asked);
            asked.clear();
        }
    }

    fn min_step(&self, frame: &FrameUniform) -> ByLength {
        ByLength {
            least: 2.0 * frame.epsilon,
            share: MIN_STEP_VOXELS * LIGHT_VOXELS * self.size,
        }
    }

    fn lift(&self, frame: &FrameUniform) -> ByLength {
        ByLength {
            least: frame.light_offset,
            share: LIFT_VOXELS * self.size,
        }
    }
}

/// Estimates the signed distances at points in the scene's space. `size` is the edge of a voxel at length 1.
#[inline(always)]
fn estimates<T: Texel>(
    sampler: &LevelSampler<'_, T>,
    (eye, size): ([f32; 3], f32),
    points: [&[f32]; 3],
    (lanes, asked): (&mut LevelLanes, &mut Vec<PageRequest>),
    out: &mut [f32],
) {
    let n = out.len();
    let (mut u, mut length) = ([[0.0f32; LANES]; 3], [0.0f32; LANES]);
    for axis in 0..3 {
        for i in 0..n {
            let away = points[axis][i] - eye[axis];
            u[axis][i] = sampler.position(axis, away);
            length[i] += away * away;
        }
    }
    let mut wanted = [0u32; LANES];
    for i in 0..n {
        length[i] = length[i].sqrt();
        wanted[i] = sampler.level_of(size * length[i]);
    }
    sampler.locate_bricks([&u[0][..n], &u[1][..n], &u[2][..n]], &wanted[..n], lanes);
    let mut corners = VoxelSamples::default();
    sampler.voxel_samples(&lanes.at, n, &mut corners);
    for (i, out) in out.iter_mut().enumerate() {
        *out = if is_brick(lanes.at.word[i]) {
            corners.value::<T>(i) * sampler.quantum() * lanes.voxel[i]
        } else {
            sampler.center_distance(lanes, i)
        };
        if let Some(request) = sampler.request_of(lanes, i, length[i])
            && asked.last().is_none_or(|last| last.key != request.key)
        {
            asked.push(request);
        }
    }
}

of_both_formats! {
    LevelSampler;
    estimates: estimates_i8, estimates_i16(
        place: ([f32; 3], f32),
        points: [&[f32]; 3],
        notes: (&mut LevelLanes, &mut Vec<PageRequest>),
        out: &mut [f32],
    );
}
