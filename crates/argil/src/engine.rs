use crate::EngineError;
use crate::cache_folder;
use argil_gpu::{DeviceInfo, DeviceKind, Gpu, GpuCounters};
use argil_math::Control;
use std::sync::Arc;

/// The device to run on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[non_exhaustive]
pub enum Backend {
    /// A hardware GPU if there is one, and the CPU otherwise.
    #[default]
    Auto,
    /// The CPU, with all its cores.
    Cpu,
    /// A GPU, including a software one. Fails if there is none.
    Gpu,
}

/// A device that builds worlds. Cheap to clone.
///
/// [`Engine::auto`] selects one, and [`Engine::build`] starts a world.
#[derive(Clone, Debug)]
pub struct Engine {
    pub(crate) gpu: Option<Arc<Gpu>>,
    selection_reason: String,
    pub(crate) control: Control,
}

impl Engine {
    /// Creates an engine on the CPU.
    pub fn cpu() -> Self {
        Self {
            gpu: None,
            selection_reason: "the CPU was requested".into(),
            control: Control::default(),
        }
    }

    /// Creates an engine on a given back end, as a future.
    ///
    /// # Errors
    /// If `backend` requires a GPU and there is none, or it does not open.
    pub async fn with_backend_async(backend: Backend) -> Result<Self, EngineError> {
        match backend {
            Backend::Cpu => Ok(Self::cpu()),
            Backend::Gpu => {
                let gpu = open().await?;
                Ok(Self {
                    gpu: Some(Arc::new(gpu)),
                    selection_reason: "a GPU was requested".into(),
                    control: Control::default(),
                })
            }
            Backend::Auto => {
                let all = argil_gpu::devices().await;
                let real = all.into_iter().find(|d| d.kind.is_real_gpu());
                let Some(device) = real else {
                    return Ok(Self {
                        gpu: None,
                        selection_reason: "no hardware GPU was found".into(),
                        control: Control::default(),
                    });
                };
                match open().await {
                    Ok(gpu) => Ok(Self {
                        gpu: Some(Arc::new(gpu)),
                        selection_reason: format!("{} is a GPU", device.name),
                        control: Control::default(),
                    }),
                    Err(error) => Ok(Self {
                        gpu: None,
                        selection_reason: format!("{} cannot be used: {error}", device.name),
                        control: Control::default(),
                    }),
                }
            }
        }
    }

    /// Creates an engine on a GPU that is open already, such as one on the device of a program with its own renderer.
    ///
    /// ```
    /// # #[cfg(feature = "gpu")] {
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
    /// # }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn on_gpu(gpu: impl Into<Arc<Gpu>>) -> Self {
        Self {
            gpu: Some(gpu.into()),
            selection_reason: "the host gave a GPU".into(),
            control: Control::default(),
        }
    }

    /// Lists the graphics devices of this machine, as a future: see [`Engine::devices`].
    pub async fn devices_async() -> Vec<DeviceInfo> {
        argil_gpu::devices().await
    }

    /// Returns a human-readable description of the device.
    pub fn device(&self) -> String {
        match &self.gpu {
            Some(gpu) => format!("gpu: {}", gpu.info().name),
            None => format!("cpu: {} threads", rayon::current_num_threads()),
        }
    }

    /// Whether the engine is on a given device, so that images can stay there.
    #[cfg(feature = "gpu")]
    pub fn is_on(&self, device: &argil_gpu::wgpu::Device) -> bool {
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

    /// Returns an engine on the same device whose long work reports to a [`Control`], which can also cancel it.
    ///
    /// ```
    /// # use argil::prelude::*;
    /// let control = Control::new();
    /// let engine = Engine::cpu().with_control(&control);
    /// # let mut scene = Scene::new();
    /// # scene.push(Brush::new(Shape::sphere(0.5)))?;
    /// control.cancel();
    /// let built = engine.build(&scene)?.bricks(256);
    /// assert!(built.is_err_and(|error| error.is_cancelled()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_control(&self, control: &Control) -> Self {
        Self {
            control: control.clone(),
            ..self.clone()
        }
    }

    /// Returns the number of pixels of the largest image that the device can render.
    pub fn max_pixels(&self) -> u64 {
        let of_gpu = self.gpu.as_ref().map(|gpu| gpu.max_pixels());
        of_gpu.map_or(crate::limits::MAX_IMAGE_PIXELS, |most| {
            most.min(crate::limits::MAX_IMAGE_PIXELS)
        })
    }

    /// Returns the reason why this device was selected.
    pub fn selection_reason(&self) -> &str {
        &self.selection_reason
    }
}

/// Opens the best device. It keeps compiled pipelines where meshes keep their samples.
async fn open() -> Result<Gpu, argil_gpu::GpuError> {
    let gpu = Gpu::open().await?;
    Ok(match cache_folder() {
        Some(folder) => gpu.with_pipeline_cache(&folder.join("pipelines")),
        None => gpu,
    })
}
