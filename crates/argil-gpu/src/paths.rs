//! Paths of light on the device.
//!
//! *Practice.* A thread follows the paths of one pixel, one after another. One pass marches the rays of all pixels by some
//! steps, and another one chooses where paths go on whose rays have ended. Both are submitted again and again, until all paths
//! have ended. Pixels are taken in bands that fit into a buffer.

use crate::bindings::{
    Bind, ENVIRONMENT, FIELD_BINDS, FRAME, FRAME_WGSL, PATH_PIXELS, PATH_STATES, PATH_TABLES,
    PATHS, PATHS_WGSL, TABLES_WGSL,
};
use crate::pass_module::{PassModule, Passes};
use crate::path_buffers::{PathBuffers, PathWork};
use crate::render::FIELD;
use crate::trace_mode::{BoundResource, PathMode, TraceMode};
use crate::{DeviceKind, Gpu, GpuError, GpuProgram, GpuVolume};
use argil_abi::PathUniform;
use argil_math::Control;
use argil_render::{Still, wgsl};
use web_time::Instant;

/// Steps of a ray in one pass.
const STEPS: u32 = 64;
/// Passes of both kinds that are submitted at once.
const PAIRS: u32 = 16;
/// The same on a software device, for which pixels without work cost as much as others.
const SOFTWARE_PAIRS: u32 = 4;
/// The most paths of a pixel between two looks at the clock.
const MOST_AT_ONCE: u32 = 64;
/// Evaluations of the field that the longest pass does at once: with glass, and without.
const EVALUATIONS: [u64; 2] = [64, 16];

impl GpuProgram {
    /// Adds paths of light to a still, through the field. Canceled work keeps the paths that have ended.
    ///
    /// # Errors
    /// If the device cannot evaluate the field, its limits are exceeded, or it fails.
    pub async fn trace_paths(&self, work: PathWork<'_>, still: &mut Still) -> Result<(), GpuError> {
        // Rays that go anywhere have other lists in each thread of hardware, which takes many registers.
        let (way, bound) = match self.gpu().is_hardware() {
            true => (&FIELD, Vec::new()),
            false => self.field_way(None)?,
        };
        self.trace_through(way, bound, work, still).await
    }

    /// Adds paths of light through a representation that is bound.
    async fn trace_through(
        &self,
        way: &'static TraceMode,
        bound: Vec<BoundResource>,
        work: PathWork<'_>,
        still: &mut Still,
    ) -> Result<(), GpuError> {
        let Some(mode) = &way.paths else {
            return Err(GpuError::NoPaths { name: way.name });
        };
        let needed = EVALUATIONS[usize::from(!work.program.has_glass())];
        self.check_evaluations(needed)?;
        let has_glass = work.program.has_glass();
        let gpu = self.gpu();
        let passes = self.passes(mode.name, || {
            Passes::new(gpu, path_module(&self.wgsl_by(way.by_lists), way, mode))
        })?;
        let mut uniform = work.tables.uniform;
        let extras = work.program.material_extras();
        if !extras.is_empty() {
            uniform.extras_at = work.program.material_table().len() as u32;
            uniform.bump_step = work.program.bump_step().unwrap_or(0.0);
        }
        uniform.step_count = STEPS.min(self.budget);
        let buffers = PathBuffers::new(gpu, &work, &extras)?;
        let mut all = bound;
        all.extend(self.bound());
        let group = buffers.bind(gpu, &passes, all)?;
        let paths = Paths {
            gpu,
            turn: passes.get(gpu, "turn_paths")?,
            march: passes.get(gpu, "march_paths")?,
            // It takes long to compile.
            look_inside: match has_glass {
                true => Some(passes.get(gpu, "look_inside")?),
                false => None,
            },
            group,
            buffers,
            pairs: match gpu.info().kind {
                DeviceKind::Software => SOFTWARE_PAIRS,
                _ => PAIRS,
            },
        };
        paths.trace(&work, uniform, still).await
    }
}

impl GpuVolume {
    /// Whether paths of light pass through it.
    pub fn has_paths(&self) -> bool {
        self.way().paths.is_some()
    }

    /// Adds paths of light to a still, through the volume: see [`GpuProgram::trace_paths`].
    ///
    /// # Errors
    /// If paths do not pass through this kind, the device cannot evaluate the field, or it fails.
    pub async fn trace_paths(
        &self,
        field: &GpuProgram,
        work: PathWork<'_>,
        still: &mut Still,
    ) -> Result<(), GpuError> {
        let bound = self.bound(field.gpu(), work.frame, self.uniform());
        field.trace_through(self.way(), bound, work, still).await
    }
}

