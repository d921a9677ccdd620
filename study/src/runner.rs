//! Runs cases.

use crate::configuration::{Configuration, ConfigurationKind, DENSE, MESH};
use crate::experiment::{Look, Plan, StudyCamera, StudyCase, Task};
use crate::scenes::{SceneRng, scene};
use crate::views::{camera, exact_settings, settings};
use crate::warm_up::warm_up;
use anyhow::Context;
use argil::glam::Vec3;
use argil::render::{RenderMode, RenderSettings};
use argil::scene::{Brush, Scene, Shape};
use argil::volume::Volume;
use argil::{
    Engine, MeshMethod, MeshNormals, MeshOptions, Orbit, RenderedImage, Representation, World,
};
use argil_metrics::surface::{SurfaceDistance, sample_surface};
use argil_metrics::{ErrorStats, Rgb8Image, depth, flip, laplacian, psnr, ssim};
use image::RgbImage;
use std::collections::BTreeMap;
use std::time::Instant;

/// The result of a case.
#[derive(Default)]
pub(crate) struct Outcome {
    /// See [`crate::Record`].
    pub samples: BTreeMap<String, Vec<f64>>,
    /// See [`crate::Record`].
    pub values: BTreeMap<String, f64>,
    /// Images by name.
    pub pictures: Vec<(String, RgbImage)>,
}

impl Outcome {
    /// Stores a value, unless it is not finite. A check of a missing value fails.
    fn set(&mut self, name: &str, value: f64) {
        if value.is_finite() {
            self.values.insert(name.into(), value);
        }
    }

    /// Stores one of several samples, unless it is not finite.
    fn add(&mut self, name: &str, sample: f64) {
        if sample.is_finite() {
            self.samples.entry(name.into()).or_default().push(sample);
        }
    }

    fn spread(&mut self, name: &str, spread: &ErrorStats, unit: f64) {
        self.set(&format!("{name}_mean"), spread.mean / unit);
        self.set(&format!("{name}_rms"), spread.rms / unit);
        self.set(&format!("{name}_max"), spread.max / unit);
    }

    /// Stores facts about a world's representation.
    fn about(&mut self, world: &World) -> anyhow::Result<()> {
        self.set("memory_bytes", world.memory_bytes() as f64);
        let info = world.volume_info()?;
        if let Some(tree) = info.and_then(|info| info.octree) {
            self.set("bricks", tree.bricks as f64);
            self.set("nodes", tree.nodes as f64);
        }
        if let Some(sparse) = info.and_then(|info| info.bricks) {
            self.set("bricks", sparse.bricks as f64);
        }
        if let Some(argil::MeshCounts {
            triangles,
            vertices,
        }) = world.mesh_counts()
        {
            self.set("triangles", triangles as f64);
            self.set("vertices", vertices as f64);
        }
        Ok(())
    }
}

/// Runs a case.
///
/// # Errors
/// If it fails.
pub(crate) fn perform(case: &StudyCase, engine: &Engine, plan: &Plan) -> anyhow::Result<Outcome> {
    let scene = scene(&case.scene)?;
    let mut out = Outcome::default();
    let way = resolved(case.way, engine, &scene)?;
    let build = || -> anyhow::Result<World> {
        let mut world = engine.build(&scene)?.with_representation(way.via())?;
        if way.kind == ConfigurationKind::Compiled {
            world.specialize()?;
        }
        Ok(world)
    };
    match case.task {
        Task::Build(runs) => {
            // Exclude shader compilation and the first access to memory from the timing.
            let mut world = build()?;
            for _ in 0..runs {
                world = world.rebuilt_as(&scene, way.via())?;
                let times = world.build_timings();
                out.add("build_ms", times.duration_ms);
                for (stage, ms) in &times.stages_ms {
                    out.add(&format!("{stage}_ms"), *ms);
                }
            }
            out.about(&world)?;
        }
        Task::Frames(count, eye) => frames(&build()?, plan, (&case.way, count, eye), &mut out)?,
        Task::Picture(look) => picture(&build()?, case, plan, look, &mut out)?,
        Task::Stored(count) => stored(&build()?, count, &mut out)?,
        Task::Surface(count) => surface(&engine.build(&scene)?.field(), way, count, &mut out)?,
        Task::Edits(count, radius) => edits(build()?, scene, (count, radius), &mut out)?,
        Task::CountLostBricks => lost(&build()?, &mut out)?,
    }
    Ok(out)
}

