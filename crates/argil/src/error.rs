use argil_volume::BricksError;
use std::path::PathBuf;

/// The reason why an engine cannot be created.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// There is no GPU that can run Argil.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] argil_gpu::GpuError),
    /// The program was compiled without GPU support.
    #[error("this program was compiled without GPU support (the feature `gpu`): use the CPU")]
    NoGpuSupport,
    /// Threads cannot be started.
    #[error("threads: {0}")]
    Threads(String),
}

/// The reason why a world cannot be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The scene exceeds a limit.
    #[error(transparent)]
    Scene(#[from] argil_field::LowerError),
    /// The GPU cannot hold it, or failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] argil_gpu::GpuError),
    /// A host's encoder needs a world on its device.
    #[error("the world is on the CPU: build it with `Engine::on_gpu` and the device of the host")]
    NotOnGpu,
    /// The resolution is out of range.
    #[error(transparent)]
    Resolution(#[from] argil_volume::ResolutionError),
    /// The voxel size is out of range.
    #[error(transparent)]
    VoxelSize(#[from] argil_volume::VoxelSizeError),
    /// The octree's options are invalid.
    #[error(transparent)]
    Octree(#[from] argil_volume::OctreeError),
    /// The bricks' options are invalid, or the bricks exceed the memory budget.
    #[error(transparent)]
    Bricks(#[from] BricksError),
    /// A [`Control`](argil_math::Control) canceled the work.
    #[error("canceled")]
    Cancelled,
    /// The stored band is out of range.
    #[error("band of {0} voxels: choose 0.5 to 4096 voxels")]
    Band(f32),
    /// The size of a voxel that a ray accepts is out of range.
    #[error("pixel error {0}: choose 0.125 to 1024 pixels")]
    PixelError(f32),
    /// The volume exceeds the free memory.
    #[error(
        "the volume needs {} MiB, and {} MiB of memory are free: lower the resolution",
        needed >> 20,
        available >> 20
    )]
    Memory {
        /// Bytes that the volume needs.
        needed: u64,
        /// Bytes that are free.
        available: u64,
    },
}

impl BuildError {
    /// Whether a [`Control`](argil_math::Control) canceled the work.
    pub fn is_cancelled(&self) -> bool {
        match self {
            Self::Cancelled | Self::Bricks(BricksError::Cancelled) => true,
            #[cfg(feature = "gpu")]
            Self::Gpu(argil_gpu::GpuError::Cancelled) => true,
            _ => false,
        }
    }

    /// Whether there was too little memory.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn lacks_memory(&self) -> bool {
        matches!(self, Self::Memory { .. }) || self.exceeded_budget().is_some()
    }

    /// Returns the bytes that bricks need and the budget that they exceed, if that is the reason.
    pub(crate) fn exceeded_budget(&self) -> Option<[u64; 2]> {
        match *self {
            Self::Bricks(BricksError::Budget { needed, budget, .. }) => Some([needed, budget]),
            #[cfg(feature = "gpu")]
            Self::Gpu(argil_gpu::GpuError::Budget { needed, budget, .. }) => Some([needed, budget]),
            _ => None,
        }
    }
}

/// The reason why a volume file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeFileError {
    /// The file cannot be read, or is damaged.
    #[error(transparent)]
    File(#[from] argil_volume::VolumeError),
    /// The scene in the file cannot be read.
    #[error(transparent)]
    Scene(#[from] argil_scene::FileError),
    /// A mesh that the scene names cannot be loaded.
    #[error(transparent)]
    Mesh(#[from] crate::MeshFileError),
    /// The world cannot be built on this device.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The world has no volume to write.
    #[error("the world has no volume: build one first")]
    NoVolume,
    /// Levels of detail have no file: which bricks they hold depends on a view.
    #[error("levels of detail cannot be saved: build bricks, a dense volume or an octree")]
    Levels,
    /// The volume lags behind its scene, because [`World::apply_within`](crate::World::apply_within) ran out of time.
    #[error("{blocks} blocks of the last edits are not updated yet: call `World::flush` first")]
    UnfinishedEdits {
        /// Number of blocks that remain.
        blocks: u64,
    },
    /// The file cannot be written.
    #[error("cannot write {path}")]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
}

/// The reason why a grid cannot be sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// The output has another length than the grid has points.
    #[error("the grid has {points} points, and the slice has room for {len} distances")]
    Length {
        /// Number of points of the grid.
        points: usize,
        /// Length of the output.
        len: usize,
    },
    /// The grid's corner or spacing is not finite.
    #[error("the grid's corner and spacing must be finite")]
    NotFinite,
}

/// The reason why an image cannot be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The image size is zero or too large.
    #[error(
        "size {width}x{height}: each side must be 1 to {} and their product at most {}",
        crate::limits::MAX_IMAGE_SIDE,
        crate::limits::MAX_IMAGE_PIXELS
    )]
    Size {
        /// Requested width in pixels.
        width: u32,
        /// Requested height in pixels.
        height: u32,
    },
    /// A setting is out of range.
    #[error("{name}: {value} is not {expected}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// Requested value.
        value: f64,
        /// Expected range.
        expected: &'static str,
    },
    /// The render mode shows bricks, nodes or levels, and the representation has none.
    #[error(
        "sparse bricks, levels and octrees have bricks to show, only octrees have nodes, and only levels have levels"
    )]
    NoBricks,
    /// A [`Control`](argil_math::Control) canceled the work.
    #[error("canceled")]
    Cancelled,
    /// A host's frame needs a world on its device.
    #[error("the world is on the CPU: build it with `Engine::on_gpu` and the device of the host")]
    NotOnGpu,
    /// A host draws triangles itself.
    #[error("the world consists of triangles: draw them, or choose the field or a volume")]
    Triangles,
    /// A matrix does not project.
    #[error("the matrix is no projection: it must be finite and have an inverse")]
    NoProjection,
    /// The GPU failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] argil_gpu::GpuError),
}

/// The reason why an image file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct ImageFileError {
    /// Path of the file.
    pub path: PathBuf,
    /// What went wrong.
    pub reason: String,
}
