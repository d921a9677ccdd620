#![doc = include_str!("crate.md")]
#![cfg_attr(doc, doc = include_str!("pictures/page.md"))]

mod action;
mod animate;
mod bounds;
mod camera_path;
mod camera_pose;
mod change;
mod edit;
mod edit_checks;
mod edit_log;
mod file;
mod finite_part;
mod group_summary;
mod history;
mod import;
mod influence;
mod journal;
mod keyframe;
mod loaded_grid;
mod material;
mod modifier;
mod node;
mod node_desc;
mod node_store;
mod node_tree;
mod operator;
mod path2;
mod pose;
mod sampled_grid;
mod scene;
mod shape;
mod shape_checks;
mod summarize;
mod validation;
pub use shape_checks::{is_grid, is_image};
mod margins;
mod shape_table;
mod text;
mod transform;
mod undo;
mod view;

pub use action::{Action, LogError};
pub use bounds::{Extent, Extents, evaluated_copies};
pub use camera_path::{CameraPath, PathPoint};
pub use camera_pose::CameraPose;
pub use change::SceneChange;
pub use edit::{Edit, EditError, EditOutcome};
#[cfg(feature = "schema")]
pub use file::schema;
pub use file::{FORMAT_VERSION, FileError, TempFolder, remove_temp_files, write_atomically};
pub use history::HistoryLimit;
pub use import::ImportError;
pub use influence::{blend_influence_radius, max_blend_propagation};
pub use journal::{Journal, JournalError, RecoveredSession};
pub use keyframe::{AxisAngle, Ease, Keyframe};
pub use loaded_grid::LoadedGrid;
pub use margins::MarginRequest;
pub use material::Material;
pub use modifier::{Modifier, half_angle_about_y, twist_stretch};
pub use node::{Node, NodeId};
pub use node_desc::{NodeDesc, NodeKind};
pub use node_tree::{Brush, Group, NodeTree};
pub use operator::{BlendProfile, Operator, OperatorKind};
pub use path2::{Path2, PathSegment, SplinePoint, TubeSegment, spline_segments};
pub use pose::{Pose, Poses};
pub use sampled_grid::{
    DistanceSampler, GRID_MAGIC, MAX_POSTS, SAMPLED_HEADER, SAMPLED_SIDE, SampledBlock, SampledGrid,
};
pub use scene::Scene;
pub use shape::{Exactness, Shape, ShapeParameter};
pub use text::text_outlines;
pub use validation::{MAX_LENGTH, ValidationError};
pub use view::View;
