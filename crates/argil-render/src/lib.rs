//! Pictures of fields and volumes: rays, normals, light.
//!
//! *Theory.* Sphere tracing (Hart 1996): from a point, a ray can go as far as the distance there without crossing the
//! surface. Divided by the field's Lipschitz constant, that holds for chamfered joints too.
//!
//! *Practice.* Two passes, each with a twin in WGSL: `trace_tile` finds what each primary ray hits, `shade_tile` colours
//! it. On the CPU a tile's rays march together: each round evaluates the field in batches for the
//! rays still under way and closes the gaps that the finished ones leave. [`render`] runs both over all tiles and
//! samples. What differs from a textbook tracer: a ray that starts inside a solid marches to the surface from within,
//! and rays are cut to the scene's box first, which costs nothing and saves the steps of those that miss it.

mod bricks;
mod camera;
mod dense;
mod image;
mod octree;
mod octree_trace;
mod probe;
mod pruned_trace;
mod raster;
mod ray_batch;
mod ray_stats;
mod render;
mod render_settings;
mod shade;
mod source;
mod tile;
mod tile_buffers;
mod trace;

pub use camera::Camera;
pub use image::RenderOutput;
pub use pruned_trace::PrunedField;
pub use raster::Triangles;
pub use ray_stats::{Percentiles, RayStatistics};
pub use render::{render, render_with_control, render_with_hits};
pub use render_settings::{LookupStart, NormalSource, RenderMode, RenderSettings, frame_uniforms};
pub use shade::SHADOW_STEPS;
pub use source::RenderSource;
pub use trace::WholeField;

/// The WGSL twins. A module has the camera, one way to march, what finishes its hits, and the light.
pub mod wgsl {
    /// Primary rays.
    pub const CAMERA: &str = include_str!("camera.wgsl");
    /// Marching through the field.
    pub const FIELD: &str = concat!(
        include_str!("air.wgsl"),
        include_str!("normal.wgsl"),
        include_str!("trace.wgsl")
    );
    /// Marching through a dense volume.
    pub const DENSE: &str = concat!(
        include_str!("air.wgsl"),
        include_str!("volume.wgsl"),
        include_str!("dense.wgsl")
    );
    /// Marching through an octree.
    pub const OCTREE: &str = concat!(
        include_str!("air.wgsl"),
        include_str!("volume.wgsl"),
        include_str!("octree.wgsl")
    );
    /// Marching through sparse bricks.
    pub const BRICKS: &str = concat!(
        include_str!("normal.wgsl"),
        include_str!("exact.wgsl"),
        include_str!("bricks.wgsl"),
        include_str!("bricks/solve.wgsl"),
        include_str!("bricks/step.wgsl"),
        include_str!("bricks/light.wgsl"),
        include_str!("bricks/cones.wgsl")
    );
    /// Drawing triangles: `place` and `nearest`, for a module of their own.
    pub const DRAW: &str = include_str!("draw.wgsl");
    /// What was drawn as hits.
    pub const MESH: &str = concat!(
        include_str!("air.wgsl"),
        include_str!("normal.wgsl"),
        include_str!("raster.wgsl")
    );
    /// Normals and the ground.
    pub const FINISH: &str = include_str!("finish.wgsl");
    /// Bytes of colours, and counts, for a module of their own.
    pub const RESOLVE: &str = include_str!("resolve.wgsl");
    /// Light and colours.
    pub const SHADE: &str = include_str!("shade.wgsl");
}
