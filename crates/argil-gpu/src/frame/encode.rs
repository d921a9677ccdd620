//! A frame's passes in an encoder.

use super::FrameBuffers;
use crate::Gpu;
use crate::frame_extras::FrameExtras;
use crate::frame_pipelines::FramePipelines;
use crate::recording::{FrameStep, GROUP};
use crate::storage_buffer::StorageBuffer;
use crate::timing::Timing;

impl FrameBuffers {
    /// Encodes the passes. Where too much work would be submitted at once, and without a host, the encoder is replaced.
    pub(crate) fn encode(
        &mut self,
        gpu: &Gpu,
        pipelines: &FramePipelines<'_>,
        extras: FrameExtras<'_>,
        kept: Option<&wgpu::BindGroup>,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        let Some([frame_group, resolving]) = &self.groups else {
            return;
        };
        let [columns, rows] = self.key.size.map(|side| side.div_ceil(GROUP));
        let each_pixel = |encoder: &mut wgpu::CommandEncoder, pipeline, group, offset: u32| {
            let Some(pipeline) = pipeline else { return };
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[offset]);
            pass.dispatch_workgroups(columns, rows, 1);
        };
        let at = |dispatch: usize| self.stride * dispatch as u32;
        for step in &self.recording.steps {
            match *step {
                FrameStep::Clear => {
                    for table in [Some(&self.colors), Some(&self.counts), extras.marks] {
                        if let Some(buffer) = table.and_then(StorageBuffer::buffer) {
                            encoder.clear_buffer(buffer, 0, None);
                        }
                    }
                }
                FrameStep::Draw(dispatch) => {
                    if let Some(drawing) = extras.drawing {
                        let frames = (&self.frames, at(dispatch));
                        drawing.draw(gpu, encoder, frames, self.timing.as_mut());
                    }
                }
                FrameStep::EmptyBlocks => {
                    if let Some(live) = self.live.buffer() {
                        encoder.copy_buffer_to_buffer(&self.no_blocks, 0, live, 0, 16);
                    }
                }
                FrameStep::TakeBlocks => {
                    if let Some(live) = self.live.buffer() {
                        encoder.copy_buffer_to_buffer(live, 0, &self.arguments, 0, 12);
                    }
                }
                FrameStep::Pass {
                    label,
                    pipeline,
                    dispatch,
                    groups,
                } => {
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                        label: Some(label),
                        timestamp_writes: self.timing.as_mut().and_then(Timing::next),
                    });
                    if let Some(pipeline) = pipelines.frame[pipeline] {
                        pass.set_pipeline(pipeline);
                    }
                    pass.set_bind_group(0, frame_group, &[at(dispatch)]);
                    match groups {
                        Some([x, y, z]) => pass.dispatch_workgroups(x, y, z),
                        None => pass.dispatch_workgroups_indirect(&self.arguments, 0),
                    }
                }
                FrameStep::Count(dispatch) => {
                    each_pixel(encoder, pipelines.count, Some(resolving), at(dispatch));
                }
                FrameStep::Resolve(dispatch) => {
                    each_pixel(encoder, pipelines.resolve, Some(resolving), at(dispatch));
                }
                FrameStep::KeepDistances(dispatch) => {
                    each_pixel(encoder, pipelines.keep_distances, kept, at(dispatch));
                }
                FrameStep::KeepColors(dispatch) => {
                    each_pixel(encoder, pipelines.keep_colors, kept, at(dispatch));
                }
                FrameStep::KeepHits => {
                    if let (Some(hits), Some(staging)) = (self.hits.buffer(), &self.hits_staging) {
                        encoder.copy_buffer_to_buffer(hits, 0, staging, 0, staging.size());
                    }
                }
                FrameStep::Submit => {
                    let next = gpu.device.create_command_encoder(&Default::default());
                    gpu.submit(std::mem::replace(encoder, next));
                }
            }
        }
    }
}
