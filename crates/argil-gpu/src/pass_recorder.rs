//! Runs the passes of a build, and times each stage.

use crate::submission::Submission;
use crate::timing::Timing;
use crate::{Gpu, GpuError, StageTimings};
use web_time::Instant;

/// Passes between two readings of timestamps.
const PASSES_PER_READBACK: u32 = 500;

/// Whether each pass is waited for and timed by the clock, without timestamps. In a browser, the whole build then
/// counts as its last stage.
pub(crate) const CAN_WAIT: bool = cfg!(not(target_arch = "wasm32"));

/// The number of workgroups of a pass.
#[derive(Clone, Copy)]
pub(crate) enum DispatchSize<'a> {
    Direct([u32; 3]),
    /// From a buffer at a byte offset, which an earlier pass has written.
    Indirect(&'a wgpu::Buffer, u64),
}

/// The passes of one build, timed by stage.
pub(crate) struct PassRecorder<'a> {
    gpu: &'a Gpu,
    /// What is not submitted yet.
    encoder: Option<wgpu::CommandEncoder>,
    /// The encoder of a host, which submits it.
    host: Option<&'a mut wgpu::CommandEncoder>,
    timing: Option<Timing>,
    /// Whether durations are needed.
    is_timed: bool,
    start: Instant,
    /// The stage of each pass, and its duration by the clock if there are no timestamps.
    passes: Vec<(&'static str, f64)>,
    /// The duration of each pass by timestamps, as far as they have been read.
    stamps: Vec<f64>,
}

impl<'a> PassRecorder<'a> {
    /// Creates a recorder for any number of passes.
    pub(crate) fn new(gpu: &'a Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            timing: Timing::new(gpu, PASSES_PER_READBACK)?,
            is_timed: true,
            ..Self::untimed(gpu, None)
        })
    }

    /// Creates a recorder that neither waits nor measures. It submits passes together when it is asked to, or leaves that to a host.
    pub(crate) fn untimed(gpu: &'a Gpu, host: Option<&'a mut wgpu::CommandEncoder>) -> Self {
        Self {
            gpu,
            encoder: None,
            host,
            timing: None,
            is_timed: false,
            start: Instant::now(),
            passes: Vec::new(),
            stamps: Vec::new(),
        }
    }

    pub(crate) fn gpu(&self) -> &'a Gpu {
        self.gpu
    }

    /// Returns the encoder of what is submitted next.
    pub(crate) fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        if let Some(host) = &mut self.host {
            return host;
        }
        let device = &self.gpu.device;
        let begin = || device.create_command_encoder(&Default::default());
        self.encoder.get_or_insert_with(begin)
    }

    /// Whether a host submits the passes.
    pub(crate) fn is_for_host(&self) -> bool {
        self.host.is_some()
    }

    /// Returns the submission of everything so far.
    pub(crate) fn submission(&self) -> Submission {
        self.host
            .as_ref()
            .map_or_else(Submission::made, |host| Submission::of(host))
    }

    /// Submits what is not submitted yet, unless a host does. Buffers that are written later change for what follows.
    pub(crate) fn submit(&mut self) -> Result<(), GpuError> {
        match self.encoder.take() {
            Some(encoder) => self.gpu.with_error_scope(|| self.gpu.submit(encoder)),
            None => Ok(()),
        }
    }

    /// Encodes one pass, and submits it if it is timed.
    pub(crate) async fn pass(
        &mut self,
        stage: &'static str,
        pipeline: &wgpu::ComputePipeline,
        bind_group: &wgpu::BindGroup,
        groups: DispatchSize<'_>,
    ) -> Result<(), GpuError> {
        if self.timing.as_ref().is_some_and(Timing::is_full) {
            self.collect().await?;
        }
        let start = Instant::now();
        let mut timing = self.timing.take();
        let mut pass = self
            .encoder()
            .begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(stage),
                timestamp_writes: timing.as_mut().and_then(Timing::next),
            });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, bind_group, &[]);
        match groups {
            DispatchSize::Direct([x, y, z]) => pass.dispatch_workgroups(x, y, z),
            DispatchSize::Indirect(buffer, offset) => {
                pass.dispatch_workgroups_indirect(buffer, offset);
            }
        }
        drop(pass);
        self.timing = timing;
        if !self.is_timed {
            return Ok(());
        }
        self.submit()?;
        if self.timing.is_none() && CAN_WAIT {
            self.gpu.wait().await?;
        }
        self.passes
            .push((stage, start.elapsed().as_secs_f64() * 1e3));
        Ok(())
    }

    /// Reads the timestamps so far, and makes room for others.
    async fn collect(&mut self) -> Result<(), GpuError> {
        if let Some(timing) = &mut self.timing {
            self.stamps.extend(timing.durations_ms(self.gpu).await?);
            timing.restart();
        }
        Ok(())
    }

    /// Waits for all passes. Returns the duration of each stage, in order.
    pub(crate) async fn finish(mut self) -> Result<StageTimings, GpuError> {
        self.submit()?;
        self.gpu.wait().await?;
        self.collect().await?;
        if self.timing.is_none()
            && !CAN_WAIT
            && let Some((_, ms)) = self.passes.last_mut()
        {
            *ms += self.start.elapsed().as_secs_f64() * 1e3;
        }
        let stamps = match &self.timing {
            Some(_) => self.stamps,
            None => self.passes.iter().map(|&(_, ms)| ms).collect(),
        };
        let mut stages = StageTimings::new();
        for (&(stage, _), ms) in self.passes.iter().zip(stamps) {
            match stages.iter_mut().find(|(known, _)| *known == stage) {
                Some((_, total)) => *total += ms,
                None => stages.push((stage, ms)),
            }
        }
        Ok(stages)
    }
}
