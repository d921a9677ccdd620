/// The reason why the GPU cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter.
    #[error(
        "no GPU found. A software GPU also works: on Debian and Ubuntu, apt-get install mesa-vulkan-drivers libvulkan1; \
         or use the CPU"
    )]
    None,
    /// A [`Control`](argil_math::Control) canceled the work.
    #[error("canceled")]
    Cancelled,
    /// The adapter refuses the device.
    #[error("{name}: {reason}")]
    Device {
        /// Name of the adapter.
        name: String,
        /// The driver's message.
        reason: String,
    },
    /// A device that the host has opened lacks something.
    #[error(
        "{name} was opened without {lack}: open it with `Gpu::required_features` and `Gpu::required_limits`"
    )]
    Lacks {
        /// Name of the adapter.
        name: String,
        /// What is missing.
        lack: String,
    },
    /// A buffer or texture exceeds a limit.
    #[error(
        "{what} needs {bytes} bytes, and {name} allows {limit} per buffer: use the CPU or a smaller size"
    )]
    TooLarge {
        /// Name of the adapter.
        name: String,
        /// The buffer or texture.
        what: &'static str,
        /// Requested bytes.
        bytes: u64,
        /// The limit in bytes.
        limit: u64,
    },
    /// A pool of bricks would exceed the maximum texture size.
    #[error(
        "{bricks} bricks, and the textures of {name} hold at most {limit}: use the CPU or lower the resolution"
    )]
    TooManyBricks {
        /// Name of the adapter.
        name: String,
        /// Needed bricks.
        bricks: u64,
        /// The limit.
        limit: u64,
    },
    /// Bricks would exceed the memory budget.
    #[error(
        "{bricks} bricks and their tables need {} MiB, and the budget is {} MiB: lower the resolution or the bits, or raise the memory budget",
        needed.div_ceil(1 << 20),
        budget >> 20
    )]
    Budget {
        /// Needed bricks.
        bricks: u64,
        /// Needed bytes.
        needed: u64,
        /// The budget in bytes.
        budget: u64,
    },
    /// The representation cannot be meshed.
    #[error("this representation cannot be meshed: use the field, a dense volume or sparse bricks")]
    NotMeshable,
    /// Shaders of a host read sparse bricks and levels of detail only.
    #[error(
        "shaders of a host read bricks and levels, and not {name}: build the world as one of these"
    )]
    NoShaderVolume {
        /// Name of the representation.
        name: &'static str,
    },
    /// Shaders of a host were bound to another representation.
    #[error(
        "shaders of a host were bound to another representation: bind the world again, with `World::shader_volume`"
    )]
    OtherShaderVolume,
    /// An encoder with edits was dropped, so that the world does not match its scene, or it is still to be submitted.
    #[error(
        "an encoder with edits was dropped, or is not submitted yet: submit it first, or apply the scene again, which builds the world"
    )]
    NotSubmitted,
    /// Bricks store only the surface at distance 0.
    #[error("sparse bricks contain only the surface at distance 0")]
    UnsupportedIsoLevel,
    /// Bricks cannot be planned.
    #[error(transparent)]
    Bricks(#[from] argil_volume::BricksError),
    /// Folds, loops and joints nest too deep for the interpreter's fixed stacks.
    #[error(
        "the scene nests too deep for the GPU: it needs {needed} slots of {slots}. The CPU has no such limit: use the CPU"
    )]
    TooDeep {
        /// Available slots.
        slots: usize,
        /// Needed slots.
        needed: usize,
    },
    /// A software device would cut the program's loops short.
    #[error(
        "{name}: one evaluation of the scene takes {iterations} loop iterations, and this software device allows {limit}: use the CPU"
    )]
    TooLong {
        /// Name of the adapter.
        name: String,
        /// Iterations of one evaluation.
        iterations: u64,
        /// The limit.
        limit: u64,
    },
    /// Paths of light do not pass through a representation.
    #[error(
        "paths pass through the field, bricks and dense volumes, and not through {name}: choose one of these"
    )]
    NoPaths {
        /// Name of the representation.
        name: &'static str,
    },
    /// An image exceeds the maximum size of a texture.
    #[error(
        "{name}: the environment's image has {pixels} pixels along a side, and textures have at most {limit}: use the CPU or a smaller image"
    )]
    WideImage {
        /// Name of the adapter.
        name: String,
        /// Pixels along the longer side.
        pixels: u32,
        /// The limit.
        limit: u32,
    },
    /// An image has no pixels, or exceeds the maximum size of a texture.
    #[error("an image of {}x{} pixels: each side must be 1 to {limit}", size[0], size[1])]
    ImageSize {
        /// Requested width and height.
        size: [u32; 2],
        /// The limit.
        limit: u32,
    },
    /// An image is drawn into textures of another size.
    #[error(
        "an image of {}x{} pixels, and textures of {}x{}: create textures of the image's size",
        image[0], image[1], textures[0], textures[1]
    )]
    OtherSize {
        /// Width and height of the image.
        image: [u32; 2],
        /// Those of the textures.
        textures: [u32; 2],
    },
    /// The program is too long to be written out as a shader.
    #[error("the scene has too many brushes for a specialized shader: use the interpreter")]
    TooLongToSpecialize,
    /// A volume exceeds the maximum size of a 3D texture.
    #[error(
        "{name}: the volume has {voxels} voxels along a side, and textures have at most {limit}: use the CPU or lower the resolution"
    )]
    TooFine {
        /// Name of the adapter.
        name: String,
        /// Requested voxels along a side.
        voxels: u32,
        /// The limit.
        limit: u32,
    },
    /// The enumeration sort, which compares every pair of bricks, would take too long.
    #[error(
        "{codes} cells, and the enumeration sort takes at most {limit}: choose larger bricks, or the default sort"
    )]
    TooManyToEnumerate {
        /// Cells of the finest grid.
        codes: u32,
        /// The limit.
        limit: u32,
    },
    /// A shader did not compile, or a command was refused.
    #[error("{name}: {reason}")]
    Validation {
        /// Name of the adapter.
        name: String,
        /// wgpu's message.
        reason: String,
    },
    /// The device stopped responding.
    #[error("the GPU stopped responding: {0}")]
    Lost(String),
}

impl GpuError {
    /// Returns the error for a volume with inconsistent parts.
    pub(crate) fn odd_volume() -> Self {
        Self::Lost("the volume came back in parts that do not fit".into())
    }
}
