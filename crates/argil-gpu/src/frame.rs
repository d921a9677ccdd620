//! A frame as data: its passes, recorded once for a size and a mode, and the buffers that they use, kept from frame
//! to frame.

mod encode;

use crate::bindings::{COLORS, COUNTS, FRAME, HITS, LIVE, PIXELS};
use crate::frame_extras::{DrawnFrame, FrameExtras};
use crate::frame_pipelines::{FramePasses, FramePipelines};
use crate::recording::{Destination, FrameKey, GROUP, Recording};
use crate::storage_buffer::StorageBuffer;
use crate::timing::Timing;
use crate::trace_mode::BoundResource;
use crate::{Gpu, GpuError};
use argil_abi::{FrameUniform, Hit, RECORD_BYTES};
use argil_render::{RayStatistics, RenderOutput};
use web_time::Instant;

/// The initial dispatch size: no active blocks of pixels.
const NO_BLOCKS: [u32; 4] = [0, 1, 1, 0];

/// The buffers of a frame's size.
#[derive(Debug)]
pub(crate) struct FrameBuffers {
    key: FrameKey,
    recording: Recording,
    hits: StorageBuffer,
    colors: StorageBuffer,
    live: StorageBuffer,
    counts: StorageBuffer,
    pixels: StorageBuffer,
    no_blocks: wgpu::Buffer,
    arguments: wgpu::Buffer,
    /// A [`FrameUniform`] for each dispatch.
    frames: wgpu::Buffer,
    stride: u32,
    bytes: Vec<u8>,
    timing: Option<Timing>,
    /// The image and the counts on their way to the CPU, if there are any.
    staging: Option<wgpu::Buffer>,
    /// The hits on their way to the CPU, if requested.
    hits_staging: Option<wgpu::Buffer>,
    /// What rays marked, on its way.
    marks_staging: Option<wgpu::Buffer>,
    bound: Vec<BoundResource>,
    groups: Option<[wgpu::BindGroup; 2]>,
}

