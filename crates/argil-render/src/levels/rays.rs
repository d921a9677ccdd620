//! Levels of either sample format, ready to be marched.

use super::notes::PageNotes;
use super::step::{clearances_i8, clearances_i16, solve_i8, solve_i16, step_i8, step_i16};
use crate::bricks::ConeDistances;
use crate::bricks::step::StepOutcome;
use crate::bricks::voxel_intersect::NearLanes;
use crate::ray_batch::RayBatch;
use argil_abi::{self as abi, FrameUniform};
use argil_math::Aabb;
use argil_volume::{
    LevelLanes, LevelSampler, Levels, NO_PAGE, PageRequest, SampleFormat, is_brick, is_page,
};
use glam::Vec3;
use std::ops::Range;

/// Voxels of cones, in those of rays.
const CONE_VOXELS: f32 = argil_abi::CONE_VOXELS;

/// Levels of either sample format.
pub(super) enum FormatSampler<'a> {
    Eight(LevelSampler<'a, i8>),
    Sixteen(LevelSampler<'a, i16>),
}

/// Levels, ready to be marched.
pub(super) struct LevelRays<'a> {
    pub(super) sampler: FormatSampler<'a>,
    pub(super) eye: [f32; 3],
    /// The edge of a voxel that a ray accepts, at length 1.
    pub(super) size: f32,
}

macro_rules! either {
    ($rays:expr, $sampler:ident => $then:expr) => {
        match &$rays.sampler {
            FormatSampler::Eight($sampler) => $then,
            FormatSampler::Sixteen($sampler) => $then,
        }
    };
}
pub(super) use either;

impl<'a> LevelRays<'a> {
    pub(super) fn new(levels: &'a Levels, frame: &FrameUniform) -> Option<Self> {
        let eye = Vec3::from(frame.eye);
        let sampler = match levels.layout().level(0).encoding().format {
            SampleFormat::Snorm8 => LevelSampler::new(levels, eye).map(FormatSampler::Eight),
            SampleFormat::Snorm16 => LevelSampler::new(levels, eye).map(FormatSampler::Sixteen),
        };
        Some(Self {
            sampler: sampler?,
            eye: frame.eye,
            size: levels.effective_pixel_error() * frame.pixel_width,
        })
    }

    pub(super) fn levels(&self) -> &'a Levels {
        either!(self, sampler => sampler.levels())
    }

    pub(super) fn any_page(&self) -> u32 {
        either!(self, sampler => sampler.any_page())
    }

    /// Returns the id of a hit in a cell for the mode that shows levels: 1 plus its level, and a bit if a finer brick
    /// is missing.
    pub(super) fn level_id(&self, cell: u32, length: f32) -> u32 {
        let levels = self.levels();
        let level = levels.pages()[cell as usize / 8].level;
        // What dithering accepts is not missing.
        let most = (1.0 + 0.5 * abi::LEVEL_DITHER) * self.size * length;
        let wanted = either!(self, sampler => sampler.level_of(most));
        let child = levels.children()[cell as usize];
        let is_brick = is_brick(levels.words()[cell as usize]);
        // A cell with finer ones is seen only where theirs are not resident.
        let is_missing = is_brick && level > wanted && (child == NO_PAGE || is_page(child));
        1 + level + if is_missing { abi::LEVEL_MISSING } else { 0 }
    }

    /// Returns the id of a cell for the mode that shows bricks: it depends on the cell's place, and not on when it was
    /// baked.
    pub(super) fn place_id(&self, cell: u32) -> u32 {
        let page = self.levels().pages()[cell as usize / 8];
        let [x, y, z] = page.origin.map(|c| c as u32);
        let place =
            x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ z.wrapping_mul(0xcb1a_b31f);
        (place ^ (8 * page.level + cell % 8).wrapping_mul(0x9e37_79b9)) | 1
    }

    /// Notes what a tile lacked.
    pub(super) fn note(&self, notes: &mut PageNotes) {
        notes.asked.sort_unstable_by(|a, b| {
            let urgency = b
                .gap
                .total_cmp(&a.gap)
                .then(a.distance.total_cmp(&b.distance));
            a.key.cmp(&b.key).then(urgency)
        });
        notes.asked.dedup_by_key(|one: &mut PageRequest| one.key);
        self.levels().note(&[], &notes.asked);
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
        let sizes = (self.size, steps);
        match &self.sampler {
            FormatSampler::Eight(s) => step_i8(s, frame, sizes, wave, range, notes, found),
            FormatSampler::Sixteen(s) => step_i16(s, frame, sizes, wave, range, notes, found),
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
        let sizes = (self.size, pixels);
        match &self.sampler {
            FormatSampler::Eight(s) => solve_i8(s, frame, sizes, lanes, notes),
            FormatSampler::Sixteen(s) => solve_i16(s, frame, sizes, lanes, notes),
        }
    }
}

/// Where the cones of a tile read distances.
pub(super) struct LevelCones<'a, 'b> {
    rays: &'a LevelRays<'b>,
    lanes: &'a mut LevelLanes,
    notes: &'a mut PageNotes,
}

impl<'a, 'b> LevelCones<'a, 'b> {
    pub(super) fn new(
        rays: &'a LevelRays<'b>,
        lanes: &'a mut LevelLanes,
        notes: &'a mut PageNotes,
    ) -> Self {
        lanes.page.fill(rays.any_page());
        Self { rays, lanes, notes }
    }
}

impl ConeDistances for LevelCones<'_, '_> {
    fn bounds(&self) -> Aabb {
        self.rays.levels().layout().level(0).voxel_grid().aabb()
    }

    fn clearances(&mut self, points: [&[f32]; 3], t: &[f32], out: &mut [f32], voxel: &mut [f32]) {
        let Self { rays, lanes, notes } = self;
        let scratch = (&mut **lanes, &mut **notes);
        let place = (rays.eye, CONE_VOXELS * rays.size);
        match &rays.sampler {
            FormatSampler::Eight(s) => clearances_i8(s, place, points, t, scratch, out),
            FormatSampler::Sixteen(s) => clearances_i16(s, place, points, t, scratch, out),
        }
        voxel.copy_from_slice(&self.lanes.voxel[..t.len()]);
    }
}
