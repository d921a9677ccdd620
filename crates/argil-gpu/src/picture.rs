//! Pictures: marching, finishing and light, whatever the rays go through.

use crate::bake::{CAN_WAIT, Groups};
use crate::pass::{
    BRICK_MATERIALS, Bind, CELLS, CELLS_WGSL, COLORS, DRAWN, DRAWN_WGSL, FIELD_BINDS, FRAME,
    FRAME_WGSL, HITS, LINEAR, LIVE, NODES, PICTURE_WGSL, STORED, TABLES_WGSL, TREE_WGSL,
    TREE_WORDS, VOLUME, VOLUME_WGSL, entry, layout, pipelines,
};
use crate::table::Table;
use crate::timing::Timing;
use crate::{DeviceKind, Gpu, GpuError, GpuField};
use argil_abi::{Frame, Hit};
use argil_march::{Picture, wgsl};
use web_time::Instant;

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
    /// What was drawn.
    Mesh,
    /// Bricks of a world so wide that the table of their blocks has levels.
    WideBricks,
}

impl Way {
    pub const COUNT: usize = 6;

    fn is_sparse(self) -> bool {
        matches!(self, Self::Bricks | Self::WideBricks)
    }
}

/// What a sample begins with. In a browser nothing of a GPU is sent to other threads.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) type Before<'a> =
    dyn FnMut(&Frame, Option<&mut Timing>) -> Result<(), GpuError> + Send + 'a;
#[cfg(target_arch = "wasm32")]
pub(crate) type Before<'a> = dyn FnMut(&Frame, Option<&mut Timing>) -> Result<(), GpuError> + 'a;

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
            Way::Mesh => (wgsl::MESH, DRAWN_WGSL.to_owned()),
            Way::Dense => (wgsl::DENSE, VOLUME_WGSL.to_owned()),
            Way::Bricks | Way::WideBricks => {
                let words = [argil_volume::wgsl::WORDS, argil_volume::wgsl::MATERIAL].concat();
                (wgsl::BRICKS, [VOLUME_WGSL, CELLS_WGSL, &words].concat())
            }
            Way::Octree => {
                let morton = argil_math::morton_wgsl();
                (wgsl::OCTREE, [VOLUME_WGSL, TREE_WGSL, morton].concat())
            }
        };
        let source = [
            &argil_abi::wgsl(),
            TABLES_WGSL,
            FRAME_WGSL,
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
        if way == Way::Mesh {
            binds.push(Bind::Picture(DRAWN));
        } else if way != Way::Field {
            binds.extend([
                Bind::Uniform(VOLUME),
                Bind::Texture(STORED),
                Bind::Filter(LINEAR),
            ]);
        }
        if way == Way::Octree {
            binds.extend([Bind::Read(NODES), Bind::Read(TREE_WORDS)]);
        }
        if way.is_sparse() {
            binds.extend([
                Bind::Read(CELLS),
                Bind::Read(BRICK_MATERIALS),
                Bind::Write(LIVE),
            ]);
        }
        let layout = gpu.checked(|| layout(gpu, "Picture", &binds))?;
        // What no table has costs nothing.
        let flat = [("HAS_LEVELS", 0.0)];
        let constants: &[(&str, f64)] = if way == Way::Bricks { &flat } else { &[] };
        let sparse = if way.is_sparse() {
            let entry_points = ["cone", "exact_normals"];
            Some(pipelines(
                gpu,
                source.clone(),
                &layout,
                constants,
                entry_points,
            )?)
        } else {
            None
        };
        let entry_points = ["march", "finish", "shadow", "shade", "show"];
        let [march, finish, shadow, shade, show] =
            pipelines(gpu, source, &layout, constants, entry_points)?;
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
    pub async fn draw(
        &self,
        field: &GpuField,
        own: &[wgpu::BindGroupEntry<'_>],
        frames: &[Frame],
    ) -> Result<(Picture, f64), GpuError> {
        self.draw_after(field, own, frames, &mut |_, _| Ok(()))
            .await
    }

    /// The same, after something that each sample begins with, in one pass at most.
    pub async fn draw_after(
        &self,
        field: &GpuField,
        own: &[wgpu::BindGroupEntry<'_>],
        frames: &[Frame],
        before: &mut Before<'_>,
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
        let mut live = Table::new("blocks of pixels");
        if self.sparse.is_some() {
            let blocks = u64::from(first.width.div_ceil(GROUP) * first.height.div_ceil(GROUP));
            live.reserve(gpu, 16 + 16 * blocks)?;
        }
        let arguments = gpu.checked(|| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("blocks to march"),
                size: 16,
                usage: wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
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
            entries.extend(live.binding(LIVE));
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Picture"),
                layout: &self.layout,
                entries: &entries,
            })
        })?;

        // Rows in bands, each a dispatch of both passes.
        let row_work = u64::from(first.width) * field.length() as u64;
        let rows = u32::try_from(WORK_A_DISPATCH / row_work.max(1)).unwrap_or(u32::MAX);
        // As many blocks as a dispatch may have along one axis.
        let most_rows = MOST_GROUPS / first.width.div_ceil(GROUP) * GROUP;
        let rows = rows.min(most_rows);
        let rows = (rows.min(first.height) / GROUP * GROUP).max(GROUP);
        let bands = first.height.div_ceil(rows);
        let is_software = gpu.info.kind == DeviceKind::Software;
        let most_steps = if is_software && self.way != Way::Field {
            SOFTWARE_STEPS
        } else {
            u32::MAX
        };
        let stages = self.stages(field, first);
        let mut timing = Timing::new(gpu, (stages.len() as u32 * bands + 1) * frames.len() as u32)?;
        // Without time stamps, by the clock: passes alone, not what is read back.
        let mut clock_ms = 0.0;
        let mut hit_words = Vec::new();
        let mut start = Instant::now();
        for (sample, frame) in frames.iter().enumerate() {
            before(frame, timing.as_mut())?;
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
                        let groups = groups_of(gpu, stage, &frame, rows, &live, &arguments);
                        submit(
                            gpu,
                            stage,
                            &frame,
                            groups,
                            &uniform,
                            &bind_group,
                            timing.as_mut(),
                        );
                    })?;
                }
            }
            let is_last = sample + 1 == frames.len();
            if timing.is_none() && (CAN_WAIT || is_last) {
                gpu.wait().await?;
                clock_ms += start.elapsed().as_secs_f64() * 1e3;
            }
            if sample == 0 {
                hit_words = read(gpu, &hits, hit_bytes).await?;
            }
            if CAN_WAIT {
                start = Instant::now();
            }
        }
        let color_words = read(gpu, &colors, color_bytes).await?;
        let duration_ms = match &timing {
            Some(timing) => timing.durations_ms(gpu).await?.iter().sum(),
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
                label: if self.sparse.is_some() {
                    LIVE_STAGE
                } else {
                    "Trace::march"
                },
                pipeline: &self.march,
                first_step: 0,
                step_count: frame.max_steps,
            };
            cones.into_iter().chain([march]).collect()
        };
        // Bricks have their normals already.
        if self.sparse.is_none() || frame.ground_jitter[1] > 0.0 {
            stages.extend(cut("Trace::finish", &self.finish, 1));
        }
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
    groups: Groups<'_>,
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
    match groups {
        Groups::Direct([x, y, z]) => pass.dispatch_workgroups(x, y, z),
        Groups::Indirect(buffer, offset) => pass.dispatch_workgroups_indirect(buffer, offset),
    }
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
}

