//! Levels of either sample format, ready to be marched.

use super::notes::PageNotes;
use super::step::{clearances_i8, clearances_i16, solve_i8, solve_i16, step_i8, step_i16};
use crate::bricks::ConeDistances;
use crate::bricks::step::StepOutcome;
use crate::bricks::voxel_intersect::NearLanes;
use crate::ray_batch::RayBatch;
use argil_abi::FrameUniform;
use argil_math::Aabb;
use argil_volume::{LevelLanes, LevelSampler, Levels, PageRequest, SampleFormat};
use glam::Vec3;
use std::ops::Range;

/// Voxels of cones, in those of rays.
const CONE_VOXELS: f32 = 2.0;

/// Levels, ready to be marched.
pub(super) enum LevelRays<'a> {
    Eight(LevelSampler<'a, i8>),
    Sixteen(LevelSampler<'a, i16>),
}

macro_rules! either {
    ($rays:expr, $sampler:ident => $then:expr) => {
        match $rays {
            LevelRays::Eight($sampler) => $then,
            LevelRays::Sixteen($sampler) => $then,
        }
    };
}

impl<'a> LevelRays<'a> {
    pub(super) fn new(levels: &'a Levels, frame: &FrameUniform) -> Option<Self> {
        let eye = Vec3::from_slice(&frame.eye[..3]);
        match levels.layout().level(0).encoding.format {
            SampleFormat::Snorm8 => LevelSampler::new(levels, eye).map(Self::Eight),
            SampleFormat::Snorm16 => LevelSampler::new(levels, eye).map(Self::Sixteen),
        }
    }

    fn levels(&self) -> &'a Levels {
        either!(self, sampler => sampler.levels())
    }

    pub(super) fn any_page(&self) -> u32 {
        either!(self, sampler => sampler.any_page())
    }

    /// Notes what a tile used and lacked.
    pub(super) fn note(&self, notes: &mut PageNotes) {
        notes.used.sort_unstable();
        notes.used.dedup();
        notes.asked.sort_unstable_by(|a, b| {
            let urgency = b
                .gap
                .total_cmp(&a.gap)
                .then(a.distance.total_cmp(&b.distance));
            a.key.cmp(&b.key).then(urgency)
        });
        notes.asked.dedup_by_key(|one: &mut PageRequest| one.key);
        self.levels().note(&notes.used, &notes.asked);
        self.levels().count_hits(notes.hits, notes.coarse);
        (notes.hits, notes.coarse) = (0, 0);
    }

    /// Takes one step of a batch of rays.
    pub(super) fn step(
        &self,
        frame: &FrameUniform,
        steps: u32,
        wave: &mut RayBatch,
        range: Range<usize>,
        notes: (&mut LevelLanes, &mut PageNotes),
        found: &mut StepOutcome,
    ) {
        let size = self.levels().effective_pixel_error() * frame.pixel_width;
        match self {
            Self::Eight(s) => step_i8(s, frame, (size, steps), wave, range, notes, found),
            Self::Sixteen(s) => step_i16(s, frame, (size, steps), wave, range, notes, found),
        }
    }

    /// Intersects rays near the surface with it in their voxels.
    pub(super) fn solve(
        &self,
        frame: &FrameUniform,
        pixels: &[u32],
        lanes: &mut NearLanes,
        notes: (&mut LevelLanes, &mut PageNotes),
    ) {
        let size = self.levels().effective_pixel_error() * frame.pixel_width;
        match self {
            Self::Eight(s) => solve_i8(s, frame, (size, pixels), lanes, notes),
            Self::Sixteen(s) => solve_i16(s, frame, (size, pixels), lanes, notes),
        }
    }
}

/// Where the cones of a tile read distances.
pub(super) struct LevelCones<'a, 'b> {
    rays: &'a LevelRays<'b>,
    eye: [f32; 3],
    /// The edge of a voxel, at length 1.
    size: f32,
    lanes: &'a mut LevelLanes,
    notes: &'a mut PageNotes,
}

impl<'a, 'b> LevelCones<'a, 'b> {
    pub(super) fn new(
        frame: &FrameUniform,
        rays: &'a LevelRays<'b>,
        lanes: &'a mut LevelLanes,
        notes: &'a mut PageNotes,
    ) -> Self {
        lanes.page.fill(rays.any_page());
        Self {
            rays,
            eye: [frame.eye[0], frame.eye[1], frame.eye[2]],
            size: CONE_VOXELS * rays.levels().effective_pixel_error() * frame.pixel_width,
            lanes,
            notes,
        }
    }
}

impl ConeDistances for LevelCones<'_, '_> {
    fn bounds(&self) -> Aabb {
        self.rays.levels().layout().level(0).voxel_grid.aabb()
    }

    fn clearances(&mut self, points: [&[f32]; 3], t: &[f32], out: &mut [f32], voxel: &mut [f32]) {
        let Self {
            rays,
            eye,
            size,
            lanes,
            notes,
        } = self;
        let own = (&mut **lanes, &mut **notes);
        match rays {
            LevelRays::Eight(s) => clearances_i8(s, (*eye, *size), points, t, own, out),
            LevelRays::Sixteen(s) => clearances_i16(s, (*eye, *size), points, t, own, out),
        }
        voxel.copy_from_slice(&self.lanes.voxel[..t.len()]);
    }
}
