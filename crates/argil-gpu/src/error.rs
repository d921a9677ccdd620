/// Why the GPU cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter of any kind.
    #[error(
        "no GPU was found. A software one will do: on Debian and Ubuntu, apt-get install mesa-vulkan-drivers libvulkan1; \
         or use the CPU"
    )]
    None,
    /// Somebody has [cancelled](argil_math::Control::cancel) it.
    #[error("cancelled")]
    Cancelled,
    /// This program has no part for GPUs.
    #[error("this program was compiled without GPUs (the feature `gpu`): use the CPU")]
    LeftOut,
    /// The adapter does not give a device.
    #[error("{name}: {reason}")]
    Device {
        /// The adapter.
        name: String,
        /// What its driver said.
        reason: String,
    },
    /// Something does not fit.
    #[error(
        "{what} takes {bytes} bytes, more than {name} allows in one buffer, {limit}: use the CPU or a smaller size"
    )]
    TooLarge {
        /// The adapter.
        name: String,
        /// The table or picture.
        what: &'static str,
        /// Asked for.
        bytes: u64,
        /// The most that is allowed.
        limit: u64,
    },
    /// A pool of bricks would be larger than a texture can be.
    #[error(
        "{bricks} bricks, and the textures of {name} have room for {limit}: use the CPU or a smaller resolution"
    )]
    TooManyBricks {
        /// The adapter.
        name: String,
        /// Bricks that are needed.
        bricks: u64,
        /// Bricks there is room for.
        limit: u64,
    },
    /// Bricks would take more memory than they may.
    #[error(
        "{bricks} bricks and their tables take {} MiB, and the budget is {} MiB: take a smaller resolution, fewer bits, or a larger memory budget",
        needed.div_ceil(1 << 20),
        budget >> 20
    )]
    Budget {
        /// Bricks that are needed.
        bricks: u64,
        /// Bytes that they take.
        needed: u64,
        /// Bytes that they may take.
        budget: u64,
    },
    /// Some representations have no triangles of their own.
    #[error("this volume is not cut into triangles: take the field, a dense volume or bricks")]
    NotMarched,
    /// Bricks hold one surface.
    #[error("bricks hold the surface at distance 0 alone")]
    OtherLevel,
    /// Bricks cannot be planned.
    #[error(transparent)]
    Bricks(#[from] argil_volume::BricksError),
    /// Folds, loops and joints nest too deep for the interpreter's fixed stacks.
    #[error(
        "the scene nests deeper than the GPU's {slots} slots: it needs {needed}. The CPU has no such limit: use the CPU"
    )]
    TooDeep {
        /// Slots there are.
        slots: usize,
        /// Slots needed.
        needed: usize,
    },
    /// A software device would cut the program's loops short.
    #[error(
        "{name}: one evaluation of the scene takes {iterations} loop iterations, and this software device allows {limit}: use the CPU"
    )]
    TooLong {
        /// The adapter.
        name: String,
        /// Of one evaluation.
        iterations: u64,
        /// The most that is allowed.
        limit: u64,
    },
    /// The program is too long to be written out as a shader.
    #[error("the scene has too many brushes to be specialized into a shader: use the interpreter")]
    TooLongToSpecialize,
    /// A volume is larger than a 3D texture can be.
    #[error(
        "{name}: a volume of {voxels} voxels along a side, and textures there have at most {limit}: use the CPU or a smaller resolution"
    )]
    TooFine {
        /// The adapter.
        name: String,
        /// Asked for.
        voxels: u32,
        /// The most that is allowed.
        limit: u32,
    },
    /// The enumeration sort compares each brick with each other, in one thread a brick.
    #[error(
        "{codes} cells for the enumeration sort, which takes at most {limit}: take larger bricks, or the default way"
    )]
    TooManyToEnumerate {
        /// Cells of the finest grid.
        codes: u32,
        /// The most that is allowed.
        limit: u32,
    },
    /// A shader did not compile or a command was refused.
    #[error("{name}: {reason}")]
    Refused {
        /// The adapter.
        name: String,
        /// What wgpu said.
        reason: String,
    },
    /// The device stopped.
    #[error("the GPU stopped answering: {0}")]
    Lost(String),
}

#[cfg(feature = "device")]
impl GpuError {
    /// A volume whose parts do not fit one another.
    pub(crate) fn odd_volume() -> Self {
        Self::Lost("the volume came back in parts that do not fit".into())
    }
}
