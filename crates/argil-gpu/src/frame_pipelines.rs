//! The pipelines of a frame.

use crate::pass_module::Passes;
use crate::recording::{FrameStep, Recording};
use crate::{Gpu, GpuError};

/// What a frame's steps run.
pub(crate) struct FramePasses<'a> {
    pub frame: &'a Passes,
    pub resolve: &'a Passes,
}

/// The pipelines of a frame, compiled before it is timed.
pub(crate) struct FramePipelines<'a> {
    /// By the index of a step. `None` where no step uses it.
    pub frame: Vec<Option<&'a wgpu::ComputePipeline>>,
    pub count: &'a wgpu::ComputePipeline,
    pub resolve: &'a wgpu::ComputePipeline,
}

impl<'a> FramePipelines<'a> {
    /// Compiles what a recording runs.
    pub(crate) fn of(
        gpu: &Gpu,
        passes: &FramePasses<'a>,
        recording: &Recording,
    ) -> Result<Self, GpuError> {
        let mut frame = Vec::new();
        for step in &recording.steps {
            if let FrameStep::Pass { pipeline, .. } = *step {
                frame.resize(frame.len().max(pipeline + 1), None);
                frame[pipeline] = Some(passes.frame.at(gpu, pipeline)?);
            }
        }
        Ok(Self {
            frame,
            count: passes.resolve.get(gpu, "count")?,
            resolve: passes.resolve.get(gpu, "resolve")?,
        })
    }
}
