use crate::pass::{COLORS, FRAME, HITS};
use crate::table::Table;
use crate::timing::Timing;
use crate::{GpuError, GpuField};
use argil_abi::{Frame, Hit};
use argil_march::Picture;
use std::time::Instant;

/// Instructions times pixels that one dispatch may take on: a fraction of a second even on a small GPU, so that no
/// driver takes it for hung.
const WORK_A_DISPATCH: u64 = 400_000_000;
/// Side of a workgroup.
const GROUP: u32 = 8;

impl GpuField {
    /// Draw: `frames` as `argil_march::frames` makes them, one a sample. With the picture, what its passes took, by the
    /// device's time stamps where it has them, else by the clock.
    pub fn render(&self, frames: &[Frame]) -> Result<(Picture, f64), GpuError> {
        let Some(first) = frames.first() else {
            return Ok((Picture::empty(), 0.0));
        };
        let gpu = self.gpu();
        let pixels = u64::from(first.width) * u64::from(first.height);
        let (hit_bytes, color_bytes) = (pixels * size_of::<Hit>() as u64, pixels * 16);
        let mut hits = Table::new("hits");
        hits.reserve(gpu, hit_bytes)?;
        let mut colors = Table::new("colors");
        colors.reserve(gpu, color_bytes)?;
        let uniform = gpu.checked(|| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame"),
                size: size_of::<Frame>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
        let bind_group = gpu.checked(|| {
            let frame = wgpu::BindGroupEntry {
                binding: FRAME,
                resource: uniform.as_entire_binding(),
            };
            let mut entries: Vec<_> = self.table_bindings().collect();
            entries.push(frame);
            entries.extend(hits.binding(HITS));
            entries.extend(colors.binding(COLORS));
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Picture"),
                layout: &self.layout,
                entries: &entries,
            })
        })?;

        // Rows in bands, each a dispatch of both passes.
        let row_work = u64::from(first.width) * self.length() as u64;
        let rows = u32::try_from(WORK_A_DISPATCH / row_work.max(1)).unwrap_or(u32::MAX);
        let rows = (rows.min(first.height) / GROUP * GROUP).max(GROUP);
        let bands = first.height.div_ceil(rows);
        let stages = self.stages(first);
        let mut timing = Timing::new(gpu, stages.len() as u32 * bands * frames.len() as u32)?;
        let start = Instant::now();
        let mut hit_words = Vec::new();
        for (sample, frame) in frames.iter().enumerate() {
            for band in 0..bands {
                for stage in &stages {
                    let (first_step, step_count) = (stage.first_step, stage.step_count);
                    let frame = Frame {
                        first_row: band * rows,
                        first_step,
                        step_count,
                        ..*frame
                    };
                    gpu.checked(|| {
                        self.submit(stage, &frame, rows, &uniform, &bind_group, timing.as_mut())
                    })?;
                }
            }
            if sample == 0 {
                hit_words = read(self, &hits, hit_bytes)?;
            }
        }
        let color_words = read(self, &colors, color_bytes)?;
        let clock_ms = start.elapsed().as_secs_f64() * 1e3;
        let duration_ms = match &timing {
            Some(timing) => timing.total_ms(gpu)?,
            None => clock_ms,
        };

        let colors: Vec<[f32; 4]> = color_words
            .chunks_exact(16)
            .map(bytemuck::pod_read_unaligned)
            .collect();
        let hits = hit_words
            .chunks_exact(size_of::<Hit>())
            .map(bytemuck::pod_read_unaligned)
            .collect();
        Ok((Picture::new(first, &colors, hits), duration_ms))
    }

    /// The dispatches of one sample of one band: marches are cut into as many steps as a thread may do at once.
    fn stages(&self, frame: &Frame) -> Vec<Stage<'_>> {
        let pipelines = &self.pipelines;
        let cut = |label, pipeline, steps: u32| {
            let budget = self.budget.min(steps).max(1);
            (0..steps)
                .step_by(budget as usize)
                .map(move |first_step| Stage {
                    label,
                    pipeline,
                    first_step,
                    step_count: budget.min(steps - first_step),
                })
        };
        let mut stages: Vec<_> = cut("Trace::march", &pipelines.march, frame.max_steps).collect();
        stages.extend(cut("Trace::finish", &pipelines.finish, 1));
        if frame.show == argil_abi::SHOW_SHADED {
            stages.extend(cut(
                "Shade::shadow",
                &pipelines.shadow,
                argil_march::SHADOW_STEPS,
            ));
        }
        stages.extend(cut("Shade::light", &pipelines.shade, 1));
        stages
    }

    fn submit(
        &self,
        stage: &Stage<'_>,
        frame: &Frame,
        rows: u32,
        uniform: &wgpu::Buffer,
        bind_group: &wgpu::BindGroup,
        timing: Option<&mut Timing>,
    ) {
        let gpu = self.gpu();
        gpu.queue
            .write_buffer(uniform, 0, bytemuck::bytes_of(frame));
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let descriptor = wgpu::ComputePassDescriptor {
            label: Some(stage.label),
            timestamp_writes: timing.and_then(|t| t.next()),
        };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(stage.pipeline);
        pass.set_bind_group(0, bind_group, &[]);
        pass.dispatch_workgroups(frame.width.div_ceil(GROUP), rows.div_ceil(GROUP), 1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }
}

/// One dispatch.
struct Stage<'a> {
    label: &'static str,
    pipeline: &'a wgpu::ComputePipeline,
    first_step: u32,
    step_count: u32,
}

fn read(field: &GpuField, table: &Table, bytes: u64) -> Result<Vec<u8>, GpuError> {
    let buffer = table
        .buffer()
        .ok_or_else(|| GpuError::Lost("no buffer".into()))?;
    field.gpu().read_back(buffer, bytes)
}
