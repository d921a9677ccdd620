#![doc = include_str!("crate.md")]
#![cfg_attr(doc, doc = include_str!("pictures/page.md"))]

mod both_formats;
mod brick_march;
mod bricks;
mod camera;
mod dense;
mod false_colors;
mod image;
mod levels;
mod light;
mod live_image;
mod octree;
mod octree_trace;
mod path;

mod probe;
mod projection;
mod pruned_trace;
mod raster;
mod ray_batch;
mod ray_stats;
mod render;
mod render_settings;
mod shade;
mod source;
mod source_scratch;
mod srgb;
mod surfaces;
mod tile;
mod tile_buffers;
mod tones;
mod toward_sun;
mod trace;
mod view_light;

pub use bricks::LitBricks;
pub use camera::Camera;
pub use image::RenderOutput;
pub use light::SHADOW_STEPS;
pub use live_image::LiveImage;
pub use path::{
    Development, EnvironmentNotLoaded, PathHit, PathLens, PathLights, PathMaterial, PathScene,
    PathTables, PathView, Still, StillOptions, continue_paths, denoised, developed, trace_paths,
};
pub use projection::Projection;
pub use pruned_trace::PrunedField;
pub use raster::Triangles;
pub use ray_stats::{Percentiles, RayStatistics};
pub use render::{render, render_with_control, render_with_hits};
pub use render_settings::{LookupStart, NormalSource, RenderMode, RenderSettings, frame_uniforms};
pub use source::RenderSource;
pub use trace::UnprunedField;
pub use view_light::ViewLight;