/// Describes the passes that trace paths through a representation.
pub(crate) fn path_module(field_wgsl: &str, way: &TraceMode, mode: &PathMode) -> PassModule {
    let source = [
        &argil_abi::wgsl(),
        TABLES_WGSL,
        FRAME_WGSL,
        PATHS_WGSL,
        &(way.tables)(),
        field_wgsl,
        wgsl::CAMERA,
        mode.wgsl,
        wgsl::PATHS,
    ];
    let mut binds = FIELD_BINDS.to_vec();
    binds.extend([
        Bind::Uniform(FRAME),
        Bind::Uniform(PATHS),
        Bind::Write(PATH_STATES),
        Bind::Write(PATH_PIXELS),
        Bind::Read(PATH_TABLES),
        Bind::Picture(ENVIRONMENT),
    ]);
    binds.extend(mode.binds);
    let entry_points = ["turn_paths", "march_paths", "look_inside"];
    PassModule::new(mode.name, &source, binds, way.constants, &entry_points)
}

/// Paths of an image, about to be traced.
struct Paths<'a> {
    gpu: &'a Gpu,
    turn: &'a wgpu::ComputePipeline,
    march: &'a wgpu::ComputePipeline,
    /// Only for a program with glass.
    look_inside: Option<&'a wgpu::ComputePipeline>,
    group: wgpu::BindGroup,
    buffers: PathBuffers,
    /// Passes that are submitted at once.
    pairs: u32,
}

impl Paths<'_> {
    async fn trace(
        &self,
        work: &PathWork<'_>,
        mut uniform: PathUniform,
        still: &mut Still,
    ) -> Result<(), GpuError> {
        let start = Instant::now();
        let (options, control) = (work.options, work.control);
        let [width, height] = still.size();
        let pixels = width * height;
        let bands = pixels.div_ceil(self.buffers.band);
        control.begin("paths", u64::from(options.samples) * u64::from(bands));
        let mut done = 0;
        let is_late = |done: u32| {
            let limit = options.time_limit.filter(|_| done > 0);
            limit.is_some_and(|limit| start.elapsed() >= limit)
        };
        while done < options.samples && !is_late(done) {
            let count = match options.time_limit {
                None => done.max(1),
                Some(limit) => {
                    let spent = start.elapsed();
                    let per_path = spent.as_secs_f64() / f64::from(done.max(1));
                    let left = (limit.saturating_sub(spent)).as_secs_f64() / per_path.max(1e-9);
                    done.min(left as u32).max(1)
                }
            };
            let count = count.min(MOST_AT_ONCE).min(options.samples - done);
            for band in 0..bands {
                uniform.first_pixel = band * self.buffers.band;
                uniform.pixel_count = self.buffers.band.min(pixels - uniform.first_pixel);
                // No pixel repeats a path, even if some were interrupted, and have fewer than others.
                let first = uniform.first_pixel as usize;
                let range = first..first + uniform.pixel_count as usize;
                uniform.first_sample = still.max_samples(range);
                uniform.sample_count = count;
                self.band(&uniform, control, still).await?;
                if control.is_cancelled() || is_late(done) {
                    return Ok(());
                }
                control.advance(u64::from(count));
            }
            done += count;
        }
        Ok(())
    }

    /// Traces the paths of a band, and adds what they found.
    async fn band(
        &self,
        uniform: &PathUniform,
        control: &Control,
        still: &mut Still,
    ) -> Result<(), GpuError> {
        let groups = uniform.pixel_count.div_ceil(64);
        self.buffers.restart(self.gpu, uniform);
        loop {
            self.gpu.with_error_scope(|| {
                let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_bind_group(0, &self.group, &[]);
                let all = [Some(self.turn), Some(self.march), self.look_inside];
                for _ in 0..self.pairs {
                    for pipeline in all.into_iter().flatten() {
                        pass.set_pipeline(pipeline);
                        pass.dispatch_workgroups(groups, 1, 1);
                    }
                }
                drop(pass);
                self.gpu.submit(encoder);
            })?;
            let finished = self.buffers.finished(self.gpu).await?;
            if finished >= uniform.pixel_count || control.is_cancelled() {
                break;
            }
        }
        let found = self.buffers.found(self.gpu, uniform.pixel_count).await?;
        still.add(uniform.first_pixel as usize, &found);
        Ok(())
    }
}
