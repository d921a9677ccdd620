//! Frames in the encoder and the targets of a host that has its own renderer.

use crate::bindings::{Bind, FRAME, HITS, layout_for};
use crate::frame::FrameBuffers;
use crate::frame_extras::FrameExtras;
use crate::frame_pipelines::FramePipelines;
use crate::host_motion::HostMotion;
use crate::host_targets::HostTargets;
use crate::recording::Destination;
use crate::render::RenderPasses;
use crate::trace_mode::BoundResource;
use crate::{Gpu, GpuError, GpuProgram, GpuVolume, ImageOutput};
use argil_abi::FrameUniform;
use argil_field::BrushMotion;
use std::sync::Arc;

/// What the draw binds.
const BINDS: [Bind; 5] = [
    Bind::Uniform(0),
    Bind::Uniform(1),
    Bind::Read(2),
    Bind::Read(3),
    Bind::Read(4),
];

/// What the shader reads besides the frame.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct HostView {
    clip_from_world: [[f32; 4]; 4],
    before: [[f32; 4]; 4],
    takes_linear: u32,
    has_linear: u32,
    has_moved: u32,
    padding: u32,
}

/// What a frame of a host shows.
#[derive(Clone, Copy, Debug)]
pub struct HostSight<'a> {
    /// One for each sample.
    pub frames: &'a [FrameUniform],
    /// The projection times the view, by columns.
    pub clip_from_world: [[f32; 4]; 4],
    /// Brushes that moved since the frame before.
    pub motion: Option<&'a BrushMotion>,
    /// The scene, and the number of its changes.
    pub state: (u64, usize),
}

/// A frame of a host, whose buffers are kept from one to the next: one for each view.
///
/// It is encoded, and then drawn in a render pass of the same submission.
#[derive(Debug)]
pub struct HostFrame {
    takes_linear: bool,
    /// Whether what is nearer has a greater depth.
    is_reversed: bool,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    /// The matrix of the frame before.
    before: Option<[[f32; 4]; 4]>,
    /// The ways of points, if there is a target for motion.
    motion: Option<HostMotion>,
    /// The scene and the number of its changes that the frame before showed.
    shown: Option<(u64, usize)>,
    /// The uniform of the volume, which belongs to the view: those of levels differ.
    volume: Option<wgpu::Buffer>,
    /// The buffers, and the passes that they are for.
    buffers: Option<(FrameBuffers, Arc<RenderPasses>)>,
    /// What is drawn, with the buffers that it reads.
    drawn: Option<(wgpu::BindGroup, [wgpu::Buffer; 4])>,
}

impl HostFrame {
    /// Compiles what draws into some targets.
    ///
    /// # Errors
    /// If the device refuses a target, for example a color format that cannot be drawn to.
    pub fn new(gpu: &Gpu, targets: &HostTargets) -> Result<Self, GpuError> {
        let (layout, pipeline, view) = gpu.with_error_scope(|| {
            let layout = layout_for(gpu, "HostFrame", wgpu::ShaderStages::FRAGMENT, &BINDS);
            let pipeline = targets.pipeline(gpu, &layout);
            let view = gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("view of the host"),
                size: size_of::<HostView>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            (layout, pipeline, view)
        })?;
        Ok(Self {
            takes_linear: targets.takes_linear(),
            is_reversed: targets.is_reversed(),
            layout,
            pipeline,
            view,
            before: None,
            motion: targets.motion.map(|_| HostMotion::new()),
            shown: None,
            volume: None,
            buffers: None,
            drawn: None,
        })
    }

    /// Whether what is nearer has a greater depth, by the comparison of the depth buffer.
    pub fn is_reversed(&self) -> bool {
        self.is_reversed
    }

    /// Returns [`HostSight::state`] of the frame before, if there is a target for motion.
    pub fn shown(&self) -> Option<(u64, usize)> {
        self.shown.filter(|_| self.motion.is_some())
    }

