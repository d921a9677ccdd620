//! The passes of an image, compiled once for a program and a trace mode, and recorded once for a frame.

use crate::bindings::{
    Bind, COLORS, FIELD_BINDS, FRAME, FRAME_WGSL, HITS, PICTURE_WGSL, TABLES_WGSL,
};
use crate::frame::FrameBuffers;
use crate::frame_extras::{DrawnFrame, FrameExtras};
use crate::frame_pipelines::FramePasses;
use crate::frame_stages::{Threads, WORK_PER_DISPATCH, band_rows, entry_points, frame_key, stages};
use crate::image_textures::textures_module;
use crate::near_lists::{NEAR_BINDS, near_tables};
use crate::pass_module::{PassModule, Passes};
use crate::recording::{Destination, Dispatch, FrameKey, FrameStep, GROUP, MoreLight, Recording};
use crate::resolve::resolve_module;
use crate::trace_mode::{BoundResource, PathMode, TraceMode};
use crate::{DeviceKind, Gpu, GpuError, GpuProgram, HostEncoder, ImageOutput};
use argil_abi::FrameUniform;
use argil_render::{RenderOutput, wgsl};
use std::sync::{Arc, Mutex, PoisonError};

/// Maximum steps of a ray through a volume on a software device, which ends a thread's loops after 65,535 rounds.
const SOFTWARE_STEPS: u32 = 50_000;
/// Evaluations of the field that a pass of lamps or fog does.
const MORE_EVALUATIONS: u64 = argil_abi::LAMP_STEPS as u64 + 2;
/// Maximum pixels of a frame whose buffers are kept. Larger ones, of over a gigabyte, are freed.
const MAX_CACHED: u64 = 1 << 24;
const WHOLE_FIELD: TraceMode = TraceMode {
    name: "field",
    more_name: "field with more light",
    march: wgsl::FIELD,
    tables: String::new,
    binds: &[],
    constants: &[],
    draws: false,
    is_exact: true,
    paths: Some(PathMode {
        name: "paths through the field",
        wgsl: wgsl::FIELD_PATHS,
        binds: &[],
    }),
    host: None,
    has_cones: false,
    by_lists: false,
};
/// Rays through the field.
pub(crate) static FIELD: TraceMode = WHOLE_FIELD;
/// The same by lists of instructions for parts of a grid.
pub(crate) static NEAR_FIELD: TraceMode = TraceMode {
    name: "field by lists",
    more_name: "field by lists with more light",
    tables: near_tables,
    binds: &NEAR_BINDS,
    paths: Some(PathMode {
        name: "paths through the field by lists",
        wgsl: wgsl::FIELD_PATHS,
        binds: &NEAR_BINDS,
    }),
    by_lists: true,
    ..WHOLE_FIELD
};

impl GpuProgram {
    /// Returns how frames and paths evaluate the field, and what they bind for it. A host's encoder gets what that needs first.
    pub(crate) fn field_way(
        &self,
        host: Option<&mut HostEncoder>,
    ) -> Result<(&'static TraceMode, Vec<BoundResource>), GpuError> {
        self.check_length()?;
        Ok(match self.near_for(u64::MAX, host)? {
            Some(bound) => (&NEAR_FIELD, bound),
            None => (&FIELD, Vec::new()),
        })
    }

    /// Returns the passes that convert frames, and those that keep them in textures.
    pub(crate) fn last_passes(&self) -> Result<[Arc<Passes>; 2], GpuError> {
        let gpu = self.gpu();
        Ok([
            self.plain_passes("resolve", || Passes::new(gpu, resolve_module()))?,
            self.plain_passes("textures", || Passes::new(gpu, textures_module()))?,
        ])
    }

    /// Returns the passes of a trace mode. Each is compiled when it first runs.
    pub(crate) fn picture(
        &self,
        way: &'static TraceMode,
        frame: &FrameUniform,
    ) -> Result<Arc<RenderPasses>, GpuError> {
        let has_more = MoreLight::of(frame).is_any();
        let is_of_host = frame.eye_right != [0.0; 3] || frame.near_plane != [0.0; 4];
        let make = || {
            let mut module = frame_module(&self.wgsl_by(way.by_lists), way, has_more);
            if is_of_host {
                for pass in &mut module.entry_points {
                    pass.constants.push(("HOST_RAYS", 1.0));
                }
            }
            RenderPasses::new(self.gpu(), module, way)
        };
        let name = if has_more { way.more_name } else { way.name };
        let name = (name, u32::from(is_of_host));
        if way.has_cones {
            return self.plain_passes(name, make);
        }
        if has_more {
            self.check_evaluations(MORE_EVALUATIONS)?;
        }
        self.passes(name, make)
    }