/// Resolves a configuration whose resolution depends on another's size.
fn resolved(way: Configuration, engine: &Engine, scene: &Scene) -> anyhow::Result<Configuration> {
    if way.kind != ConfigurationKind::MeshAsLarge {
        return Ok(way);
    }
    let bytes = |way: Configuration| -> anyhow::Result<f64> {
        let world = engine.build(scene)?.with_representation(way.via())?;
        Ok(world.memory_bytes() as f64)
    };
    let target = bytes(Configuration::of(DENSE, way.resolution))?;
    let mut resolution = 64.0;
    // The number of triangles grows almost quadratically; less where thin parts appear only at higher resolutions.
    for _ in 0..3 {
        let own = bytes(Configuration::of(MESH, resolution as u32))?.max(1.0);
        resolution = (resolution * (target / own).sqrt())
            .clamp(16.0, 1024.0)
            .round();
    }
    Ok(Configuration::of(MESH, resolution as u32))
}

fn frames(
    world: &World,
    plan: &Plan,
    (way, count, eye): (&Configuration, u32, StudyCamera),
    out: &mut Outcome,
) -> anyhow::Result<()> {
    let settings = RenderSettings {
        samples: 1,
        ground: false,
        lookup_start: way.descent(),
        ..world.render_settings(plan.size(), RenderMode::Normal)
    };
    let first = camera(world, eye);
    warm_up(world, (first, &settings), plan, (count / 10).max(1))?;
    let mut hit_pixels = 0;
    for camera in Orbit::cameras(first, count) {
        let drawn = world.render(&camera, &settings)?;
        out.add("frame_ms", drawn.duration_ms);
        let statistics = &drawn.statistics;
        for (name, spread) in [
            ("steps", statistics.steps),
            ("samples", statistics.samples),
            ("descents", statistics.descents),
            ("cells", statistics.cells),
        ] {
            out.add(&format!("{name}_mean"), spread.mean);
            if name == "steps" {
                out.add("steps_p95", spread.p95);
                out.add("steps_max", spread.max);
            }
        }
        hit_pixels += drawn.hit_pixels;
    }
    out.set("hit_pixels", hit_pixels as f64);
    out.about(world)
}

fn image(drawn: RenderedImage) -> anyhow::Result<RgbImage> {
    let [width, height] = drawn.size;
    RgbImage::from_raw(width, height, drawn.rgb)
        .context("the image data does not match the image size")
}

/// Converts an image for metrics and for storage.
fn measured(own: &RgbImage) -> anyhow::Result<Rgb8Image> {
    let measured = Rgb8Image::new(own.dimensions().into(), own.as_raw().clone());
    measured.context("the image data does not match the image size")
}

fn kept(own: &Rgb8Image) -> anyhow::Result<RgbImage> {
    let [width, height] = own.size();
    RgbImage::from_raw(width, height, own.rgb().to_vec())
        .context("the image data does not match the image size")
}

