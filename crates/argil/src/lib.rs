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
mod drawing;
mod engine;
mod error;
mod field_mesh;
mod heightmap;
mod limits;
mod listeners;
mod live;
mod lowered;
mod memory;
#[cfg(feature = "mesh-files")]
mod mesh_cache;
mod meshes;
mod picture;
mod probe;
mod query;
mod representation;
mod stored;
mod triangles;
mod world;

/// The crates below, with everything that signatures here name.
pub mod crates {
    pub use argil_abi as abi;
    pub use argil_field as field;
    pub use argil_gpu as gpu;
    pub use argil_march as march;
    pub use argil_math as math;
    pub use argil_mesh as mesh;
    pub use argil_scene as scene;
    pub use argil_volume as volume;
}

pub use argil_field::{FAR, Grid, LowerError, Program};
pub use argil_gpu::{DenseFill, DeviceInfo, DeviceKind, GpuError, Order};
pub use argil_march::{Camera, Descent, Normals, Settings, Show, Spread, Statistics};
pub use argil_math::{Aabb, Control, Interval, Progress};
pub use argil_mesh::marching::surface::SurfaceError;
pub use argil_mesh::{
    Axes, Format, Mesh, MeshInput, Repairs, Report, Solid, WriteOptions, read as read_mesh,
    thicken, write as write_mesh,
};
#[cfg(feature = "schema")]
pub use argil_scene::schema;
pub use argil_scene::{
    Action, Body, Brush, Change, Ease, Edit, EditError, Edited, Entry, Exactness, Fault, FileError,
    Group, HistoryLimit, ImportError, Journal, JournalError, Keyframe, LogError, Material,
    MeshGrid, Modifier, Node, NodeId, Operator, OperatorKind, Outline, Piece, Placement, Profile,
    Recovered, SampledGrid, Scene, Shape, SplinePoint, Subtree, Turn, View, Watch, is_image,
    remove_unfinished_files, replace_file,
};
pub use argil_volume::{
    Bits, Brick, BrickChanges, BrickEdit, BrickLayout, BrickSettings, Bricks, BricksError, Dense,
    Encoding, Keep, Lattice, Layout, Octree, OctreeError, OctreeSettings, Range, ResolutionError,
    Section, SparseInfo, Stored, TooFarError, TreeInfo, Volume, VolumeError, VolumeInfo,
    VoxelError, Word,
};
pub use build::Build;
pub use cast::CastHit;
pub use drawing::Orbit;
pub use engine::{Backend, Engine};
pub use error::{BuildError, EngineError, GridError, PictureError, RenderError, VolumeFileError};
pub use field_mesh::MeshMethod;
pub use glam;
pub use listeners::Listener;
pub use live::{Applied, Pace, Rebuilt};
pub use meshes::{LoadedMesh, MeshFileError, load_meshes, load_meshes_controlled, load_meshes_of};
pub use picture::Drawn;
#[cfg(feature = "png")]
pub use picture::{ReadPicture, read_png, save_png, write_png};
pub use query::{Closest, MOST_BOXES, Overlap, Query};
pub use representation::{
    BricksOptions, BuildTimes, DenseOptions, MeshViaOptions, OctreeOptions, Via,
};
pub use stored::stored_scene;
pub use triangles::{MeshError, MeshNormals, MeshOptions, Meshed, save_mesh};
pub use world::World;