    /// Renders an image. [`argil_render::frame_uniforms`] makes `frames`, one per sample. Returns the image, and
    /// the duration of its passes in milliseconds, by timestamps if there are any.
    ///
    /// # Errors
    /// If the image exceeds the device's memory, it has another size than the textures, or the device fails.
    pub async fn render(
        &self,
        frames: &[FrameUniform],
        output: ImageOutput<'_>,
    ) -> Result<(RenderOutput, f64), GpuError> {
        let Some(first) = frames.first() else {
            return Ok((RenderOutput::empty(), 0.0));
        };
        let (way, bound) = self.field_way(None)?;
        let passes = self.picture(way, first)?;
        let extras = FrameExtras::of(output);
        let drawn = passes.draw(self, bound, extras, frames).await?;
        Ok((drawn.picture, drawn.duration_ms))
    }
}

/// Describes the passes of images of a trace mode.
pub(crate) fn frame_module(field_wgsl: &str, way: &TraceMode, has_more: bool) -> PassModule {
    let more = if has_more { wgsl::MORE_LIGHT } else { "" };
    let source = [
        &argil_abi::wgsl(),
        TABLES_WGSL,
        FRAME_WGSL,
        PICTURE_WGSL,
        wgsl::STORED_HITS,
        &(way.tables)(),
        field_wgsl,
        wgsl::CAMERA,
        way.march,
        wgsl::RESOLVE_HITS,
        wgsl::SHADE,
        more,
    ];
    let mut binds = FIELD_BINDS.to_vec();
    binds.extend([
        Bind::Uniforms(FRAME),
        Bind::Write(HITS),
        Bind::Write(COLORS),
    ]);
    binds.extend(way.binds);
    let mut constants = way.constants.to_vec();
    constants.push(("HAS_MORE_LIGHT", f64::from(u8::from(has_more))));
    let entry_points = entry_points(way, has_more);
    let label = if has_more { way.more_name } else { way.name };
    PassModule::new(label, &source, binds, &constants, &entry_points)
}

/// The passes of an image.
#[derive(Debug)]
pub(crate) struct RenderPasses {
    way: &'static TraceMode,
    passes: Passes,
    /// The buffers of the previous frame.
    target: Mutex<Option<FrameBuffers>>,
}

impl RenderPasses {
    /// Takes passes of a trace mode. Each is compiled when it first runs.
    pub(crate) fn new(
        gpu: &Gpu,
        module: PassModule,
        way: &'static TraceMode,
    ) -> Result<Self, GpuError> {
        Ok(Self {
            way,
            passes: Passes::new(gpu, module)?,
            target: Mutex::default(),
        })
    }

    /// Renders with a program's tables, the trace mode's own bindings, and what only some representations need.
    pub(crate) async fn draw(
        &self,
        field: &GpuProgram,
        bound: Vec<BoundResource>,
        extras: FrameExtras<'_>,
        frames: &[FrameUniform],
    ) -> Result<DrawnFrame, GpuError> {
        let Some(first) = frames.first() else {
            return Ok(DrawnFrame {
                picture: RenderOutput::empty(),
                duration_ms: 0.0,
                marks: Vec::new(),
            });
        };
        let gpu = field.gpu();
        let mut target = self.target(field, frames, extras.output.into(), self.take())?;
        let [resolve, textures] = field.last_passes()?;
        let passes = self.with(&resolve, &textures);
        let bound = field.bound().chain(bound).collect();
        let drawn = target.run(gpu, passes, bound, extras, frames).await?;
        if u64::from(first.width) * u64::from(first.height) <= MAX_CACHED {
            let mut place = self.target.lock().unwrap_or_else(PoisonError::into_inner);
            *place = Some(target);
        }
        Ok(drawn)
    }

