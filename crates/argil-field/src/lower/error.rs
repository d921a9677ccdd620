/// Why a scene cannot be lowered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LowerError {
    /// A twist or bend of something endless: distances far from its axis would be stretched without limit.
    #[error(
        "{path}: a {what} needs a solid of finite size: intersect it with a box, or limit its repetition"
    )]
    Endless {
        /// The node, as in `brushes[3]`.
        path: String,
        /// Twist or bend.
        what: &'static str,
    },
    /// Copies overlap so much, or loops nest so deep, that too many would be looked at for each point.
    #[error(
        "{path}: {count} copies would be looked at for each point, more than the limit, {limit}: widen the spacing"
    )]
    TooManyCopies {
        /// The node.
        path: String,
        /// How many.
        count: u64,
        /// Most that there may be: of one repetition, or of all around a brush.
        limit: u64,
    },
    /// A mesh that was not loaded.
    #[error("{path}: the mesh \"{file}\" is not loaded")]
    NotLoaded {
        /// The node.
        path: String,
        /// The mesh's file.
        file: String,
    },
    /// Nested scales multiply to something that `f32` distances cannot carry.
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

/// Most copies that one point may be compared with, over all loops around a brush.
pub(super) const MAX_COPIES: u64 = 4096;
/// Most of them in one loop.
pub(super) const MAX_COPIES_PER_LOOP: u64 = 125;
