//! WGSL modules, what their passes bind, and the pipelines made from them.
//!
//! *Practice.* A [`PassModule`] needs no device, so that a compiler elsewhere can be asked what a device is given
//! (`shader_modules.rs`). [`Passes`] belong to a device. They parse the module once, when its first pass runs, and
//! create the pipeline of each pass when that one runs first.

use crate::bindings::{Bind, layout};
use crate::{DeviceKind, Gpu, GpuError};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The values of `override`s.
pub(crate) type Constants = Vec<(&'static str, f64)>;

/// A pass of a module, and the values of its own overrides.
#[derive(Clone, Debug)]
pub(crate) struct EntryPoint {
    pub name: &'static str,
    pub constants: Constants,
}

/// A WGSL module. All its passes have one layout.
#[derive(Clone, Debug)]
pub(crate) struct PassModule {
    pub label: &'static str,
    pub source: String,
    pub binds: Vec<Bind>,
    pub entry_points: Vec<EntryPoint>,
}

impl PassModule {
    /// Describes a module whose passes share the values of overrides.
    pub(crate) fn new(
        label: &'static str,
        source: &[&str],
        binds: Vec<Bind>,
        constants: &[(&'static str, f64)],
        entry_points: &[&'static str],
    ) -> Self {
        let entry_points = entry_points.iter().map(|&name| EntryPoint {
            name,
            constants: constants.to_vec(),
        });
        Self {
            label,
            source: source.concat(),
            binds,
            entry_points: entry_points.collect(),
        }
    }

    /// Sets an override of one pass.
    pub(crate) fn with_constant(mut self, pass: &str, name: &'static str, value: f64) -> Self {
        let entry_point = self
            .entry_points
            .iter_mut()
            .find(|entry_point| entry_point.name == pass);
        if let Some(entry_point) = entry_point {
            entry_point.constants.push((name, value));
        }
        self
    }
}

/// The passes of a module on a device.
#[derive(Debug)]
pub(crate) struct Passes {
    module: PassModule,
    pub layout: wgpu::BindGroupLayout,
    pipeline_layout: wgpu::PipelineLayout,
    shader: OnceLock<wgpu::ShaderModule>,
    pipelines: Vec<OnceLock<wgpu::ComputePipeline>>,
}

impl Passes {
    /// Creates the layout. Nothing is compiled yet.
    pub(crate) fn new(gpu: &Gpu, module: PassModule) -> Result<Self, GpuError> {
        let (layout, pipeline_layout) = gpu.with_error_scope(|| {
            let layout = layout(gpu, module.label, &module.binds);
            let pipeline_layout =
                gpu.device
                    .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                        label: Some(module.label),
                        bind_group_layouts: &[Some(&layout)],
                        immediate_size: 0,
                    });
            (layout, pipeline_layout)
        })?;
        let pipelines = module.entry_points.iter().map(|_| OnceLock::new());
        Ok(Self {
            layout,
            pipeline_layout,
            shader: OnceLock::new(),
            pipelines: pipelines.collect(),
            module,
        })
    }

    /// Returns the numbers of the bindings.
    pub(crate) fn places(&self) -> impl Iterator<Item = u32> + '_ {
        self.module.binds.iter().map(|bind| bind.place())
    }

    /// Returns the index of a pass, if there is one.
    pub(crate) fn index(&self, name: &str) -> Option<usize> {
        let mut names = self.module.entry_points.iter();
        names.position(|entry_point| entry_point.name == name)
    }

    /// Returns the pipeline of a pass. Compiles it when it is first asked for.
    pub(crate) fn get(&self, gpu: &Gpu, name: &str) -> Result<&wgpu::ComputePipeline, GpuError> {
        match self.index(name) {
            Some(index) => self.at(gpu, index),
            None => Err(GpuError::Validation {
                name: gpu.info.name.clone(),
                reason: format!("{} has no pass {name}", self.module.label),
            }),
        }
    }

    /// Returns the pipeline of a pass by its index. Compiles it when it is first asked for.
    pub(crate) fn at(&self, gpu: &Gpu, index: usize) -> Result<&wgpu::ComputePipeline, GpuError> {
        let place = &self.pipelines[index];
        if let Some(pipeline) = place.get() {
            return Ok(pipeline);
        }
        let compiled = &self.module.entry_points[index];
        let mut constants = compiled.constants.clone();
        let is_software = gpu.info.kind == DeviceKind::Software;
        if is_software && self.module.source.contains("override HIDES_UNIFORMS:") {
            constants.push(("HIDES_UNIFORMS", 1.0));
        }
        let pipeline = gpu.with_error_scope(|| {
            let module = self.shader.get_or_init(|| {
                let source = self.module.source.as_str().into();
                gpu.device
                    .create_shader_module(wgpu::ShaderModuleDescriptor {
                        label: Some(self.module.label),
                        source: wgpu::ShaderSource::Wgsl(source),
                    })
            });
            gpu.counters.pipelines.add(1);
            gpu.device
                .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(compiled.name),
                    layout: Some(&self.pipeline_layout),
                    module,
                    entry_point: Some(compiled.name),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &constants,
                        ..Default::default()
                    },
                    cache: gpu.pipeline_cache(),
                })
        })?;
        // Nobody waits for what another compiles: who comes second drops the own one.
        Ok(place.get_or_init(|| pipeline))
    }
}

