use crate::RenderError;
use argil_render::EnvironmentNotLoaded;

/// The reason why a still cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StillError {
    /// A setting is out of range.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The representation has nothing that paths pass through.
    #[error(
        "paths pass through the field, bricks and dense volumes, and not through {0}: choose one of these"
    )]
    Representation(&'static str),
    /// A still that is to be refined has another size than the settings.
    #[error("the still has another size than the settings")]
    Size,
    /// The image of the environment is not loaded.
    #[error(transparent)]
    Environment(#[from] EnvironmentNotLoaded),
    /// The device cannot trace the paths.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] argil_gpu::GpuError),
}