fn picture(
    world: &World,
    case: &StudyCase,
    plan: &Plan,
    look: Look,
    out: &mut Outcome,
) -> anyhow::Result<()> {
    let (camera, settings) = (
        camera(world, look.eye),
        settings(world, plan, (&case.way, &look)),
    );
    let drawn = world.render(&camera, &settings)?;
    out.add("frame_ms", drawn.duration_ms);
    out.set("hit_pixels", drawn.hit_pixels as f64);
    for (name, spread) in [
        ("steps", drawn.statistics.steps),
        ("descents", drawn.statistics.descents),
    ] {
        out.set(&format!("{name}_mean"), spread.mean);
        out.set(&format!("{name}_p95"), spread.p95);
        out.set(&format!("{name}_max"), spread.max);
    }
    out.about(world)?;
    let own = image(drawn)?;
    let seen_own = measured(&own)?;
    if look.is_compared && case.way.kind != ConfigurationKind::Field {
        // The reference is the field, rendered by the same device.
        let scene = scene(&case.scene)?;
        let reference = world.engine().build(&scene)?.field();
        let exact = exact_settings(&reference, plan, &look);
        let right = measured(&image(reference.render(&camera, &exact)?)?)?;
        out.set("psnr_db", psnr(&right, &seen_own)?.min(200.0));
        out.set("ssim", ssim(&right, &seen_own)?);
        let seen = flip::flip(&right, &seen_own, flip::PIXELS_PER_DEGREE)?;
        out.set("flip_mean", seen.mean());
        let edges = laplacian::difference(&right, &seen_own)?;
        out.set("laplacian_equal_pixels", edges.equal_pixels as f64);
        out.set("laplacian_mean_abs", edges.mean_abs);
        let histogram = edges.histogram.iter().map(|&n| n as f64).collect();
        out.samples.insert("laplacian_histogram".into(), histogram);
        let depths = depth::compare(
            &reference.ray_distances(&camera, &exact)?,
            &world.ray_distances(&camera, &settings)?,
        );
        let radius = f64::from(world.view_bounds().half_diagonal());
        out.spread("depth", &depths.both, radius);
        out.set("missed_pixels", depths.missed as f64);
        out.set("added_pixels", depths.added as f64);
        let edges = kept(&edges.picture)?;
        out.pictures.push(("laplacian".into(), edges));
    }
    if look.is_compared && case.way.kind == ConfigurationKind::Field {
        // The study's figure 29: the difference from a blank image.
        let edges = laplacian::laplacian(&seen_own);
        let equal = edges.pixels().iter().filter(|p| **p == [0; 3]).count();
        out.set("laplacian_equal_pixels", equal as f64);
        out.pictures.push(("laplacian".into(), kept(&edges)?));
    }
    out.pictures.push(("picture".into(), own));
    Ok(())
}

/// Returns points in the scene's box, and their exact distances.
fn points(world: &World, count: u32) -> (Vec<[f32; 3]>, Vec<f32>) {
    let focus = world.view_bounds();
    let mut numbers = SceneRng::new(7);
    let mut place = || {
        let part = Vec3::from([(); 3].map(|()| numbers.next()));
        (focus.min + part * focus.size()).to_array()
    };
    let points: Vec<[f32; 3]> = (0..count).map(|_| place()).collect();
    let mut exact = vec![0.0; points.len()];
    world.query().distances(&points, &mut exact);
    (points, exact)
}

/// Returns points of the exact surface.
fn surface_points(world: &World, count: u32) -> Vec<[f32; 3]> {
    let (all, exact) = points(world, 100 * count);
    let radius = world.view_bounds().half_diagonal();
    let close = all
        .into_iter()
        .zip(exact)
        .filter(|(_, d)| d.abs() < 0.05 * radius);
    let mut close: Vec<[f32; 3]> = close.map(|(p, _)| p).take(count as usize).collect();
    // Descend along the gradient a few times, because distances may be bounds.
    let mut found = vec![(0.0, [0.0; 3]); close.len()];
    for _ in 0..12 {
        world.query().gradients(&close, &mut found);
        for (p, (d, g)) in close.iter_mut().zip(&found) {
            let g = Vec3::from(*g).normalize_or_zero();
            *p = (Vec3::from(*p) - *d * g).to_array();
        }
    }
    let mut left = vec![0.0; close.len()];
    world.query().distances(&close, &mut left);
    let there = close.into_iter().zip(left);
    there
        .filter(|(_, d)| d.abs() < 1e-4 * radius)
        .map(|(p, _)| p)
        .collect()
}

fn stored(world: &World, count: u32, out: &mut Outcome) -> anyhow::Result<()> {
    let info = world
        .volume_info()?
        .context("this configuration has no volume")?;
    let band = info.encoding.band.voxels() * info.voxel_grid.voxel_size;
    let (all, exact) = points(world, count);
    let volume = world
        .query_volume()
        .context("this configuration stores no distances")?;
    // Cells without a brick provide a bound, not a stored distance.
    let (all, exact): (Vec<_>, Vec<_>) = match world.volume()?.as_deref() {
        Some(Volume::Bricks(bricks)) => all
            .into_iter()
            .zip(exact)
            .filter(|(p, _)| bricks.has_brick((*p).into()))
            .unzip(),
        _ => (all, exact),
    };
    let mut own = vec![0.0; all.len()];
    volume.distances(&all, &mut own);
    // Four voxels for all, so that they are compared at the same points.
    let near = band.min(4.0 * info.voxel_grid.voxel_size);
    let errors = ErrorStats::within_band(&own, &exact, 0.99 * near);
    out.set("points", errors.count as f64);
    out.spread(
        "error_voxels",
        &errors,
        f64::from(info.voxel_grid.voxel_size),
    );
    out.about(world)
}