/// Compiles passes that are needed together, each by its index, on several threads where there are any.
pub(crate) fn compile_together(gpu: &Gpu, wanted: &[(&Passes, usize)]) -> Result<(), GpuError> {
    let mut missing: Vec<(&Passes, usize)> = Vec::new();
    for &(passes, index) in wanted {
        let is_listed =
            |listed: &(&Passes, usize)| std::ptr::eq(listed.0, passes) && listed.1 == index;
        if passes.pipelines[index].get().is_none() && !missing.iter().any(is_listed) {
            missing.push((passes, index));
        }
    }
    let threads = match cfg!(target_arch = "wasm32") {
        true => 1,
        false => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
    };
    if threads.min(missing.len()) < 2 {
        return Ok(());
    }
    let next = AtomicUsize::new(0);
    let work = || -> Result<(), GpuError> {
        while let Some((passes, index)) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
            passes.at(gpu, *index)?;
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads.min(missing.len()))
            .map(|_| scope.spawn(work))
            .collect();
        let result = work();
        let others = others.into_iter().map(|other| {
            // A panic goes on here.
            other
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        others.fold(result, Result::and)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Passes that are needed together are compiled once each, and their faults are known.
    #[test]
    fn passes_are_compiled_together() {
        let gpu = pollster::block_on(Gpu::open()).expect("a device");
        let source = "@compute @workgroup_size(1) fn a() {} @compute @workgroup_size(1) fn b() {} @compute @workgroup_size(1) fn c() {}";
        let module =
            |names: &[&'static str]| PassModule::new("some", &[source], Vec::new(), &[], names);
        let passes = Passes::new(&gpu, module(&["a", "b", "c"])).expect("a layout");
        let all: Vec<_> = (0..3).map(|index| (&passes, index)).collect();
        compile_together(&gpu, &all[..2]).expect("passes");
        assert_eq!(gpu.counters().pipelines, 2);
        compile_together(&gpu, &all).expect("passes");
        passes.get(&gpu, "c").expect("a pass");
        assert_eq!(gpu.counters().pipelines, 3);
        let broken = Passes::new(&gpu, module(&["a", "missing", "gone"])).expect("a layout");
        let all: Vec<_> = (0..3).map(|index| (&broken, index)).collect();
        let refused = compile_together(&gpu, &all);
        assert!(
            matches!(refused, Err(GpuError::Validation { .. })),
            "{refused:?}"
        );
    }

    /// Each pass is compiled when it is first asked for, and once; unknown ones are an error.
    #[test]
    fn passes_are_compiled_when_first_used() {
        let gpu = pollster::block_on(Gpu::open()).expect("a device");
        let source = "@compute @workgroup_size(1) fn a() {} @compute @workgroup_size(1) fn b() {}";
        let module = PassModule::new("two", &[source], Vec::new(), &[], &["a", "b"]);
        let passes = Passes::new(&gpu, module).expect("a layout");
        let compiled = || gpu.counters().pipelines;
        assert_eq!(compiled(), 0);
        passes.get(&gpu, "b").expect("a pass");
        passes.get(&gpu, "b").expect("a pass");
        assert_eq!(compiled(), 1);
        passes.at(&gpu, 0).expect("a pass");
        assert_eq!(compiled(), 2);
        assert!(passes.get(&gpu, "c").is_err());
    }
}
