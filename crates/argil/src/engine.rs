//! Devices on which worlds are built.

#[cfg(feature = "gpu")]
mod gpu;

#[cfg(not(feature = "gpu"))]
use crate::EngineError;
use crate::limits::MAX_IMAGE_PIXELS;
use argil_math::Control;

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
    #[cfg(feature = "gpu")]
    pub(crate) gpu: Option<std::sync::Arc<argil_gpu::Gpu>>,
    selection_reason: String,
    pub(crate) control: Control,
}

impl Engine {
    /// Creates an engine on the CPU.
    pub fn cpu() -> Self {
        Self {
            #[cfg(feature = "gpu")]
            gpu: None,
            selection_reason: "the CPU was requested".into(),
            control: Control::default(),
        }
    }

    /// Creates an engine on a given back end, as a future.
    ///
    /// # Errors
    /// If `backend` requires a GPU and there is none, or it does not open.
    #[cfg(not(feature = "gpu"))]
    pub async fn with_backend_async(backend: Backend) -> Result<Self, EngineError> {
        match backend {
            Backend::Gpu => Err(EngineError::NoGpuSupport),
            Backend::Cpu => Ok(Self::cpu()),
            Backend::Auto => Ok(Self {
                selection_reason: "this program was compiled without GPU support".into(),
                ..Self::cpu()
            }),
        }
    }

    /// Returns a human-readable description of the device.
    pub fn device(&self) -> String {
        #[cfg(feature = "gpu")]
        if let Some(gpu) = &self.gpu {
            return format!("gpu: {}", gpu.info().name);
        }
        format!("cpu: {} threads", rayon::current_num_threads())
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

    /// Whether the engine is on a GPU, which may be a software one.
    pub(crate) fn is_gpu(&self) -> bool {
        #[cfg(feature = "gpu")]
        return self.gpu.is_some();
        #[cfg(not(feature = "gpu"))]
        return false;
    }

    /// Whether volumes live in other memory than the machine's.
    pub(crate) fn has_own_memory(&self) -> bool {
        #[cfg(feature = "gpu")]
        return self.gpu_kind().is_some_and(|kind| kind.is_real_gpu());
        #[cfg(not(feature = "gpu"))]
        return false;
    }

    /// Returns the number of pixels of the largest image that the device can render.
    pub fn max_pixels(&self) -> u64 {
        #[cfg(feature = "gpu")]
        if let Some(gpu) = &self.gpu {
            return gpu.max_pixels().min(MAX_IMAGE_PIXELS);
        }
        MAX_IMAGE_PIXELS
    }

    /// Returns the reason why this device was selected.
    pub fn selection_reason(&self) -> &str {
        &self.selection_reason
    }
}
