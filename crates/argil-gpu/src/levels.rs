//! Levels of detail on the device.
//!
//! The CPU bakes pages, and the device has a copy of all of them. Rays mark in a table what they used and what they
//! lacked (`feedback.rs`). The table comes to the CPU with the frame's picture. What the CPU then baked or evicted is
//! uploaded, brick by brick (`pool.rs`) and record by record (`tables.rs`). So the device marches through what the CPU
//! has.

mod feedback;
mod pool;
mod tables;

use self::feedback::{FrameSight, feedback_bytes, note};
pub(crate) use self::pool::{LevelPool, packed};
use self::tables::LevelTables;
use crate::bindings::{
    Bind, CELLS, FEEDBACK, FEEDBACK_WGSL, LEVELS_WGSL, LINEAR, LIVE, LIVE_WGSL, STORED, VOLUME,
    VOLUME_WGSL,
};
use crate::program::GpuProgram;
use crate::storage_buffer::StorageBuffer;
use crate::trace_mode::{BoundResource, HostMode, TraceMode};
use crate::volume::{EditContext, GpuVolume, Upload, VolumeStorage, VolumeTables};
use crate::work::Work;
use crate::{Gpu, GpuError};
use argil_abi::{FrameUniform, LevelsUniform};
use argil_volume::{
    EditStats, Levels, LevelsPendingEdits, PendingEdits, Volume, VolumeInfo, VolumeKind,
    split_position, wgsl,
};
use glam::Vec3;
use std::borrow::Cow;
use web_time::Instant;

const UNIFORM_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: LevelsUniform;
";

pub(crate) static LEVELS: TraceMode = TraceMode {
    name: "levels",
    more_name: "levels with more light",
    march: argil_render::wgsl::LEVELS,
    tables: || {
        [
            UNIFORM_WGSL,
            VOLUME_WGSL,
            LEVELS_WGSL,
            FEEDBACK_WGSL,
            LIVE_WGSL,
            wgsl::BRICK_MATERIALS,
        ]
        .concat()
    },
    binds: &[
        Bind::Uniform(VOLUME),
        Bind::Texture(STORED),
        Bind::Filter(LINEAR),
        Bind::Read(CELLS),
        Bind::Write(FEEDBACK),
        Bind::Write(LIVE),
    ],
    constants: &[],
    draws: false,
    is_exact: false,
    paths: None,
    host: Some(&LEVEL_HOST),
    has_cones: true,
    by_lists: false,
};

/// Shaders of a host ask for no pages, so they write nothing.
static LEVEL_HOST: HostMode = HostMode {
    tables: || {
        [
            UNIFORM_WGSL,
            VOLUME_WGSL,
            LEVELS_WGSL,
            wgsl::BRICK_MATERIALS,
        ]
        .concat()
    },
    wgsl: argil_render::wgsl::LEVEL_HOST,
    binds: &[
        Bind::Uniform(VOLUME),
        Bind::Texture(STORED),
        Bind::Read(CELLS),
    ],
};

/// Levels on the CPU, and their copy on the device.
#[derive(Debug)]
struct GpuLevels {
    levels: Levels,
    tables: LevelTables,
    pool: LevelPool,
    /// What the rays of a frame used and lacked.
    feedback: StorageBuffer,
    edited: EditStats,
}

impl GpuLevels {
    /// Uploads what changed since the last call.
    fn upload_changes(&mut self, body: &mut VolumeStorage, gpu: &Gpu) -> Result<(), GpuError> {
        let changed = self.levels.take_changes();
        if let Some(texture) = self.pool.reserve(gpu, &self.levels, &body.texture)? {
            body.set_texture(texture);
        }
        self.tables
            .update(gpu, &self.levels, &changed, self.pool.size())?;
        self.feedback
            .reserve(gpu, feedback_bytes(self.levels.pages().len()))?;
        self.pool.upload(gpu, &self.levels, &changed, &body.texture)
    }
}

