use std::path::PathBuf;

/// Why an engine could not be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// There is no GPU that can run Argil.
    #[error(transparent)]
    Gpu(#[from] argil_gpu::GpuError),
    /// Threads could not be started.
    #[error("threads: {0}")]
    Threads(String),
}

/// Why a scene could not be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The scene itself is at fault.
    #[error(transparent)]
    Scene(#[from] argil_field::LowerError),
    /// The GPU cannot hold it.
    #[error(transparent)]
    Gpu(#[from] argil_gpu::GpuError),
}

/// Why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The size is zero or too large.
    #[error(
        "size {width}x{height}: both sides must be from 1 to {} and their product at most {}",
        crate::world::MAX_SIDE,
        crate::world::MAX_PIXELS
    )]
    Size {
        /// Asked for.
        width: u32,
        /// Asked for.
        height: u32,
    },
    /// A setting is not a positive number, or out of its range.
    #[error("{name}: {value} is not {expected}")]
    Setting {
        /// Which.
        name: &'static str,
        /// Asked for.
        value: f64,
        /// What would be right.
        expected: &'static str,
    },
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] argil_gpu::GpuError),
}

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct PictureError {
    /// Where to.
    pub path: PathBuf,
    /// What went wrong.
    pub reason: String,
}
