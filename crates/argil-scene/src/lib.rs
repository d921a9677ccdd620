#![doc = include_str!("crate.md")]
#![cfg_attr(doc, doc = include_str!("pictures/page.md"))]

mod action;
mod animate;
mod bounds;
mod camera_path;
mod camera_pose;
mod change;
mod clamp;
mod edit;
mod edit_checks;
mod edit_log;
mod edit_settings;
mod extent;
mod file;
mod finite_part;
mod group_summary;
mod history;
mod history_bake;
mod image_file;
mod import;
mod influence;
mod journal;
mod keyframe;
mod lighting;
mod loaded_grid;
mod material;
mod modified_region;
mod modifier;
mod morph_ramp;
mod node;
mod node_desc;
mod node_store;
mod node_tree;
mod nonzero_fill;
mod operator;
mod path2;
mod pose;
mod ramp;
mod ramp_fit;
mod sampled_grid;
mod scene;
mod scene_images;
mod shape;
mod shape_checks;
mod summarize;
mod symmetry;
mod validation;
pub use shape_checks::{is_grid, is_image};
mod margins;
mod shape_table;
mod text;
mod texture;
mod transform;
mod undo;
mod view;

pub use action::{Action, LogError};
pub use bounds::{Extents, evaluated_copies, nearest_is_own};
pub use camera_path::{CameraPath, PathPoint};
pub use camera_pose::CameraPose;
pub use change::SceneChange;
pub use clamp::Clamp;
pub use edit::{Edit, EditError, EditOutcome};
pub use extent::Extent;
#[cfg(feature = "schema")]
pub use file::schema;
pub use file::{
    FORMAT_VERSION, FileError, TEMP_PREFIX, TempFolder, remove_abandoned_files, remove_temp_files,
    write_atomically,
};
pub use history::HistoryLimit;
pub use history_bake::{FoldError, HistoryBake};
pub use image_file::{IMAGE_ENDINGS, LoadedImage, SceneImage};
pub use import::ImportError;
pub use influence::{blend_influence_radius, max_blend_propagation};
pub use journal::{Journal, JournalError, RecoveredSession};
pub use keyframe::{AxisAngle, Ease, Keyframe};
pub use lighting::{AmbientOcclusion, Environment, Fog, Lens, Light, MAX_LIGHTS, ToneCurve};
pub use loaded_grid::LoadedGrid;
pub use margins::MarginRequest;
pub use material::Material;
pub use modified_region::{WRAP_TRUSTED, WrapCopies, wrap_copies, wrap_core};
pub use modifier::{Modifier, half_angle_about_y};
pub use morph_ramp::MorphRamp;
pub use node::{Node, NodeId};
pub use node_desc::{NodeDesc, NodeKind};
pub use node_tree::{Brush, Group, NodeTree};
pub use nonzero_fill::{NestedPath, nonzero_fill};
pub use operator::{BlendProfile, Operator, OperatorKind};
pub use path2::{Path2, PathSegment, SplinePoint, TubeSegment, spline_segments};
pub use pose::{Pose, Poses};
pub use ramp::{Curve, Ramp};
pub use sampled_grid::{
    DistanceSampler, GRID_MAGIC, MAX_POSTS, SAMPLED_HEADER, SAMPLED_SIDE, SAMPLED_SUMMARY,
    SampledBlock, SampledGrid,
};
pub use scene::Scene;
pub use shape::{Exactness, Shape, ShapeParameter};
pub use text::text_outlines;
pub use texture::{ColorTexture, Mapping, Pattern, TextureSpace, Textures, ValueTexture};
pub use validation::{MAX_LENGTH, ValidationError};
pub use view::View;
