//! Engines on GPUs.

use super::{Backend, Engine};
use crate::{EngineError, cache_folder};
use argil_gpu::{DeviceInfo, DeviceKind, Gpu, GpuCounters, GpuError, wgpu};
use std::sync::Arc;

impl Engine {
    /// Creates an engine on a given back end, as a future.
    ///
    /// # Errors
    /// If `backend` requires a GPU and there is none, or it does not open.
    pub async fn with_backend_async(backend: Backend) -> Result<Self, EngineError> {
        match backend {
            Backend::Cpu => Ok(Self::cpu()),
            Backend::Gpu => Ok(Self::with_gpu(open().await?, "a GPU was requested")),
            Backend::Auto => {
                let devices = argil_gpu::devices().await;
                let hardware = devices.into_iter().find(|d| d.kind.is_real_gpu());
                let Some(DeviceInfo { name, .. }) = hardware else {
                    return Ok(Self::cpu().selected_for("no hardware GPU was found"));
                };
                Ok(match open().await {
                    Ok(gpu) => Self::with_gpu(gpu, format!("{name} is a GPU")),
                    Err(error) => {
                        Self::cpu().selected_for(format!("{name} cannot be used: {error}"))
                    }
                })
            }
        }
    }

    fn with_gpu(gpu: impl Into<Arc<Gpu>>, reason: impl Into<String>) -> Self {
        Self {
            gpu: Some(gpu.into()),
            ..Self::cpu().selected_for(reason)
        }
    }

    fn selected_for(self, reason: impl Into<String>) -> Self {
        Self {
            selection_reason: reason.into(),
            ..self
        }
    }

    /// Creates an engine on a GPU that is open already, such as one on the device of a program with its own renderer.
    ///
    /// ```
    /// use argil::gpu::{Gpu, wgpu};
    /// use argil::prelude::*;
    /// # fn host_device() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn std::error::Error>> {
    /// #     let instance = wgpu::Instance::default();
    /// #     let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    /// #     let descriptor = wgpu::DeviceDescriptor {
    /// #         required_limits: Gpu::required_limits(&adapter),
    /// #         ..Default::default()
    /// #     };
    /// #     Ok(pollster::block_on(adapter.request_device(&descriptor))?)
    /// # }
    /// let (device, queue) = host_device()?;
    /// let engine = Engine::on_gpu(Gpu::from_wgpu(device, queue)?);
    /// let mut scene = Scene::new();
    /// scene.push(Shape::sphere(0.5))?;
    /// let world = engine.build(&scene)?.bricks(32)?;
    /// # let _ = world;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn on_gpu(gpu: impl Into<Arc<Gpu>>) -> Self {
        Self::with_gpu(gpu, "the host gave a GPU")
    }

    /// Lists the graphics devices of this machine, as a future: see [`Engine::devices`].
    pub async fn devices_async() -> Vec<DeviceInfo> {
        argil_gpu::devices().await
    }

    /// Whether the engine is on a given device, so that images can stay there.
    pub fn is_on(&self, device: &wgpu::Device) -> bool {
        self.gpu.as_ref().is_some_and(|gpu| gpu.is_on(device))
    }

    /// Returns the kind of GPU, or `None` on the CPU.
    pub fn gpu_kind(&self) -> Option<DeviceKind> {
        self.gpu.as_ref().map(|gpu| gpu.info().kind)
    }

    /// Returns what the GPU has been asked to do since it was opened, or `None` on the CPU. The difference between two calls is
    /// what the work in between took.
    pub fn gpu_counters(&self) -> Option<GpuCounters> {
        self.gpu.as_ref().map(|gpu| gpu.counters())
    }
}

/// Opens the best device. It keeps compiled pipelines where meshes keep their samples.
async fn open() -> Result<Gpu, GpuError> {
    let gpu = Gpu::open().await?;
    Ok(match cache_folder() {
        Some(folder) => gpu.with_pipeline_cache(&folder.join("pipelines")),
        None => gpu,
    })
}
