//! Pictures: marching, finishing and light, whatever the rays go through.

use crate::pass::{
    Bind, CELLS, CELLS_WGSL, COLORS, CONES, FIELD_BINDS, FRAME, HITS, LINEAR, NODES, PICTURE_WGSL,
    STORED, TABLES_WGSL, TREE_WGSL, TREE_WORDS, VOLUME, VOLUME_WGSL, entry, layout, pipelines,
};
use crate::table::Table;
use crate::timing::Timing;
use crate::{DeviceKind, Gpu, GpuError, GpuField};
use argil_abi::{Frame, Hit};
use argil_march::{Picture, wgsl};
use std::time::Instant;

/// Instructions times pixels that one dispatch may take on: a fraction of a second even on a small GPU, so that no
/// driver takes it for hung.
const WORK_A_DISPATCH: u64 = 400_000_000;
/// Side of a workgroup.
const GROUP: u32 = 8;
/// Steps of a ray through a volume on a software device, which ends a thread's loops after 65,535 rounds.
const SOFTWARE_STEPS: u32 = 50_000;

/// What rays go through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    Field,
    Dense,
    Octree,
    Bricks,
}

/// The passes of a picture.
pub(crate) struct PicturePass {
    way: Way,
    layout: wgpu::BindGroupLayout,
    /// Of sparse bricks: the cones of 8×8 pixels, and the field's normals.
    sparse: Option<[wgpu::ComputePipeline; 2]>,
    march: wgpu::ComputePipeline,
    finish: wgpu::ComputePipeline,
    shadow: wgpu::ComputePipeline,
    shade: wgpu::ComputePipeline,
    show: wgpu::ComputePipeline,
}

impl PicturePass {
    /// Compile for a field's interpreter.
    pub fn new(gpu: &Gpu, field_wgsl: &str, way: Way) -> Result<Self, GpuError> {
        let (march, tables) = match way {
            Way::Field => (wgsl::FIELD, String::new()),
            Way::Dense => (wgsl::DENSE, VOLUME_WGSL.to_owned()),
            Way::Bricks => {
                let words = argil_volume::wgsl::WORDS;
                (wgsl::BRICKS, [VOLUME_WGSL, CELLS_WGSL, words].concat())
            }
            Way::Octree => {
                let morton = argil_math::morton_wgsl();
                (wgsl::OCTREE, [VOLUME_WGSL, TREE_WGSL, morton].concat())
            }
        };
        let source = [
            &argil_abi::wgsl(),
            TABLES_WGSL,
            PICTURE_WGSL,
            &tables,
            field_wgsl,
            wgsl::CAMERA,
            march,
            wgsl::FINISH,
            wgsl::SHADE,
        ]
        .concat();
        let mut binds = FIELD_BINDS.to_vec();
        binds.extend([Bind::Uniform(FRAME), Bind::Write(HITS), Bind::Write(COLORS)]);
        if way != Way::Field {
            binds.extend([
                Bind::Uniform(VOLUME),
                Bind::Texture(STORED),
                Bind::Filter(LINEAR),
            ]);
        }
        if way == Way::Octree {
            binds.extend([Bind::Read(NODES), Bind::Read(TREE_WORDS)]);
        }
        if way == Way::Bricks {
            binds.extend([Bind::Read(CELLS), Bind::Write(CONES)]);
        }
        let layout = gpu.checked(|| layout(gpu, "Picture", &binds))?;
        let sparse = if way == Way::Bricks {
            let entry_points = ["cone", "exact_normals"];
            Some(pipelines(gpu, source.clone(), &layout, &[], entry_points)?)
        } else {
            None
        };
        let entry_points = ["march", "finish", "shadow", "shade", "show"];
        let [march, finish, shadow, shade, show] =
            pipelines(gpu, source, &layout, &[], entry_points)?;
        Ok(Self {
            way,
            layout,
            sparse,
            march,
            finish,
            shadow,
            shade,
            show,
        })
    }

