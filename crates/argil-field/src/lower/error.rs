/// The reason why a scene cannot be lowered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LowerError {
    /// A twist or bend of an infinite solid: distances far from its axis would stretch without limit.
    #[error(
        "{path}: {what} needs a solid of finite size: intersect it with a box, limit its repetition, or use fewer modifiers before it"
    )]
    Infinite {
        /// The node, as in `brushes[3]`.
        path: String,
        /// The modifier.
        what: &'static str,
    },
    /// Copies overlap so much, or loops nest so deep, that each point would evaluate too many.
    #[error(
        "{path}: each point would be evaluated in {count} copies, and the limit is {limit}: increase the spacing"
    )]
    TooManyCopies {
        /// The node.
        path: String,
        /// The number of copies.
        count: u64,
        /// The limit for one repetition, or for all around a brush.
        limit: u64,
    },
    /// Instances within instances multiply to too many instructions.
    #[error(
        "{path}: its instances need {needed} instructions, and the limit is {limit}: use fewer instances, or simpler ones"
    )]
    TooManyInstances {
        /// The node.
        path: String,
        /// The number of instructions.
        needed: u64,
        /// The limit.
        limit: u64,
    },
    /// A mesh is not loaded.
    #[error("{path}: the mesh \"{file}\" is not loaded")]
    NotLoaded {
        /// The node.
        path: String,
        /// The mesh's file.
        file: String,
    },
    /// An image of a material's texture is not loaded.
    #[error("materials.{material}: the image \"{file}\" is not loaded")]
    ImageNotLoaded {
        /// Name of the material.
        material: String,
        /// The image's file.
        file: String,
    },
    /// Images of textures are too large together.
    #[error(
        "materials.{material}: with \"{file}\", images have more than {limit} pixels together: make them smaller"
    )]
    ImagesTooLarge {
        /// Name of the material.
        material: String,
        /// The image's file.
        file: String,
        /// The limit.
        limit: usize,
    },
    /// Nested scales multiply to a factor that `f32` distances cannot represent.
    #[error(
        "{path}: the scales of this node and its groups multiply to {scale:e}, beyond 1e-6 to 1e6"
    )]
    Scale {
        /// The node.
        path: String,
        /// The product.
        scale: f64,
    },
}

/// Maximum copies that one point may evaluate, over all loops around a brush.
pub(super) const MAX_COPIES: u64 = 4096;
/// Maximum instructions of a program with instances: half a gibibyte.
pub(super) const MAX_INSTRUCTIONS: u64 = 1 << 25;
/// Maximum copies in one loop.
pub(super) const MAX_COPIES_PER_LOOP: u64 = 125;