const CONE_STAGE: &str = "Cones::march";
const LIVE_STAGE: &str = "Bricks::march";
/// Most workgroups along one axis that every device has.
const MOST_GROUPS: u32 = 65_535;

/// How many workgroups a stage has; before cones, the list of live blocks is emptied, and after them it is counted.
fn groups_of<'a>(
    gpu: &Gpu,
    stage: &Stage<'_>,
    frame: &Frame,
    rows: u32,
    live: &Table,
    arguments: &'a wgpu::Buffer,
) -> Groups<'a> {
    let across = |group: u32| [frame.width.div_ceil(group), rows.div_ceil(group), 1];
    match (stage.label, live.buffer()) {
        (CONE_STAGE, Some(live)) => {
            let none = [0u32, 1, 1, 0];
            gpu.queue.write_buffer(live, 0, bytemuck::bytes_of(&none));
            // A cone's thread has as many pixels as another's group.
            Groups::Direct(across(GROUP * GROUP))
        }
        (LIVE_STAGE, Some(live)) => {
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(live, 0, arguments, 0, 12);
            gpu.queue.submit([encoder.finish()]);
            Groups::Indirect(arguments, 0)
        }
        _ => Groups::Direct(across(GROUP)),
    }
}

/// One dispatch.
struct Stage<'a> {
    label: &'static str,
    pipeline: &'a wgpu::ComputePipeline,
    first_step: u32,
    step_count: u32,
}

async fn read(gpu: &Gpu, table: &Table, bytes: u64) -> Result<Vec<u8>, GpuError> {
    let buffer = table
        .buffer()
        .ok_or_else(|| GpuError::Lost("no buffer".into()))?;
    gpu.read_back(buffer, bytes).await
}
