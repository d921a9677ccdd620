//! `argil render`.

use crate::args::RenderArgs;
use crate::{input, output};
use anyhow::Context;
use argil::render::{Camera, RenderSettings};
use argil::scene::Scene;
use argil::volume::FillStats;
use argil::{Orbit, RenderedImage, Representation, World};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) fn run(options: &RenderArgs) -> anyhow::Result<()> {
    // Check the request before any work.
    let picture = picture_path(options)?;
    if let Some(path) = &picture {
        output::check_place(path, &options.scene)?;
    }
    let engine = input::engine(&options.on)?;
    if options.specialize && engine.gpu_kind().is_none() {
        anyhow::bail!("--specialize compiles a shader: add --device gpu");
    }

    let start = Instant::now();
    let (mut scene, mut world) = input::world(
        &options.scene,
        &engine,
        options.via,
        &options.volume,
        (options.time, options.on.allow_external_meshes),
    )?;
    if options.specialize {
        anyhow::ensure!(
            world.representation() == Representation::Field,
            "--specialize applies to the field, and this renders a volume: omit it"
        );
        world.specialize()?;
    }
    if options.normals.is_some() {
        anyhow::ensure!(
            matches!(world.representation(), Representation::Bricks(_)),
            "--normals applies to sparse bricks: omit it, or add --via bricks"
        );
    }
    let build_ms = match world.representation() {
        Representation::Field => start.elapsed().as_secs_f64() * 1e3,
        _ => world.build_timings().duration_ms,
    };
    if let Some(info) = world.volume_info()? {
        output::warn_if_clipped(&info.voxel_grid, &options.scene);
    }
    let camera = options
        .camera
        .map_or_else(|| world.camera(), |placement| world.camera_at(placement));
    let settings = settings(options, &world);

    let mut edit_ms = Vec::new();
    let mut refined = FillStats::default();
    let (drawn, frame_ms) = match options.frames {
        None => {
            refined = world.refine(&camera, &settings)?;
            let drawn = world.render(&camera, &settings)?;
            if let Some(path) = &picture {
                drawn.save(path)?;
            }
            let duration_ms = drawn.duration_ms;
            (drawn, vec![duration_ms])
        }
        Some(count) => {
            let mut reel = Reel::new(&settings, count, picture.as_deref())?;
            match scene.duration().filter(|_| options.time.is_none()) {
                Some(duration) => {
                    animate(&mut scene, &mut world, camera, duration, &mut reel)?;
                }
                None => {
                    for camera in Orbit::cameras(camera, count) {
                        refined = world.refine(&camera, &settings)?;
                        reel.draw(&world, &camera)?;
                    }
                }
            }
            edit_ms = reel.edits;
            (reel.last.context("no frame was rendered")?, reel.times)
        }
    };
    report(
        options,
        &world,
        &drawn,
        (build_ms, refined),
        &frame_ms,
        &edit_ms,
        picture.as_deref(),
    )
}

/// Returns the path of the image, or `None` for an orbit without -o.
fn picture_path(options: &RenderArgs) -> anyhow::Result<Option<PathBuf>> {
    if let Some(path) = &options.output {
        let is_png = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("png"));
        anyhow::ensure!(
            is_png,
            "{}: images are written as PNG; name it .png",
            path.display()
        );
        return Ok(Some(path.clone()));
    }
    if options.frames.is_some() {
        return Ok(None);
    }
    let name = options
        .scene
        .file_stem()
        .context("the scene's path has no file name")?;
    Ok(Some(Path::new(name).with_extension("png")))
}

fn settings(options: &RenderArgs, world: &World) -> RenderSettings {
    let own = world.render_settings(options.size, options.show);
    RenderSettings {
        max_steps: options.max_steps.unwrap_or(own.max_steps),
        epsilon: options.epsilon,
        normal_bias: options.normal_bias,
        normals: options.normals.unwrap_or_default(),
        lookup_start: options.volume.descent.unwrap_or_default(),
        samples: options.samples.unwrap_or(own.samples),
        ground: (own.ground || options.ground) && !options.no_ground,
        ..own
    }
}

/// A sequence of frames.
struct Reel<'a> {
    settings: &'a RenderSettings,
    path: Option<&'a Path>,
    progress: ProgressBar,
    times: Vec<f64>,
    /// Timings of the edits that move the scene, in milliseconds.
    edits: Vec<f64>,
    last: Option<RenderedImage>,
}

impl<'a> Reel<'a> {
    fn new(
        settings: &'a RenderSettings,
        count: u32,
        path: Option<&'a Path>,
    ) -> anyhow::Result<Self> {
        let style = ProgressStyle::with_template("{bar:40} frame {pos} of {len}, {eta} left")?;
        Ok(Self {
            settings,
            path,
            progress: ProgressBar::new(count.into()).with_style(style),
            times: Vec::new(),
            edits: Vec::new(),
            last: None,
        })
    }

    fn draw(&mut self, world: &World, camera: &Camera) -> anyhow::Result<()> {
        let drawn = world.render(camera, self.settings)?;
        if let Some(path) = self.path {
            drawn.save(numbered(path, self.times.len()))?;
        }
        self.times.push(drawn.duration_ms);
        self.last = Some(drawn);
        self.progress.inc(1);
        if self.progress.length() == Some(self.times.len() as u64) {
            self.progress.finish_and_clear();
        }
        Ok(())
    }
}

