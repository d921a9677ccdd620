//! Budgets of edits, and reports on what edits did.

use argil_math::Aabb;
use web_time::Instant;

/// A limit on how much work [`World::apply_within`](crate::World::apply_within) does in one call.
///
/// ```
/// use argil::EditBudget;
/// let budget = EditBudget::new(2.0).near([0.0, 1.7, 5.0]);
/// assert_eq!(budget.max_ms, 2.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EditBudget {
    /// The time to spend, in milliseconds. A call may take longer by what it does between two looks at the clock: one brick, or a
    /// few pages of levels. On a GPU, the call submits as much work as it expects to run in that time. A software GPU keeps no
    /// budget: it works in the call, and compiles shaders for the first shape of a kind.
    pub max_ms: f64,
    /// Blocks near this point come first. It is usually the camera.
    pub priority_point: [f32; 3],
}

impl EditBudget {
    /// Creates a budget of milliseconds that starts with the blocks nearest to the origin.
    pub fn new(max_ms: f64) -> Self {
        Self {
            max_ms,
            priority_point: [0.0; 3],
        }
    }

    /// Starts with the blocks nearest to a point, which is usually the camera.
    #[must_use]
    pub fn near(self, priority_point: [f32; 3]) -> Self {
        Self {
            priority_point,
            ..self
        }
    }
}

/// What applying a scene's edits did to a world. [`World::flush`](crate::World::flush) returns the numbers of bricks, because it waits for a GPU.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct EditReport {
    /// Blocks of 4³ cells that remain to be rebuilt, if there was an [`EditBudget`]. The next call continues with them.
    pub remaining_blocks: u64,
    /// Outside this box, no distance within the stored band changed, and no material.
    pub dirty_box: Aabb,
    /// Duration in milliseconds. With a GPU, only the CPU's part.
    pub duration_ms: f64,
    /// Whether the whole world was rebuilt. Within a budget, this is so when a rebuild on another thread was taken over.
    pub rebuilt: bool,
    /// Whether the world is being rebuilt on another thread. It has its old shapes, and `remaining_blocks` is not 0. Later calls
    /// take the new world over.
    pub is_rebuilding: bool,
    /// The reason for the rebuild, if there is one.
    pub reason: Option<RebuildReason>,
}

impl EditReport {
    /// Returns the report of a call that built the whole world again, or took over what another thread had built.
    pub(crate) fn of_rebuild(reason: RebuildReason, start: Instant) -> Self {
        Self {
            remaining_blocks: 0,
            dirty_box: Aabb::ALL,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            rebuilt: true,
            is_rebuilding: false,
            reason: Some(reason),
        }
    }
}

/// The reason why the whole world was rebuilt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RebuildReason {
    /// The representation cannot be edited in place. Only sparse bricks and levels can.
    #[error(
        "only sparse bricks and levels can be edited in place, and this world has another representation"
    )]
    NotEditable,
    /// The scene reaches outside the volume's box. Only sparse bricks grow, and not if an infinite solid is clipped.
    #[error(
        "the scene reaches outside the volume's box; the new volume has a larger box and voxels of the same size"
    )]
    OutsideBox,
    /// An infinite solid, which the volume's box clips, was added or removed.
    #[error("the edit added or removed an infinite solid, which the volume's box clips")]
    Unbounded,
    /// Something changed that everything relies on: a material, an image, a mesh, or the bounds of the view. Or the largest solid,
    /// whose size bounds the error of arithmetic.
    #[error(
        "the edit changed materials, images, meshes, the bounds of the view, or the largest size"
    )]
    GlobalBounds,
    /// The world grew, and the edits were recorded with margins that are now too small.
    #[error(
        "the world has grown, and the edits were recorded with margins that are too small for it"
    )]
    DirtyMargin,
    /// The scene is not the one that the world was built from.
    #[error("the world was built from another scene")]
    OtherScene,
    /// The scene no longer has the changes that the world missed.
    #[error("the scene no longer has the changes that the world missed")]
    HistoryGone,
    /// The edit touches so much that a rebuild is as fast.
    #[error("the edit changes so much of the world that a rebuild is as fast")]
    TooLarge,
    /// The world's shaders were compiled for the scene before the edit.
    #[error("the world's shaders were compiled for the scene before the edit")]
    Specialized,
    /// A host dropped an encoder with edits.
    #[error("an encoder with edits was dropped before it was submitted")]
    NotSubmitted,
    /// An earlier edit failed halfway.
    #[error("an earlier edit failed halfway")]
    FailedEdit,
}