impl VolumeTables for GpuLevels {
    fn way(&self) -> &'static TraceMode {
        &LEVELS
    }

    fn bind(&self, bound: &mut Vec<BoundResource>) {
        bound.extend(self.tables.buffer.bound(CELLS));
        bound.extend(self.feedback.bound(FEEDBACK));
    }

    fn memory_bytes(&self, body: &VolumeStorage) -> u64 {
        let bricks: u64 = self.pool.size().map(u64::from).iter().product();
        bricks * 729 * body.texel_bytes() + self.tables.buffer.size() + self.feedback.size()
    }

    fn info<'a>(&'a self, mut info: VolumeInfo, _: &'a Gpu) -> Work<'a, VolumeInfo> {
        let known = self.levels.info();
        (info.levels, info.bricks) = (known.levels, known.bricks);
        Box::pin(async move { Ok(info) })
    }

    fn read<'a>(&'a self, body: &'a VolumeStorage, gpu: &'a Gpu) -> Work<'a, Volume> {
        Box::pin(async move {
            let [words, children] = self
                .tables
                .read(gpu, &self.levels, self.pool.size())
                .await?;
            let pool = self.pool.read(gpu, &self.levels, &body.texture).await?;
            let copy = self.levels.with_contents(words, children, pool);
            let copy = copy.ok_or_else(|| GpuError::Lost("some pages are missing".into()))?;
            Ok(Volume::Levels(copy))
        })
    }

    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        VolumeKind::edits(&self.levels)
    }

    fn grow(&mut self, body: &mut VolumeStorage, edits: &dyn PendingEdits) {
        VolumeKind::grow(&mut self.levels, edits);
        body.voxel_grid = *self.levels.voxel_grid();
    }

    fn edit<'a>(&'a mut self, body: &'a mut VolumeStorage, edit: EditContext<'a>) -> Work<'a, ()> {
        Box::pin(async move {
            let Some(edits) = LevelsPendingEdits::downcast_mut(edit.edits) else {
                return Ok(());
            };
            // The CPU bakes pages.
            let until = edit.within.map(|within| Instant::now() + within);
            let done = VolumeKind::edit(&mut self.levels, edit.incremental, edits, None, until);
            // What a failed edit left is uploaded too.
            self.upload_changes(body, edit.field.gpu())?;
            self.edited += done?;
            Ok(())
        })
    }

    fn wait_for_counters<'a>(&'a mut self, _: &'a Gpu) -> Work<'a, EditStats> {
        Box::pin(async move { Ok(std::mem::take(&mut self.edited)) })
    }

    fn uniform(&self, frame: &FrameUniform) -> Cow<'_, [u8]> {
        let uniform = self.describe(frame);
        Cow::Owned(bytemuck::bytes_of(&uniform).to_vec())
    }

    fn marks(&self) -> Option<&StorageBuffer> {
        Some(&self.feedback)
    }

    fn note_marks(&self, frame: &FrameUniform, marks: &[u8]) {
        let sight = FrameSight {
            eye: Vec3::from(frame.eye),
            size: self.levels.effective_pixel_error() * frame.pixel_width,
        };
        note(&self.levels, sight, marks);
    }

    fn levels(&self) -> Option<&Levels> {
        Some(&self.levels)
    }

    fn levels_mut(&mut self) -> Option<&mut Levels> {
        Some(&mut self.levels)
    }

    fn follow_levels(&mut self, body: &mut VolumeStorage, gpu: &Gpu) -> Result<(), GpuError> {
        self.upload_changes(body, gpu)
    }
}

impl GpuLevels {
    /// Returns the uniform for rays from a frame's camera.
    fn describe(&self, frame: &FrameUniform) -> LevelsUniform {
        let layout = self.levels.layout();
        let finest = layout.level(0);
        let grid = &finest.voxel_grid();
        let (eye, inner) = split_position(grid, Vec3::from(frame.eye));
        let (low, size, _) = self.levels.roots();
        let [pool_x, pool_y, _] = self.pool.size();
        let (first, last) = self.levels.voxel_range();
        let steepness = 1.000_01 * self.levels.lipschitz();
        let at = self.tables.places();
        LevelsUniform {
            eye_inner: inner.to_array(),
            voxel_size: grid.voxel_size,
            band_voxels: finest.encoding().band_width(grid, 0) / grid.voxel_size,
            box_min: grid.aabb().min.to_array(),
            error_voxels: 0.5 * 3f32.sqrt() * steepness,
            box_max: grid.aabb().max.to_array(),
            steepness,
            eye_x: eye.x,
            eye_y: eye.y,
            eye_z: eye.z,
            root: layout.root(),
            first_x: first.x,
            first_y: first.y,
            first_z: first.z,
            last_x: last.x,
            last_y: last.y,
            last_z: last.z,
            records_at: at.records,
            root_x: low.x,
            root_y: low.y,
            root_z: low.z,
            materials_at: at.materials,
            roots_x: size.x as u32,
            roots_y: size.y as u32,
            roots_z: size.z as u32,
            mixed_at: at.mixed,
            pool_x,
            pool_y,
            pixel_error: self.levels.effective_pixel_error(),
            pad0: 0,
        }
    }
}

impl Upload for Levels {
    fn upload<'a>(&'a self, field: &'a GpuProgram) -> Work<'a, GpuVolume> {
        Box::pin(async move {
            let gpu = field.gpu();
            let mut levels = self.clone();
            levels.mark_all_changed();
            let (pool, texture) = LevelPool::new(gpu, &levels)?;
            let levels_on_gpu = GpuLevels {
                tables: LevelTables::default(),
                pool,
                feedback: StorageBuffer::new("requests of rays"),
                edited: EditStats::default(),
                levels,
            };
            let finest = levels_on_gpu.levels.layout().level(0);
            let mut volume = GpuVolume::new(
                field,
                (*finest.voxel_grid(), *finest.encoding()),
                texture,
                levels_on_gpu,
            )?;
            volume.follow_levels(gpu)?;
            Ok(volume)
        })
    }
}
