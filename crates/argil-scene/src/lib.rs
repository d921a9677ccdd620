//! Scenes made of brushes: what is in a world, in an artist's words.
//!
//! *Theory.* A scene is an ordered list (Evans, "Learning from failure", 2015): each brush acts on all that stands
//! above it in its group, by union, subtraction, intersection, paint or morph, hard or with a blend radius. A list and
//! not a tree, since lists with local culling scale.
//!
//! *Practice.* [`Scene`] owns the brushes and groups and the history of edits; each [`Edit`] yields the box outside
//! which no distance changes. Scenes are read and written as JSON ([`Scene::open`], [`Scene::save`]). Nothing here
//! knows how distances are evaluated.
//!
//! ```
//! use argil_scene::{Brush, Scene, Shape};
//! let mut scene = Scene::new();
//! scene.push(Brush::new(Shape::sphere(1.0)))?;
//! let cut = scene.push(Brush::new(Shape::sphere(0.5)).at([0.0, 1.0, 0.0]).subtract().blend(0.1))?;
//! assert!(cut.dirty_box.contains([0.0, 1.0, 0.0].into()));
//! assert!(scene.undo());
//! # Ok::<(), argil_scene::EditError>(())
//! ```

mod action;
mod animate;
mod change;
mod crowd;
mod crowds;
mod edit;
mod edit_checks;
mod entry;
mod extent;
mod fault;
mod file;
mod history;
mod import;
mod influence;
mod journal;
mod keyframe;
mod log;
mod material;
mod mesh_grid;
mod modifier;
mod node;
mod nodes;
mod operator;
mod outline;
mod sampled;
mod scene;
mod shape;
mod shape_rules;
pub use shape_rules::{is_grid, is_image};
mod shape_table;
mod text;
mod transform;
mod undo;
mod view;
mod watch;

pub use action::{Action, LogError, Subtree};
pub use change::Change;
pub use edit::{Edit, EditError, Edited};
pub use entry::{Body, Brush, Entry, Group};
pub use extent::{Extent, Extents, copies_looked_at};
pub use fault::{Fault, MAX_LENGTH};
#[cfg(feature = "schema")]
pub use file::schema;
pub use file::{FORMAT_VERSION, FileError, remove_unfinished_files, replace_file};
pub use history::HistoryLimit;
pub use import::ImportError;
pub use influence::{blend_reach, greatest_fall};
pub use journal::{Journal, JournalError, Recovered};
pub use keyframe::{Ease, Keyframe, Turn};
pub use material::Material;
pub use mesh_grid::MeshGrid;
pub use modifier::{Modifier, angular_half_extent, twist_stretch};
pub use node::{Node, NodeId};
pub use operator::{Operator, OperatorKind, Profile};
pub use outline::{Outline, Piece, SplinePoint, TubePiece, spline_pieces};
pub use sampled::{
    GRID_MAGIC, MOST_POSTS, Measure, SAMPLED_HEADER, SAMPLED_SIDE, SampledBlock, SampledGrid,
};
pub use scene::Scene;
pub use shape::{Exactness, Shape, ShapeParameter};
pub use text::text_outlines;
pub use view::{Placement, View};
pub use watch::Watch;
