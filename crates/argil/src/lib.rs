//! Malleable environments made of signed distance fields.
//!
//! A [`Scene`] is an ordered list of brushes. An [`Engine`] runs on a GPU or on the CPU; a [`World`] is a scene that it
//! has built, to be asked for distances and drawn.
//!
//! ```
//! use argil::prelude::*;
//! let mut scene = Scene::new();
//! scene.push(Brush::new(Shape::sphere(0.5)))?;
//! scene.push(Brush::new(Shape::sphere(0.2)).at([0.0, 0.4, 0.0]).subtract().smooth(0.05))?;
//! let world = Engine::cpu().build(&scene)?.field();
//! println!("{} from the surface", world.distance([1.0, 0.0, 0.0]));
//! let picture = world.render_view([64, 48])?;
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

pub use argil_abi as abi;
pub use argil_field as field;
pub use argil_gpu as gpu;
pub use argil_math as math;
pub use argil_mesh as mesh;
pub use argil_render as render;
pub use argil_scene as scene;
pub use argil_volume as volume;
pub use glam;

pub use build::Build;
pub use cast::RayHit;
pub use edit_session::{EditBudget, EditReport, RebuildReason};
pub use engine::{Backend, Engine};
pub use error::{BuildError, EngineError, GridError, ImageFileError, RenderError, VolumeFileError};
pub use field_mesh::MeshMethod;
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
    BricksOptions, BuildTimings, DenseOptions, MeshCounts, MeshRenderOptions, OctreeOptions,
    Representation,
};
pub use volume_io::stored_scene;
pub use world::World;

/// The names that most programs use: `use argil::prelude::*;`.
pub mod prelude {
    pub use crate::{
        Backend, BricksOptions, DenseOptions, EditBudget, Engine, MeshOptions, Representation,
        World,
    };
    pub use argil_field::Grid;
    pub use argil_math::{Aabb, Control};
    pub use argil_render::{Camera, RenderMode, RenderSettings};
    pub use argil_scene::{
        Brush, CameraPose, Edit, Group, Journal, Keyframe, Material, Modifier, NodeId, NodeTree,
        Operator, OperatorKind, Path2, SampledGrid, Scene, Shape, View,
    };
}
