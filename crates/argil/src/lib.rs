#![doc = include_str!("crate.md")]
#![cfg_attr(doc, doc = include_str!("pictures/page.md"))]

#[cfg(not(target_arch = "wasm32"))]
mod blocking;
mod build;
mod build_context;
mod cache_folder;
mod cast;
mod device;
mod edit_report;
mod edit_session;
mod engine;
mod error;
#[cfg(feature = "volume-files")]
mod export;
mod external_files;
mod field_mesh;
mod framing;
mod heightmap;
#[cfg(feature = "gpu")]
mod host;
mod image;
mod image_assets;
mod levels_mesh;
mod light;
mod limits;
mod memory;
mod mesh_assets;
#[cfg(feature = "mesh-files")]
mod mesh_cache;
mod mesh_error;
mod mesh_facts;
mod mesh_file_error;
mod mesh_options;
mod meshing;
#[cfg(feature = "gpu")]
mod moves;
mod observers;
mod offset_mesh;
mod probe;
mod program_cache;
mod query;
mod rendering;
mod representation;
mod sample_lattice;
mod scene_state;
mod still;
mod still_error;
mod vertex_error;
#[cfg(feature = "volume-files")]
mod volume_import;
mod volume_io;
mod world;

pub use argil_abi as abi;
pub use argil_field as field;
#[cfg(feature = "gpu")]
pub use argil_gpu as gpu;
pub use argil_math as math;
pub use argil_mesh as mesh;
pub use argil_render as render;
pub use argil_scene as scene;
#[cfg(feature = "volume-files")]
pub use argil_vdb as vdb;
pub use argil_volume as volume;
pub use glam;

pub use argil_field::{BakeHistoryError, SampleLattice, bake_history};
pub use argil_mesh::MeshNormals;
pub use build::Build;
pub use cache_folder::cache_folder;
pub use cast::RayHit;
pub use edit_report::{EditBudget, EditReport, RebuildReason};
pub use engine::{Backend, Engine};
pub use error::{BuildError, EngineError, GridError, ImageFileError, RenderError, VolumeFileError};
#[cfg(feature = "volume-files")]
pub use export::{
    ExportClass, ExportCodec, ExportError, ExportFormat, ExportOptions, ExportReport,
};
pub use external_files::ExternalFiles;
pub use field_mesh::MeshMethod;
#[cfg(feature = "gpu")]
pub use image::RenderReport;
pub use image::RenderedImage;
#[cfg(feature = "png")]
pub use image::{PngImage, read_png, save_png, write_png};
pub use mesh_assets::{
    LoadedMesh, load_images, load_meshes, load_meshes_from_bytes, load_meshes_with_control,
};
pub use mesh_error::MeshError;
pub use mesh_file_error::MeshFileError;
pub use mesh_options::MeshOptions;
pub use meshing::{MeshOutput, save_mesh};
pub use observers::SubscriptionId;
pub use query::{BoxPosition, ClosestPoint, MAX_BOXES, Query};
pub use rendering::Orbit;
pub use representation::{
    BricksOptions, BuildTimings, DenseOptions, LevelsOptions, MeshCounts, MeshRenderOptions,
    OctreeOptions, Representation,
};
pub use still_error::StillError;
pub use vertex_error::VertexError;
#[cfg(feature = "volume-files")]
pub use volume_import::{
    RawLayout, RawType, ReadVolume, VolumeReadError, VolumeReadOptions, is_volume_file,
    read_volume, read_volume_bytes,
};
pub use volume_io::stored_scene;
pub use world::World;

/// The names that most programs use: `use argil::prelude::*;`.
pub mod prelude {
    pub use crate::{
        Backend, BricksOptions, DenseOptions, EditBudget, Engine, LevelsOptions, MeshMethod,
        MeshOptions, Representation, World,
    };
    pub use argil_field::Grid;
    pub use argil_math::{Aabb, Control};
    pub use argil_render::{Camera, LiveImage, RenderMode, RenderSettings};
    pub use argil_scene::{
        Brush, CameraPath, CameraPose, Edit, Group, Journal, Keyframe, Material, Modifier, NodeId,
        NodeTree, Operator, OperatorKind, Path2, SampledGrid, Scene, Shape, View,
    };
}

/// The examples of the repository's README, which compile with the tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
#[derive(Debug)]
pub struct RepositoryReadme;