/// The WGSL twins. A module contains the camera, one tracer, what completes its hits, and light.
pub mod wgsl {
    /// Primary rays.
    pub const CAMERA: &str = include_str!("camera.wgsl");
    /// Hits as records.
    pub const HIT_RECORDS: &str = include_str!("hit_records.wgsl");
    /// Storing and reading them, where passes write them.
    pub const STORED_HITS: &str = concat!(
        include_str!("hit_records.wgsl"),
        include_str!("stored_hits.wgsl")
    );
    /// Drawing into the targets of a host.
    pub const COMPOSITE: &str = include_str!("composite.wgsl");
    /// Finding how far the points of a frame moved, by the interpreter's `motion_wgsl`.
    pub const MOTION: &str = include_str!("motion.wgsl");
    /// Marching through the field.
    pub const FIELD: &str = concat!(
        include_str!("field_lighting.wgsl"),
        include_str!("field_normal.wgsl"),
        include_str!("trace.wgsl")
    );
    /// Marching through a dense volume.
    pub const DENSE: &str = concat!(
        include_str!("field_lighting.wgsl"),
        include_str!("volume.wgsl"),
        include_str!("end_walk.wgsl"),
        include_str!("dense.wgsl")
    );
    /// Marching through an octree.
    pub const OCTREE: &str = concat!(
        include_str!("field_lighting.wgsl"),
        include_str!("volume.wgsl"),
        include_str!("end_walk.wgsl"),
        include_str!("octree.wgsl")
    );
    /// Marching through sparse bricks.
    pub const BRICKS: &str = concat!(
        include_str!("field_normal.wgsl"),
        include_str!("brick_field_normals.wgsl"),
        include_str!("bricks.wgsl"),
        include_str!("bricks/cubic.wgsl"),
        include_str!("bricks/voxel_intersect.wgsl"),
        include_str!("bricks/motion.wgsl"),
        include_str!("bricks/walk.wgsl"),
        include_str!("bricks/march_blocks.wgsl"),
        include_str!("bricks/step.wgsl"),
        include_str!("bricks/light_levels.wgsl"),
        include_str!("bricks/light.wgsl"),
        include_str!("bricks/stored_material.wgsl"),
        include_str!("bricks/deferred.wgsl"),
        include_str!("bricks/cones.wgsl"),
        include_str!("bricks/sun_cones.wgsl"),
        include_str!("bricks/block_light.wgsl")
    );
    /// Marching through levels of detail.
    pub const LEVELS: &str = concat!(
        include_str!("field_normal.wgsl"),
        include_str!("brick_field_normals.wgsl"),
        include_str!("levels/records.wgsl"),
        include_str!("levels/locate.wgsl"),
        include_str!("levels/distances.wgsl"),
        include_str!("levels/notes.wgsl"),
        include_str!("levels/clearance.wgsl"),
        include_str!("bricks/cubic.wgsl"),
        include_str!("levels/intersect.wgsl"),
        include_str!("bricks/motion.wgsl"),
        include_str!("levels/walk.wgsl"),
        include_str!("bricks/march_blocks.wgsl"),
        include_str!("levels/step.wgsl"),
        include_str!("levels/light.wgsl"),
        include_str!("levels/stored_material.wgsl"),
        include_str!("bricks/deferred.wgsl"),
        include_str!("bricks/cones.wgsl"),
        include_str!("bricks/sun_cones.wgsl"),
        include_str!("bricks/block_light.wgsl")
    );
    /// What paths of light ask of the field.
    pub const FIELD_PATHS: &str = concat!(
        include_str!("background.wgsl"),
        include_str!("path/field_scene.wgsl")
    );
    /// What paths of light ask of sparse bricks.
    pub const BRICK_PATHS: &str = concat!(
        include_str!("background.wgsl"),
        include_str!("bricks.wgsl"),
        include_str!("bricks/stored_material.wgsl"),
        include_str!("path/brick_scene.wgsl")
    );
    /// What shaders of a host ask of sparse bricks.
    pub const BRICK_HOST: &str = concat!(
        include_str!("camera.wgsl"),
        include_str!("bricks.wgsl"),
        include_str!("bricks/cubic.wgsl"),
        include_str!("bricks/voxel_intersect.wgsl"),
        include_str!("bricks/motion.wgsl"),
        include_str!("bricks/walk.wgsl"),
        include_str!("bricks/stored_material.wgsl"),
        include_str!("path/brick_scene.wgsl"),
        include_str!("host.wgsl"),
        include_str!("bricks/host.wgsl")
    );
    /// What shaders of a host ask of levels of detail.
    pub const LEVEL_HOST: &str = concat!(
        include_str!("camera.wgsl"),
        include_str!("levels/records.wgsl"),
        include_str!("levels/locate.wgsl"),
        include_str!("levels/distances.wgsl"),
        include_str!("bricks/cubic.wgsl"),
        include_str!("levels/intersect.wgsl"),
        include_str!("bricks/motion.wgsl"),
        include_str!("levels/walk.wgsl"),
        include_str!("levels/stored_material.wgsl"),
        include_str!("host.wgsl"),
        include_str!("levels/host.wgsl")
    );
    /// What paths of light ask of a dense volume.
    pub const DENSE_PATHS: &str = concat!(
        include_str!("background.wgsl"),
        include_str!("volume.wgsl"),
        include_str!("path/dense_scene.wgsl")
    );
    /// Paths of light, for one of these: the twins of `path.rs`.
    pub const PATHS: &str = concat!(
        include_str!("path/sampler.wgsl"),
        include_str!("path/bsdf.wgsl"),
        include_str!("path/fog.wgsl"),
        include_str!("path/scatter.wgsl"),
        include_str!("path/glass.wgsl"),
        include_str!("path/environment.wgsl"),
        include_str!("path/emitters.wgsl"),
        include_str!("path/rectangle.wgsl"),
        include_str!("path/lights.wgsl"),
        include_str!("path/surface.wgsl"),
        include_str!("path/inside.wgsl"),
        include_str!("path/march.wgsl"),
        include_str!("path/integrator.wgsl"),
        include_str!("path/paths.wgsl")
    );
    /// Drawing triangles: `place` and `nearest`, for a module of their own.
    pub const RASTER_DRAW: &str = include_str!("raster_draw.wgsl");
    /// Converts drawn triangles to hits.
    pub const RASTER_HITS: &str = concat!(
        include_str!("field_lighting.wgsl"),
        include_str!("field_normal.wgsl"),
        include_str!("raster_resolve.wgsl")
    );
    /// Normals and the ground.
    pub const RESOLVE_HITS: &str = include_str!("resolve_hits.wgsl");
    /// Converts colors to bytes, and counts, for a module of its own.
    pub const RESOLVE_SAMPLES: &str = include_str!("resolve_samples.wgsl");
    /// Light and colors.
    pub const SHADE: &str = concat!(
        include_str!("background.wgsl"),
        include_str!("tones.wgsl"),
        include_str!("lamps.wgsl"),
        include_str!("path/fog.wgsl"),
        include_str!("shade.wgsl")
    );
    /// Passes before it, for images with lamps, fog or bent normals.
    pub const MORE_LIGHT: &str = concat!(
        include_str!("lamp_shadows.wgsl"),
        include_str!("lamp_rays.wgsl"),
        include_str!("haze.wgsl"),
        include_str!("bent.wgsl")
    );
}
