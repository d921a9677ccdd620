//! The pipelines of a frame.

use crate::pass_module::{Passes, compile_together};
use crate::recording::{FrameStep, Recording};
use crate::{Gpu, GpuError};

/// What a frame's steps run.
pub(crate) struct FramePasses<'a> {
    pub frame: &'a Passes,
    pub resolve: &'a Passes,
    pub textures: &'a Passes,
}

/// The pipelines of a frame, compiled before it is timed.
pub(crate) struct FramePipelines<'a> {
    /// By the index of a step. `None` where no step uses it, as with the others.
    pub frame: Vec<Option<&'a wgpu::ComputePipeline>>,
    pub count: Option<&'a wgpu::ComputePipeline>,
    pub resolve: Option<&'a wgpu::ComputePipeline>,
    pub keep_distances: Option<&'a wgpu::ComputePipeline>,
    pub keep_colors: Option<&'a wgpu::ComputePipeline>,
}

impl<'a> FramePipelines<'a> {
    /// Compiles what a recording runs.
    pub(crate) fn of(
        gpu: &Gpu,
        passes: &FramePasses<'a>,
        recording: &Recording,
    ) -> Result<Self, GpuError> {
        let mut all = Self {
            frame: Vec::new(),
            count: None,
            resolve: None,
            keep_distances: None,
            keep_colors: None,
        };
        let wanted = recording.steps.iter().filter_map(|step| match *step {
            FrameStep::Pass { pipeline, .. } => Some((passes.frame, pipeline)),
            FrameStep::Count(_) => Some((passes.resolve, passes.resolve.index("count")?)),
            FrameStep::Resolve(_) => Some((passes.resolve, passes.resolve.index("resolve")?)),
            _ => None,
        });
        compile_together(gpu, &wanted.collect::<Vec<_>>())?;
        for step in &recording.steps {
            match *step {
                FrameStep::Pass { pipeline, .. } => {
                    all.frame.resize(all.frame.len().max(pipeline + 1), None);
                    all.frame[pipeline] = Some(passes.frame.at(gpu, pipeline)?);
                }
                FrameStep::Count(_) => all.count = Some(passes.resolve.get(gpu, "count")?),
                FrameStep::Resolve(_) => all.resolve = Some(passes.resolve.get(gpu, "resolve")?),
                FrameStep::KeepDistances(_) => {
                    all.keep_distances = Some(passes.textures.get(gpu, "keep_distances")?);
                }
                FrameStep::KeepColors(_) => {
                    all.keep_colors = Some(passes.textures.get(gpu, "keep_colors")?);
                }
                _ => {}
            }
        }
        Ok(all)
    }
}