    /// Draw with a field's tables, and what else the way to march reads. With the picture, what its passes took.
    pub fn draw(
        &self,
        field: &GpuField,
        own: &[wgpu::BindGroupEntry<'_>],
        frames: &[Frame],
    ) -> Result<(Picture, f64), GpuError> {
        let Some(first) = frames.first() else {
            return Ok((Picture::empty(), 0.0));
        };
        let gpu = field.gpu();
        let pixels = u64::from(first.width) * u64::from(first.height);
        let (hit_bytes, color_bytes) = (pixels * size_of::<Hit>() as u64, pixels * 16);
        let mut hits = Table::new("hits");
        hits.reserve(gpu, hit_bytes)?;
        let mut colors = Table::new("colors");
        colors.reserve(gpu, color_bytes)?;
        let mut cones = Table::new("cones");
        if self.sparse.is_some() {
            let blocks = u64::from(first.width.div_ceil(GROUP) * first.height.div_ceil(GROUP));
            cones.reserve(gpu, 8 * blocks)?;
        }
        let uniform = gpu.checked(|| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame"),
                size: size_of::<Frame>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
        let bind_group = gpu.checked(|| {
            let mut entries: Vec<_> = field.table_bindings().collect();
            entries.push(entry(FRAME, &uniform));
            entries.extend_from_slice(own);
            entries.extend(hits.binding(HITS));
            entries.extend(colors.binding(COLORS));
            entries.extend(cones.binding(CONES));
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Picture"),
                layout: &self.layout,
                entries: &entries,
            })
        })?;

        // Rows in bands, each a dispatch of both passes.
        let row_work = u64::from(first.width) * field.length() as u64;
        let rows = u32::try_from(WORK_A_DISPATCH / row_work.max(1)).unwrap_or(u32::MAX);
        let rows = (rows.min(first.height) / GROUP * GROUP).max(GROUP);
        let bands = first.height.div_ceil(rows);
        let is_software = gpu.info.kind == DeviceKind::Software;
        let most_steps = if is_software && self.way != Way::Field {
            SOFTWARE_STEPS
        } else {
            u32::MAX
        };
        let stages = self.stages(field, first);
        let mut timing = Timing::new(gpu, stages.len() as u32 * bands * frames.len() as u32)?;
        let start = Instant::now();
        let mut hit_words = Vec::new();
        for (sample, frame) in frames.iter().enumerate() {
            for band in 0..bands {
                for stage in &stages {
                    let (first_step, step_count) = (stage.first_step, stage.step_count);
                    let frame = Frame {
                        max_steps: frame.max_steps.min(most_steps),
                        first_row: band * rows,
                        first_step,
                        step_count,
                        ..*frame
                    };
                    gpu.checked(|| {
                        submit(
                            gpu,
                            stage,
                            &frame,
                            rows,
                            &uniform,
                            &bind_group,
                            timing.as_mut(),
                        );
                    })?;
                }
            }
            if sample == 0 {
                hit_words = read(gpu, &hits, hit_bytes)?;
            }
        }
        let color_words = read(gpu, &colors, color_bytes)?;
        let clock_ms = start.elapsed().as_secs_f64() * 1e3;
        let duration_ms = match &timing {
            Some(timing) => timing.durations_ms(gpu)?.iter().sum(),
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
    fn stages(&self, field: &GpuField, frame: &Frame) -> Vec<Stage<'_>> {
        let cut = |label, pipeline, steps: u32| {
            let budget = field.budget.min(steps).max(1);
            (0..steps)
                .step_by(budget as usize)
                .map(move |first_step| Stage {
                    label,
                    pipeline,
                    first_step,
                    step_count: budget.min(steps - first_step),
                })
        };
        let mut stages: Vec<_> = if self.way == Way::Field {
            cut("Trace::march", &self.march, frame.max_steps).collect()
        } else {
            // A volume's march evaluates nothing: it is one dispatch, after its cones where it has some.
            let cones = self.sparse.as_ref().map(|[pipeline, _]| Stage {
                label: CONE_STAGE,
                pipeline,
                first_step: 0,
                step_count: frame.max_steps,
            });
            let march = Stage {
                label: "Trace::march",
                pipeline: &self.march,
                first_step: 0,
                step_count: frame.max_steps,
            };
            cones.into_iter().chain([march]).collect()
        };
        stages.extend(cut("Trace::finish", &self.finish, 1));
        if frame.normals == argil_abi::NORMALS_FIELD
            && let Some([_, exact]) = &self.sparse
        {
            stages.extend(cut("Trace::normals", exact, 1));
        }
        if frame.show == argil_abi::SHOW_SHADED {
            stages.extend(cut(
                "Shade::shadow",
                &self.shadow,
                argil_march::SHADOW_STEPS,
            ));
            stages.extend(cut("Shade::light", &self.shade, 1));
        } else {
            stages.extend(cut("Shade::show", &self.show, 1));
        }
        stages
    }
}

fn submit(
    gpu: &Gpu,
    stage: &Stage<'_>,
    frame: &Frame,
    rows: u32,
    uniform: &wgpu::Buffer,
    bind_group: &wgpu::BindGroup,
    timing: Option<&mut Timing>,
) {
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
    // A cone's thread has as many pixels as another's group.
    let group = if stage.label == CONE_STAGE {
        GROUP * GROUP
    } else {
        GROUP
    };
    pass.dispatch_workgroups(frame.width.div_ceil(group), rows.div_ceil(group), 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
}

const CONE_STAGE: &str = "Cones::march";

/// One dispatch.
struct Stage<'a> {
    label: &'static str,
    pipeline: &'a wgpu::ComputePipeline,
    first_step: u32,
    step_count: u32,
}

fn read(gpu: &Gpu, table: &Table, bytes: u64) -> Result<Vec<u8>, GpuError> {
    let buffer = table
        .buffer()
        .ok_or_else(|| GpuError::Lost("no buffer".into()))?;
    gpu.read_back(buffer, bytes)
}
