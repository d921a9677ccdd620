use crate::EngineError;
use argil_gpu::{DeviceInfo, DeviceKind, Gpu};
use argil_math::Control;
use std::sync::Arc;

/// What to run on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[non_exhaustive]
pub enum Backend {
    /// A GPU where there is a real one, else the CPU.
    #[default]
    Auto,
    /// The CPU, all its cores.
    Cpu,
    /// A GPU, a software one included; an error where there is none.
    Gpu,
}

/// A device that worlds are built on. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Engine {
    pub(crate) gpu: Option<Arc<Gpu>>,
    selection_reason: String,
    pub(crate) control: Control,
}

impl Engine {
    /// The CPU.
    pub fn cpu() -> Self {
        Self {
            gpu: None,
            selection_reason: "the CPU was asked for".into(),
            control: Control::default(),
        }
    }

    /// [`Engine::with_backend`] as a future.
    ///
    /// # Errors
    /// If `backend` asks for a GPU and there is none, or it refuses to open.
    pub async fn with_backend_async(backend: Backend) -> Result<Self, EngineError> {
        match backend {
            Backend::Cpu => Ok(Self::cpu()),
            Backend::Gpu => {
                let gpu = Gpu::open().await?;
                Ok(Self {
                    gpu: Some(Arc::new(gpu)),
                    selection_reason: "a GPU was asked for".into(),
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
                match Gpu::open().await {
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

    /// [`Engine::devices`] as a future.
    pub async fn devices_async() -> Vec<DeviceInfo> {
        argil_gpu::devices().await
    }

    /// What the engine runs on, in words.
    pub fn device(&self) -> String {
        match &self.gpu {
            Some(gpu) => format!("gpu: {}", gpu.info().name),
            None => format!("cpu: {} threads", rayon::current_num_threads()),
        }
    }

    /// Whether that is a GPU, and of which kind.
    pub fn gpu_kind(&self) -> Option<DeviceKind> {
        self.gpu.as_ref().map(|gpu| gpu.info().kind)
    }

    /// The same engine, whose worlds' long work can be stopped and tells how far it is: building sparse bricks, and on the CPU dense
    /// volumes too.
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

    /// Pixels of the largest picture that it draws: a device's buffers have their limits.
    pub fn max_pixels(&self) -> u64 {
        let of_gpu = self.gpu.as_ref().map(|gpu| gpu.max_pixels());
        of_gpu.map_or(crate::limits::MAX_IMAGE_PIXELS, |most| {
            most.min(crate::limits::MAX_IMAGE_PIXELS)
        })
    }

    /// Why the engine runs on that.
    pub fn reason(&self) -> &str {
        &self.selection_reason
    }
}