fn surface(world: &World, way: Configuration, count: u32, out: &mut Outcome) -> anyhow::Result<()> {
    let Representation::Mesh(via) = way.via() else {
        anyhow::bail!("surface errors need triangles");
    };
    let options = MeshOptions {
        method: via.method,
        resolution: via.resolution,
        normals: if via.flat {
            MeshNormals::Face
        } else {
            MeshNormals::Field
        },
        materials: false,
        unindexed: via.flat && via.method == MeshMethod::MarchingCubes,
        ..MeshOptions::default()
    };
    let mesh = || world.mesh(&options);
    let meshed = mesh()?;
    out.add("mesh_ms", meshed.duration_ms);
    // The first edit includes first memory access and list construction.
    out.samples.clear();
    for _ in 0..3 {
        out.add("mesh_ms", mesh()?.duration_ms);
    }
    out.set("triangles", meshed.report.triangles as f64);
    out.set("vertices", meshed.mesh.positions.len() as f64);
    out.set("memory_bytes", meshed.mesh.memory_bytes() as f64);
    let watertight = meshed.report.is_watertight();
    out.set("watertight", f64::from(u8::from(watertight)));
    let mesh = meshed.mesh;
    let corners: Vec<[Vec3; 3]> = (0..mesh.triangles.len())
        .map(|i| mesh.triangle_vertices(i))
        .collect();
    let own = sample_surface(&corners, count as usize);
    let exact: Vec<Vec3> = surface_points(world, count / 4)
        .into_iter()
        .map(Vec3::from)
        .collect();
    let solid =
        argil::mesh::MeshSdf::new(&mesh).context("the mesh has no triangles with an area")?;
    let apart = SurfaceDistance::of(
        (&own, &|p: Vec3| solid.distance(p)),
        (&exact, &|p: Vec3| world.distance(p.to_array())),
    );
    let voxel = f64::from(meshed.voxel_grid.voxel_size);
    out.set("hausdorff_voxels", apart.hausdorff() / voxel);
    out.set("chamfer_voxels", apart.chamfer() / voxel);
    out.set("off_rms_voxels", meshed.surface_error.rms_voxels);
    Ok(())
}

fn edits(
    mut world: World,
    mut scene: Scene,
    (count, radius): (u32, f32),
    out: &mut Outcome,
) -> anyhow::Result<()> {
    let places = surface_points(&world, count);
    let radius = radius * world.view_bounds().size().max_element();
    for place in places {
        scene.push(Brush::new(Shape::sphere(radius)).at(place).subtract())?;
        let start = Instant::now();
        let applied = world.apply(&scene)?;
        let counts = world.flush()?;
        let ms = start.elapsed().as_secs_f64() * 1e3;
        out.add("edit_ms", ms);
        if !applied.rebuilt {
            out.add("edited_bricks", counts.filled as f64);
        }
        out.add(
            "dirty_volume",
            f64::from(applied.dirty_box.size().element_product()),
        );
    }
    out.set("brushes", world.program().brush_count() as f64);
    out.about(&world)
}

fn lost(world: &World, out: &mut Outcome) -> anyhow::Result<()> {
    out.about(world)?;
    let missing = match world.volume()?.as_deref() {
        Some(Volume::Octree(octree)) => octree.lost_bricks(world.program()),
        Some(Volume::Bricks(bricks)) => surface_points(world, 5000)
            .into_iter()
            .filter(|&p| !bricks.has_brick(p.into()))
            .count(),
        _ => anyhow::bail!("lost bricks need a representation with bricks"),
    };
    out.set("lost_bricks", missing as f64);
    Ok(())
}