/// Renders an animation from its beginning to its end.
fn animate(
    scene: &mut Scene,
    world: &mut World,
    camera: Camera,
    duration: f32,
    reel: &mut Reel<'_>,
) -> anyhow::Result<()> {
    let count = reel.progress.length().unwrap_or(1);
    for i in 0..count {
        let start = Instant::now();
        scene.set_time(duration * i as f32 / count.saturating_sub(1).max(1) as f32);
        world.apply(scene)?;
        world.flush()?;
        reel.edits.push(start.elapsed().as_secs_f64() * 1e3);
        world.refine(&camera, reel.settings)?;
        reel.draw(world, &camera)?;
    }
    Ok(())
}

/// `pot.png` → `pot-0007.png`.
fn numbered(path: &Path, i: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{i:04}.png"))
}

/// Returns the JSON report. Times of the build, of frames and of edits are in milliseconds.
fn json_report(
    world: &World,
    drawn: &RenderedImage,
    (build_ms, frame_ms, edit_ms): (f64, &[f64], &[f64]),
    picture: Option<&Path>,
) -> anyhow::Result<Value> {
    let engine = world.engine();
    let kept = world.representation();
    let mut report = json!({
        "device": engine.device(),
        "device_reason": engine.selection_reason(),
        "via": kept.name(),
        "size": drawn.size,
        "brushes": world.program().brush_count(),
        "build_ms": build_ms,
        "frame_ms": output::times(frame_ms),
        "frames": frame_ms.len(),
        "edit_ms": (!edit_ms.is_empty()).then(|| output::times(edit_ms)),
        "steps": output::spread(drawn.statistics.steps),
        "fetches": output::spread(drawn.statistics.steps),
        "memory_bytes": world.memory_bytes(),
        "hit_pixels": drawn.hit_pixels,
        "picture": picture.map(|p| p.display().to_string()),
    });
    if let Some(all) = report.as_object_mut()
        && kept != Representation::Field
    {
        let statistics = &drawn.statistics;
        all.insert("resolution".into(), json!(world.resolution()));
        all.insert("stages_ms".into(), output::stages(world.build_timings()));
        for (key, spread) in [
            ("samples", statistics.samples),
            ("descents", statistics.descents),
            ("cells", statistics.cells),
        ] {
            all.insert(key.into(), output::spread(spread));
        }
        let info = world.volume_info()?;
        if let Some(tree) = info.and_then(|info| info.octree) {
            all.insert("bricks".into(), json!(tree.bricks));
            all.insert("nodes".into(), json!(tree.nodes));
        }
        if let Some(sparse) = info.and_then(|info| info.bricks) {
            all.insert("bricks".into(), json!(sparse.bricks));
        }
        if let Some(argil::MeshCounts {
            triangles,
            vertices,
        }) = world.mesh_counts()
        {
            all.insert("triangles".into(), json!(triangles));
            all.insert("vertices".into(), json!(vertices));
        }
    }
    Ok(report)
}

fn report(
    options: &RenderArgs,
    world: &World,
    drawn: &RenderedImage,
    (build_ms, refined): (f64, FillStats),
    frame_ms: &[f64],
    edit_ms: &[f64],
    picture: Option<&Path>,
) -> anyhow::Result<()> {
    let engine = world.engine();
    let times = output::times(frame_ms);
    let kept = world.representation();
    if options.json {
        let times = (build_ms, frame_ms, edit_ms);
        let mut report = json_report(world, drawn, times, picture)?;
        if let Some(levels) = world.levels() {
            output::extend(&mut report, output::levels(levels, &refined));
        }
        output::json(&report);
        return Ok(());
    }
    let [w, h] = drawn.size;
    let steps = drawn.statistics.steps;
    if let Some(path) = picture {
        output::line(&format!("{} ({w}x{h})", path.display()));
    }
    output::line(&format!(
        "on {}: {}",
        engine.device(),
        engine.selection_reason()
    ));
    let count = world.program().brush_count();
    let median = times["median"].as_f64().unwrap_or(0.0);
    output::line(&format!(
        "{}, built in {build_ms:.1} ms, rendered in {median:.1} ms{}",
        output::count(count, "brush"),
        if frame_ms.len() > 1 {
            format!(
                " (median of {} frames; min {:.1}, max {:.1})",
                frame_ms.len(),
                times["min"].as_f64().unwrap_or(0.0),
                times["max"].as_f64().unwrap_or(0.0)
            )
        } else {
            String::new()
        }
    ));
    if !edit_ms.is_empty() {
        output::line(&format!(
            "moved in {:.2} ms (median of {} frames)",
            output::median(edit_ms),
            edit_ms.len()
        ));
    }
    output::line(&format!(
        "{} pixels hit; steps per ray: mean {:.1}, p95 {}, max {}",
        drawn.hit_pixels, steps.mean, steps.p95, steps.max
    ));
    if let Some(levels) = world.levels() {
        let own = output::levels(levels, &refined);
        for (key, value) in own.as_object().into_iter().flatten() {
            output::pair(key, value);
        }
    }
    if matches!(kept, Representation::Octree(_)) {
        let counts = &drawn.statistics;
        output::line(&format!(
            "of them, means: {:.1} samples, {:.1} nodes, {:.1} cells",
            counts.samples.mean, counts.descents.mean, counts.cells.mean
        ));
    }
    Ok(())
}