    /// Returns the buffers of a frame with its recording: those of the frame before, if they fit.
    pub(crate) fn target(
        &self,
        field: &GpuProgram,
        frames: &[FrameUniform],
        goes: Destination,
        kept: Option<FrameBuffers>,
    ) -> Result<FrameBuffers, GpuError> {
        let gpu = field.gpu();
        let key = frame_key(self.way, frames, (field.length(), field.budget), goes);
        if key.normals == argil_abi::NORMALS_FIELD {
            field.check_length()?;
        }
        let record = || self.record(&key, gpu.info.kind == DeviceKind::Software);
        match kept.filter(|target| target.fits(&key)) {
            Some(mut target) => {
                target.follow(gpu, key, record)?;
                Ok(target)
            }
            None => FrameBuffers::new(gpu, key, record(), self.way.has_cones),
        }
    }

    /// Returns the passes with those that resolve frames.
    pub(crate) fn with<'a>(&'a self, resolve: &'a Passes, textures: &'a Passes) -> FramePasses<'a> {
        FramePasses {
            frame: &self.passes,
            resolve,
            textures,
        }
    }

    /// Takes the buffers of the previous frame, if nobody else renders with them.
    fn take(&self) -> Option<FrameBuffers> {
        let mut place = self.target.lock().unwrap_or_else(PoisonError::into_inner);
        place.take()
    }

    /// Records all passes of a frame.
    fn record(&self, key: &FrameKey, is_software: bool) -> Recording {
        let [width, height] = key.size;
        let rows = band_rows(key, self.way.has_cones);
        let most_steps = if is_software && !self.way.is_exact {
            SOFTWARE_STEPS
        } else {
            u32::MAX
        };
        let stages = stages(self.way, key);
        let is_for_host = key.goes == Destination::Host;
        let mut all = Recording::default();
        let mut work = 0;
        all.steps.push(FrameStep::Clear);
        for sample in 0..key.samples {
            let dispatch = |first_row, first_step, step_count| Dispatch {
                sample,
                first_row,
                first_step,
                step_count,
                max_steps: key.max_steps.min(most_steps),
            };
            let whole = all.dispatches.len();
            let mut first = dispatch(0, 0, 1);
            if is_for_host {
                // A host draws what the last sample hit, by the values of the first dispatch.
                first.sample = key.samples - 1;
            }
            all.dispatches.push(first);
            if self.way.draws {
                all.steps.push(FrameStep::Draw(whole));
            }
            for first_row in (0..height).step_by(rows as usize) {
                let band = rows.min(height - first_row);
                for stage in &stages {
                    let pixels = u64::from(width) * u64::from(band);
                    let length = if stage.is_exact {
                        key.field.0 as u64
                    } else {
                        1
                    };
                    // A host submits all at once.
                    if !is_for_host && work > 0 && work + pixels * length > WORK_PER_DISPATCH {
                        all.steps.push(FrameStep::Submit);
                        work = 0;
                    }
                    work += pixels * length;
                    let across = |group: u32| [width.div_ceil(group), rows.div_ceil(group), 1];
                    let groups = match stage.threads {
                        Threads::Pixels => Some(across(GROUP)),
                        Threads::Cones => {
                            all.steps.push(FrameStep::EmptyBlocks);
                            // A cone's thread has as many pixels as another pass's workgroup.
                            Some(across(GROUP * GROUP))
                        }
                        Threads::ListedBlocks => {
                            all.steps.push(FrameStep::TakeBlocks);
                            None
                        }
                        Threads::ListedBlocksOnce => {
                            // The pass itself lists pixels, from none on.
                            all.steps.push(FrameStep::TakeBlocks);
                            all.steps.push(FrameStep::EmptyBlocks);
                            None
                        }
                    };
                    all.steps.push(FrameStep::Pass {
                        label: stage.label,
                        pipeline: stage.pipeline,
                        dispatch: all.dispatches.len(),
                        groups,
                    });
                    let next = dispatch(first_row, stage.first_step, stage.step_count);
                    all.dispatches.push(next);
                }
            }
            all.steps.extend(last_steps(key, sample, whole));
        }
        all
    }
}

