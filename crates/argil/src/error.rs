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
    /// No volume has that many voxels.
    #[error(transparent)]
    Resolution(#[from] argil_volume::ResolutionError),
    /// No volume has voxels of that size.
    #[error(transparent)]
    Voxel(#[from] argil_volume::VoxelSizeError),
    /// No octree can be like that.
    #[error(transparent)]
    Octree(#[from] argil_volume::OctreeError),
    /// No sparse bricks can be like that, or they take more than they may.
    #[error(transparent)]
    Bricks(#[from] argil_volume::BricksError),
    /// Somebody has [cancelled](argil_math::Control::cancel) it.
    #[error("cancelled")]
    Cancelled,
    /// What 1.0 stands for makes no sense.
    #[error("a band of {0} voxels: stored distances reach from 0.5 to 4096 voxels")]
    Range(f32),
    /// It would not fit into memory.
    #[error(
        "the volume takes {} MiB, and {} MiB of memory are free: take a smaller resolution",
        needed >> 20,
        available >> 20
    )]
    Memory {
        /// Bytes that it takes.
        needed: u64,
        /// Bytes that are free.
        available: u64,
    },
}

impl BuildError {
    /// Whether it was [cancelled](argil_math::Control::cancel), wherever.
    pub fn is_cancelled(&self) -> bool {
        use argil_volume::BricksError;
        matches!(
            self,
            Self::Cancelled
                | Self::Bricks(BricksError::Cancelled)
                | Self::Gpu(argil_gpu::GpuError::Cancelled)
        )
    }
}

/// Why a volume file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeFileError {
    /// The file cannot be read, or is not what it should be.
    #[error(transparent)]
    File(#[from] argil_volume::VolumeError),
    /// The scene in it cannot be read.
    #[error(transparent)]
    Scene(#[from] argil_scene::FileError),
    /// A mesh that the scene names cannot be loaded.
    #[error(transparent)]
    Mesh(#[from] crate::MeshFileError),
    /// It cannot be built here.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The world is its field: there is no volume to be written.
    #[error("there is no volume: build one first")]
    NoVolume,
    /// It cannot be written.
    #[error("{path}")]
    Write {
        /// Where to.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Why distances cannot be sampled on a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// There is not one number for each point.
    #[error("the grid has {points} points, and there is room for {numbers} distances")]
    Length {
        /// Points of the grid.
        points: usize,
        /// Numbers that there is room for.
        numbers: usize,
    },
    /// Its corner or its spacing is no number.
    #[error("the grid's corner and spacing must be finite numbers")]
    NotFinite,
}

/// Why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The size is zero or too large.
    #[error(
        "size {width}x{height}: both sides must be from 1 to {} and their product at most {}",
        crate::limits::MAX_IMAGE_SIDE,
        crate::limits::MAX_IMAGE_PIXELS
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
    /// There is nothing of the kind to be shown.
    #[error("bricks can be shown of sparse bricks and octrees, nodes of octrees only")]
    NoBricks,
    /// Somebody has [cancelled](argil_math::Control::cancel) it.
    #[error("cancelled")]
    Cancelled,
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] argil_gpu::GpuError),
}

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct ImageFileError {
    /// Where to.
    pub path: PathBuf,
    /// What went wrong.
    pub reason: String,
}
