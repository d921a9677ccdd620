//! Malleable environments made of signed distance fields.
//!
//! A [`Scene`] is an ordered list of brushes. An [`Engine`] runs on a GPU or on the CPU; a [`World`] is a scene that it
//! has built, to be asked for distances and drawn.
//!
//! ```
//! use argil::{Brush, Engine, Scene, Shape};
//! let mut scene = Scene::new();
//! scene.push(Brush::new(Shape::sphere(0.5)))?;
//! scene.push(Brush::new(Shape::sphere(0.2)).at([0.0, 0.4, 0.0]).subtract().blend(0.05))?;
//! let world = Engine::cpu().build(&scene)?.field();
//! println!("{} from the surface", world.distance([1.0, 0.0, 0.0]));
//! let picture = world.render(&world.camera(), [64, 48])?;
//! # assert_eq!(picture.size, [64, 48]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(not(target_arch = "wasm32"))]
mod blocking;
mod build;
mod cast;
mod edit_session;
mod engine;
mod error;
mod field_mesh;
mod heightmap;
mod image;
mod limits;
mod memory;
mod mesh_assets;
#[cfg(feature = "mesh-files")]
mod mesh_cache;
mod meshing;
mod observers;
mod probe;
mod program_cache;
mod query;
mod rendering;
mod representation;
mod volume_io;
mod world;

/// The crates below, with everything that signatures here name.
pub mod crates {
    pub use argil_abi as abi;
    pub use argil_field as field;
    pub use argil_gpu as gpu;
    pub use argil_math as math;
    pub use argil_mesh as mesh;
    pub use argil_render as render;
    pub use argil_scene as scene;
    pub use argil_volume as volume;
}

pub use argil_field::{FAR, Grid, LowerError, Program};
pub use argil_gpu::{BrickOrdering, DenseFill, DeviceInfo, DeviceKind, GpuError};
pub use argil_math::{Aabb, Control, Interval, Progress};
pub use argil_mesh::marching::surface::SurfaceError;
pub use argil_mesh::{
    Mesh, MeshFormat, MeshReadError, MeshReport, MeshSdf, MeshWriteOptions, RepairReport, UpAxis,
    read as read_mesh, thicken, write as write_mesh,
};
pub use argil_render::{
    Camera, LookupStart, NormalSource, Percentiles, RayStatistics, RenderMode, RenderSettings,
};
#[cfg(feature = "schema")]
pub use argil_scene::schema;
pub use argil_scene::{
    Action, AxisAngle, BlendProfile, Brush, CameraPose, Ease, Edit, EditError, EditOutcome,
    Exactness, FileError, Group, HistoryLimit, ImportError, Journal, JournalError, Keyframe,
    LoadedGrid, LogError, MarginRequest, Material, Modifier, Node, NodeDesc, NodeId, NodeKind,
    NodeTree, Operator, OperatorKind, Path2, PathSegment, RecoveredSession, SampledGrid, Scene,
    SceneChange, Shape, SplinePoint, ValidationError, View, is_image, remove_temp_files,
    write_atomically,
};
pub use argil_volume::{
    Band, Brick, BrickChanges, BrickInfo, BrickLayout, BrickSettings, BrickTest, Bricks,
    BricksError, Cell, Dense, EditStats, Encoding, Octree, OctreeError, OctreeInfo, OctreeLayout,
    OctreeSettings, ResolutionError, SampleFormat, Section, TooFarError, Volume, VolumeError,
    VolumeFile, VolumeInfo, VoxelGrid, VoxelSizeError,
};
pub use build::Build;
pub use cast::RayHit;
pub use edit_session::{EditBudget, EditReport, RebuildReason};
pub use engine::{Backend, Engine};
pub use error::{BuildError, EngineError, GridError, ImageFileError, RenderError, VolumeFileError};
pub use field_mesh::MeshMethod;
pub use glam;
pub use image::RenderedImage;
#[cfg(feature = "png")]
pub use image::{PngImage, read_png, save_png, write_png};
pub use mesh_assets::{
    LoadedMesh, MeshFileError, load_meshes, load_meshes_from_bytes, load_meshes_with_control,
};
pub use meshing::{MeshError, MeshNormals, MeshOptions, MeshOutput, save_mesh};
pub use observers::SubscriptionId;
pub use query::{BoxPosition, ClosestPoint, MAX_BOXES, Query};
pub use rendering::Orbit;
pub use representation::{
    BricksOptions, BuildTimings, DenseOptions, MeshRenderOptions, OctreeOptions, Representation,
};
pub use volume_io::stored_scene;
pub use world::World;