/// Returns what follows the passes of a sample, with the values of a dispatch.
fn last_steps(key: &FrameKey, sample: usize, dispatch: usize) -> Vec<FrameStep> {
    let mut steps = Vec::new();
    if key.goes == Destination::Host {
        return steps;
    }
    if sample == 0 {
        if key.has_statistics {
            steps.push(FrameStep::Count(dispatch));
        }
        match key.goes {
            Destination::CpuWithHits => steps.push(FrameStep::KeepHits),
            Destination::Textures => steps.push(FrameStep::KeepDistances(dispatch)),
            Destination::Cpu | Destination::Host => {}
        }
    }
    if sample + 1 == key.samples {
        steps.push(FrameStep::Resolve(dispatch));
        if key.goes == Destination::Textures {
            steps.push(FrameStep::KeepColors(dispatch));
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil_field::Program;
    use argil_render::{Camera, RenderSettings, frame_uniforms};
    use argil_scene::{Brush, Scene, Shape};

    /// The buffers of a frame are those of the frame before, until its size is another.
    #[test]
    fn frames_of_a_size_share_their_buffers() {
        let mut scene = Scene::new();
        for _ in 0..20 {
            scene.push(Brush::new(Shape::sphere(0.5))).expect("a brush");
        }
        let program = Program::lower(&scene).expect("a program");
        let gpu = Arc::new(pollster::block_on(Gpu::open()).expect("a device"));
        let mut field = GpuProgram::new(gpu, &program, false).expect("a field");
        let camera = Camera::orbit(program.aabb(), [30.0, 20.0, 2.5], 45.0);
        let draw = |field: &GpuProgram, size| {
            let settings = RenderSettings {
                size,
                ..RenderSettings::default()
            };
            let all = frame_uniforms(&settings, &camera, &program, None, program.aabb());
            let drawn = pollster::block_on(field.render(&all, ImageOutput::Cpu));
            drawn.expect("a picture").0
        };
        let passes = field
            .picture(&NEAR_FIELD, &FrameUniform::default())
            .expect("passes");
        let kept = || {
            let target = passes.take().expect("a frame before");
            let buffers = target.buffers();
            *passes.target.lock().expect("nobody else") = Some(target);
            buffers
        };
        let first = draw(&field, [40, 24]);
        let buffers = kept();
        let second = draw(&field, [40, 24]);
        assert!(buffers == kept(), "the same frame has other buffers");
        assert_eq!(first.rgb, second.rgb);
        assert!(first.hit_pixels > 100 && first.hits.is_empty());
        // An edit changes how long the field is, and with it the passes.
        for _ in 0..40 {
            scene.push(Brush::new(Shape::sphere(0.1))).expect("a brush");
        }
        let longer = Program::lower(&scene).expect("a program");
        field.update(&longer).expect("a field");
        draw(&field, [40, 24]);
        assert!(
            buffers == kept(),
            "after an edit the frame has other buffers"
        );
        draw(&field, [48, 24]);
        assert!(buffers != kept(), "another size has the same buffers");
    }

    /// What the device counts is what the hits say.
    #[test]
    fn counts_are_those_of_the_hits() {
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::sphere(0.5))).expect("a brush");
        let program = Program::lower(&scene).expect("a program");
        let gpu = Arc::new(pollster::block_on(Gpu::open()).expect("a device"));
        let field = GpuProgram::new(gpu, &program, false).expect("a field");
        let camera = Camera::orbit(program.aabb(), [30.0, 20.0, 2.5], 45.0);
        let settings = RenderSettings {
            size: [75, 50],
            statistics: true,
            ..RenderSettings::default()
        };
        let all = frame_uniforms(&settings, &camera, &program, None, program.aabb());
        let drawn = pollster::block_on(field.render(&all, ImageOutput::CpuWithHits));
        let (picture, _) = drawn.expect("a picture");
        let steps = picture.hits.iter().map(|hit| f64::from(hit.steps));
        let sum: f64 = steps.clone().sum();
        let counted = picture.statistics.expect("statistics");
        assert!(sum > 1000.0 && (counted.steps.mean * 3750.0 - sum).abs() < 0.5);
        assert_eq!(counted.steps.max, steps.fold(0.0, f64::max));
        assert_eq!((counted.samples, counted.cells.max), (counted.steps, 0.0));
        let is_solid = |hit: &&argil_abi::Hit| hit.kind != argil_abi::HIT_NONE;
        assert_eq!(
            picture.hit_pixels,
            picture.hits.iter().filter(is_solid).count()
        );
    }
}