impl FrameBuffers {
    pub(crate) fn new(
        gpu: &Gpu,
        key: FrameKey,
        recording: Recording,
        has_cones: bool,
    ) -> Result<Self, GpuError> {
        let pixels = key.pixels();
        let hit_bytes = key.records_per_pixel() * pixels * RECORD_BYTES;
        let table = |what, bytes| -> Result<StorageBuffer, GpuError> {
            let mut table = StorageBuffer::new(what);
            table.reserve_exact(gpu, bytes)?;
            Ok(table)
        };
        let blocks: u64 = key
            .size
            .map(|n| u64::from(n.div_ceil(GROUP)))
            .iter()
            .product();
        let count_bytes = key.count_bytes();
        let alignment = gpu.device.limits().min_uniform_buffer_offset_alignment;
        let stride = (size_of::<FrameUniform>() as u32).next_multiple_of(alignment);
        let buffer = |label, size: u64, usage| {
            gpu.with_error_scope(|| {
                gpu.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size,
                    usage,
                    mapped_at_creation: false,
                })
            })
        };
        use wgpu::BufferUsages as Usage;
        let read = Usage::MAP_READ | Usage::COPY_DST;
        let no_blocks = buffer("no blocks", 16, Usage::COPY_SRC | Usage::COPY_DST)?;
        gpu.write_buffer(&no_blocks, 0, bytemuck::bytes_of(&NO_BLOCKS));
        let bytes = vec![0; stride as usize * recording.dispatches.len().max(1)];
        Ok(Self {
            key,
            hits: table("hits", hit_bytes)?,
            colors: table("colors", 16 * pixels * key.more.color_layers())?,
            live: table(
                "blocks of pixels",
                if has_cones { 16 + 16 * blocks } else { 0 },
            )?,
            counts: table("what rays did", count_bytes)?,
            pixels: table("picture", 4 * pixels)?,
            no_blocks,
            arguments: buffer("blocks to march", 16, Usage::INDIRECT | Usage::COPY_DST)?,
            frames: gpu.with_error_scope(|| frames_of(gpu, bytes.len() as u64))?,
            stride,
            bytes,
            timing: timing_of(gpu, &key, &recording)?,
            staging: match key.staged_pixels() + count_bytes {
                0 => None,
                bytes => Some(buffer("picture on its way", bytes, read)?),
            },
            hits_staging: match key.goes {
                Destination::CpuWithHits => Some(buffer("hits on their way", hit_bytes, read)?),
                _ => None,
            },
            marks_staging: None,
            bound: Vec::new(),
            groups: None,
            recording,
        })
    }

    /// Whether the buffers fit such a frame.
    pub(crate) fn fits(&self, key: &FrameKey) -> bool {
        let current = &self.key;
        let bytes = |key: &FrameKey| {
            let layers = key.more.color_layers();
            [layers, key.records_per_pixel(), key.count_bytes()]
        };
        (current.size, current.goes) == (key.size, key.goes) && bytes(current) == bytes(key)
    }

    /// Uses the recording of another frame that fits, for example after an edit changed the length of the program.
    /// Makes room for more dispatches if needed.
    pub(crate) fn follow(
        &mut self,
        gpu: &Gpu,
        key: FrameKey,
        record: impl FnOnce() -> Recording,
    ) -> Result<(), GpuError> {
        if self.key == key {
            return Ok(());
        }
        let recording = record();
        let needed = self.stride as usize * recording.dispatches.len();
        if needed as u64 > self.frames.size() {
            self.frames = gpu.with_error_scope(|| frames_of(gpu, needed as u64))?;
            // They are bound to the old buffer.
            self.groups = None;
        }
        self.bytes.resize(needed.max(self.bytes.len()), 0);
        if recording.passes() > self.recording.passes() {
            self.timing = timing_of(gpu, &key, &recording)?;
        }
        (self.key, self.recording) = (key, recording);
        Ok(())
    }

    /// Binds what passes read, unless it is already bound.
    fn bind(
        &mut self,
        gpu: &Gpu,
        passes: &FramePasses<'_>,
        bound: Vec<BoundResource>,
    ) -> Result<(), GpuError> {
        if self.groups.is_some() && self.bound == bound {
            return Ok(());
        }
        let frame = || {
            BoundResource::Buffer(
                FRAME,
                self.frames.clone(),
                Some(size_of::<FrameUniform>() as u64),
            )
        };
        let mut all = bound.clone();
        all.push(frame());
        all.extend(self.hits.bound(HITS));
        all.extend(self.colors.bound(COLORS));
        if layout_has_blocks(&self.live) {
            all.extend(self.live.bound(LIVE));
        }
        let mut resolved = vec![frame()];
        resolved.extend(self.hits.bound(HITS));
        resolved.extend(self.colors.bound(COLORS));
        resolved.extend(self.pixels.bound(PIXELS));
        resolved.extend(self.counts.bound(COUNTS));
        let group = |label, layout, bound: &[BoundResource]| {
            let entries: Vec<_> = bound.iter().map(BoundResource::entry).collect();
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout,
                entries: &entries,
            })
        };
        self.groups = Some(gpu.with_error_scope(|| {
            [
                group("Picture", &passes.frame.layout, &all),
                group("Resolve", &passes.resolve.layout, &resolved),
            ]
        })?);
        self.bound = bound;
        Ok(())
    }

    /// Binds what passes read, and writes the values of all dispatches.
    pub(crate) fn prepare(
        &mut self,
        gpu: &Gpu,
        passes: &FramePasses<'_>,
        bound: Vec<BoundResource>,
        frames: &[FrameUniform],
    ) -> Result<(), GpuError> {
        self.bind(gpu, passes, bound)?;
        for (dispatch, bytes) in self
            .recording
            .dispatches
            .iter()
            .zip(self.bytes.chunks_exact_mut(self.stride as usize))
        {
            let frame = FrameUniform {
                max_steps: dispatch.max_steps,
                first_row: dispatch.first_row,
                first_step: dispatch.first_step,
                step_count: dispatch.step_count,
                records: self.key.records,
                ..frames[dispatch.sample]
            };
            bytes[..size_of::<FrameUniform>()].copy_from_slice(bytemuck::bytes_of(&frame));
        }
        gpu.write_buffer(&self.frames, 0, &self.bytes);
        Ok(())
    }

    /// Runs a frame and downloads it. Returns the image, and the duration of its passes.
    pub(crate) async fn run(
        &mut self,
        gpu: &Gpu,
        passes: FramePasses<'_>,
        bound: Vec<BoundResource>,
        extras: FrameExtras<'_>,
        frames: &[FrameUniform],
    ) -> Result<DrawnFrame, GpuError> {
        self.reserve_marks(gpu, extras.marks)?;
        if let Some(timing) = &mut self.timing {
            timing.restart();
        }
        let pipelines = FramePipelines::of(gpu, &passes, &self.recording)?;
        let kept = self.bind_textures(gpu, &passes, extras)?;
        let start = Instant::now();
        self.prepare(gpu, &passes, bound, frames)?;
        gpu.with_error_scope(|| {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            self.encode(gpu, &pipelines, extras, kept.as_ref(), &mut encoder);
            self.copy_to_staging(&mut encoder, extras);
            gpu.submit(encoder);
        })?;
        let duration_ms = match &self.timing {
            Some(timing) => timing.durations_ms(gpu).await?.iter().sum(),
            None => {
                gpu.wait().await?;
                start.elapsed().as_secs_f64() * 1e3
            }
        };
        let picture = self.bring(gpu).await?;
        let mut marks = Vec::new();
        if let (Some(_), Some(staging)) = (extras.marks, &self.marks_staging) {
            gpu.take_staged(staging.slice(..), |bytes| marks.extend_from_slice(bytes))
                .await?;
        }
        Ok(DrawnFrame {
            picture,
            duration_ms,
            marks,
        })
    }

    /// Binds the textures that the image goes to, if it does.
    fn bind_textures(
        &self,
        gpu: &Gpu,
        passes: &FramePasses<'_>,
        extras: FrameExtras<'_>,
    ) -> Result<Option<wgpu::BindGroup>, GpuError> {
        let Some(textures) = extras.textures() else {
            return Ok(None);
        };
        let (image, textures_size) = (self.key.size, textures.size());
        if image != textures_size {
            return Err(GpuError::OtherSize {
                image,
                textures: textures_size,
            });
        }
        let (Some(hits), Some(pixels)) = (self.hits.buffer(), self.pixels.buffer()) else {
            return Ok(None);
        };
        let buffers = [&self.frames, hits, pixels];
        gpu.with_error_scope(|| Some(textures.bind(gpu, passes.textures, buffers)))
    }

    /// Makes room to download what rays mark.
    fn reserve_marks(&mut self, gpu: &Gpu, marks: Option<&StorageBuffer>) -> Result<(), GpuError> {
        let Some(bytes) = marks.map(StorageBuffer::used) else {
            return Ok(());
        };
        let fits = |staging: &wgpu::Buffer| staging.size() == bytes;
        if !self.marks_staging.as_ref().is_some_and(fits) {
            let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
            let buffer = gpu.with_error_scope(|| {
                gpu.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("marks on their way"),
                    size: bytes,
                    usage,
                    mapped_at_creation: false,
                })
            })?;
            self.marks_staging = Some(buffer);
        }
        Ok(())
    }

    pub(crate) fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Returns the hits, the colors and the frames, for who draws them elsewhere.
    pub(crate) fn results(&self) -> [Option<&wgpu::Buffer>; 3] {
        [self.hits.buffer(), self.colors.buffer(), Some(&self.frames)]
    }

    /// Copies the pixels, the counts and the marks to staging buffers.
    fn copy_to_staging(&self, encoder: &mut wgpu::CommandEncoder, extras: FrameExtras<'_>) {
        let marks = extras.marks.and_then(StorageBuffer::buffer);
        if let (Some(marks), Some(staging)) = (marks, &self.marks_staging) {
            encoder.copy_buffer_to_buffer(marks, 0, staging, 0, staging.size());
        }
        let Some(staging) = &self.staging else { return };
        let first = self.key.staged_pixels();
        if let Some(pixels) = self.pixels.buffer().filter(|_| first > 0) {
            encoder.copy_buffer_to_buffer(pixels, 0, staging, 0, first);
        }
        let rest = staging.size() - first;
        if let Some(counts) = self.counts.buffer().filter(|_| rest > 0) {
            encoder.copy_buffer_to_buffer(counts, 0, staging, first, rest);
        }
    }

    /// Returns the buffers that are kept from frame to frame.
    #[cfg(test)]
    pub(crate) fn buffers(&self) -> Vec<wgpu::Buffer> {
        let tables = [&self.hits, &self.colors, &self.counts, &self.pixels];
        let tables = tables.into_iter().filter_map(StorageBuffer::buffer);
        tables
            .chain([&self.frames])
            .chain(&self.staging)
            .cloned()
            .collect()
    }

    async fn bring(&self, gpu: &Gpu) -> Result<RenderOutput, GpuError> {
        let (pixels, bins) = (self.key.pixels(), self.key.bins() as usize);
        let (mut rgb, mut hit_pixels) = (Vec::with_capacity(self.key.staged_pixels() as usize), 0);
        let mut histograms: Vec<u32> = Vec::new();
        if let Some(staging) = &self.staging {
            gpu.take_staged(staging.slice(..), |bytes| {
                let (picture, counts) = bytes.split_at(self.key.staged_pixels() as usize);
                for &[r, g, b, is_hit] in picture.as_chunks::<4>().0 {
                    rgb.extend([r, g, b]);
                    hit_pixels += usize::from(is_hit);
                }
                let words = counts.as_chunks::<4>().0;
                histograms.extend(words.iter().map(|&word| u32::from_le_bytes(word)));
            })
            .await?;
        }
        let mut hits = Vec::new();
        if let Some(staging) = &self.hits_staging {
            gpu.take_staged(staging.slice(..), |bytes| {
                let records = bytes.as_chunks::<{ RECORD_BYTES as usize }>().0;
                let record = |bytes| bytemuck::pod_read_unaligned::<[u32; 4]>(bytes);
                let first = records.len() - pixels as usize;
                let each = records.iter().zip(&records[first..]).take(pixels as usize);
                hits.extend(
                    each.map(|(surface, counts)| {
                        Hit::from_records(record(surface), record(counts))
                    }),
                );
            })
            .await?;
        }
        let mut each = histograms.chunks_exact(bins);
        let histograms = std::array::from_fn(|_| each.next().unwrap_or_default());
        let statistics = RayStatistics::of_histograms(pixels, histograms);
        Ok(RenderOutput {
            size: self.key.size,
            rgb,
            hits,
            statistics: self.key.has_statistics.then_some(statistics),
            hit_pixels,
        })
    }
}

/// Returns what takes the time of passes, unless a host submits them.
fn timing_of(gpu: &Gpu, key: &FrameKey, recording: &Recording) -> Result<Option<Timing>, GpuError> {
    match key.goes {
        Destination::Host => Ok(None),
        _ => Timing::new(gpu, recording.passes()),
    }
}

/// Creates a buffer of `size` bytes for the [`FrameUniform`] of each dispatch.
fn frames_of(gpu: &Gpu, size: u64) -> wgpu::Buffer {
    gpu.create_buffer(&wgpu::BufferDescriptor {
        label: Some("frames"),
        size,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Whether there are blocks of pixels. An empty table has the minimum size.
fn layout_has_blocks(live: &StorageBuffer) -> bool {
    live.used() > 16
}