    /// Draws the frame that was encoded last into a pass with the targets. Does nothing if there is none.
    pub fn composite(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some((group, _)) = &self.drawn {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// Encodes a frame through the field.
    ///
    /// # Errors
    /// If the device cannot evaluate the program, or the image exceeds its memory.
    pub fn encode_field(
        &mut self,
        field: &GpuProgram,
        sight: HostSight<'_>,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), GpuError> {
        let Some(first) = sight.frames.first() else {
            return Ok(());
        };
        let (way, bound) = field.field_way(Some(encoder))?;
        let passes = field.picture(way, first)?;
        self.encode(field, (passes, bound), (first, sight), encoder)
    }

    /// Encodes a frame through a volume of the same device.
    ///
    /// # Errors
    /// If the image exceeds the device's memory.
    pub fn encode_volume(
        &mut self,
        field: &GpuProgram,
        volume: &GpuVolume,
        sight: HostSight<'_>,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), GpuError> {
        let Some(first) = sight.frames.first() else {
            return Ok(());
        };
        let gpu = field.gpu();
        let bytes = volume.uniform().size();
        let uniform = match self.volume.take().filter(|buffer| buffer.size() == bytes) {
            Some(buffer) => buffer,
            None => gpu.with_error_scope(|| {
                gpu.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("volume of a view"),
                    size: bytes,
                    usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            })?,
        };
        let (passes, bound) = volume.picture(field, first, &uniform)?;
        self.volume = Some(uniform);
        self.encode(field, (passes, bound), (first, sight), encoder)
    }

    fn write_view(&mut self, gpu: &Gpu, frame: &FrameUniform, sight: &HostSight<'_>) {
        let clip_from_world = sight.clip_from_world;
        self.shown = Some(sight.state);
        let view = HostView {
            clip_from_world,
            before: self
                .before
                .replace(clip_from_world)
                .unwrap_or(clip_from_world),
            takes_linear: self.takes_linear.into(),
            has_linear: (frame.mode == argil_abi::MODE_SHADED).into(),
            has_moved: (self.motion.is_some() && sight.motion.is_some()).into(),
            padding: 0,
        };
        gpu.write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
    }

    fn encode(
        &mut self,
        field: &GpuProgram,
        (of_mode, bound): (Arc<RenderPasses>, Vec<BoundResource>),
        (first, sight): (&FrameUniform, HostSight<'_>),
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), GpuError> {
        let gpu = field.gpu();
        self.write_view(gpu, first, &sight);
        let frames = sight.frames;
        let kept = self.buffers.take();
        // Another world has other passes.
        let kept = kept.filter(|(_, mode)| Arc::ptr_eq(mode, &of_mode));
        let kept = kept.map(|(buffers, _)| buffers);
        let mut buffers = of_mode.target(field, frames, Destination::Host, kept)?;
        let [resolve, textures] = field.last_passes()?;
        let passes = of_mode.with(&resolve, &textures);
        let bound = field.bound().chain(bound).collect();
        buffers.prepare(gpu, &passes, bound, frames)?;
        let pipelines = FramePipelines::of(gpu, &passes, buffers.recording())?;
        let extras = FrameExtras::of(ImageOutput::Cpu);
        buffers.encode(gpu, &pipelines, extras, None, encoder);
        let [Some(hits), Some(colors), Some(frames)] = buffers.results().map(Option::<&_>::cloned)
        else {
            return Err(GpuError::Lost("no buffer".into()));
        };
        let mut ways = None;
        if let Some(host_motion) = &mut self.motion {
            let size = [first.width, first.height];
            ways = host_motion.reserve(field, size)?.cloned();
            if let Some(motion) = sight.motion {
                let bytes = size_of::<FrameUniform>() as u64;
                let frames = BoundResource::Buffer(FRAME, frames.clone(), Some(bytes));
                let hits = BoundResource::buffer(HITS, &hits);
                host_motion.encode(field, motion, (frames, hits, size), encoder)?;
            }
        }
        // Without ways, something is bound that nobody reads.
        let ways = ways.unwrap_or_else(|| colors.clone());
        let read = [frames, hits, colors, ways];
        if self.drawn.as_ref().is_none_or(|(_, drawn)| *drawn != read) {
            let group = gpu.with_error_scope(|| self.group(gpu, &read))?;
            self.drawn = Some((group, read));
        }
        self.buffers = Some((buffers, of_mode));
        gpu.fault().map_or(Ok(()), Err)
    }

    fn group(
        &self,
        gpu: &Gpu,
        [frames, hits, colors, ways]: &[wgpu::Buffer; 4],
    ) -> wgpu::BindGroup {
        let frame = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: frames,
            offset: 0,
            size: std::num::NonZeroU64::new(size_of::<FrameUniform>() as u64),
        });
        let all = [
            frame,
            self.view.as_entire_binding(),
            hits.as_entire_binding(),
            colors.as_entire_binding(),
            ways.as_entire_binding(),
        ];
        let entries: Vec<_> = (0..)
            .zip(all)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("HostFrame"),
            layout: &self.layout,
            entries: &entries,
        })
    }
}
