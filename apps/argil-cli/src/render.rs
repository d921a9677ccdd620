//! `argil render`.

use crate::args::RenderArgs;
use crate::{heat_legend, input, output, single_image};
use anyhow::Context;
use argil::render::{Camera, RenderMode, RenderSettings, ViewLight};
use argil::scene::{CameraPath, Scene};
use argil::volume::{FillStats, Levels};
use argil::{Orbit, RenderedImage, Representation, World};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

pub(crate) fn run(options: &RenderArgs) -> anyhow::Result<()> {
    // Check the request before any work.
    let picture = output::picture_path(options)?;
    if let Some(path) = &picture {
        output::check_place(path, &options.scene)?;
    }
    let engine = input::engine(&options.on)?;
    if options.specialize && engine.gpu_kind().is_none() {
        anyhow::bail!("--specialize compiles a shader: add --device gpu");
    }

    let start = Instant::now();
    #[cfg(feature = "world")]
    let (mut scene, mut world, stored) = crate::stored::opened(options, &engine)?;
    #[cfg(not(feature = "world"))]
    let (mut scene, mut world) = input::world(
        &options.scene,
        &engine,
        options.via,
        &options.volume,
        (options.time, options.on.allow_external_meshes),
    )?;
    if options.show == RenderMode::Shaded {
        prepare_light(options, &mut world)?;
    }
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
    let camera = options
        .camera
        .map_or_else(|| world.camera(), |placement| world.camera_at(placement));
    if let Some(info) = world.volume_info()? {
        output::warn_if_clipped_near(&info.voxel_grid, camera.eye.to_array(), &options.scene);
    }
    let settings = settings(options, &world);

    let frames = draw(
        options,
        (&mut scene, &mut world),
        camera,
        &settings,
        picture.as_deref(),
    )?;
    #[cfg(not(feature = "world"))]
    let from_store = json!({});
    #[cfg(feature = "world")]
    let from_store = stored.as_ref().map_or_else(
        || json!({}),
        |stored| {
            crate::stored::warn(stored, options.store.is_some());
            crate::stored::report(stored)
        },
    );
    report(
        options,
        (&world, from_store),
        build_ms,
        &frames,
        picture.as_deref(),
    )
}

/// Loads the image around the scene, and warns of lights that are left out.
fn prepare_light(options: &RenderArgs, world: &mut World) -> anyhow::Result<()> {
    let folder = options.scene.parent().unwrap_or(Path::new("."));
    world.load_environment(folder, options.on.allow_external_meshes)?;
    let left_out = ViewLight::left_out(world.view());
    if left_out > 0 {
        eprintln!(
            "warning: {}: images have the first sun and eight other lights, and leave out {left_out}: add --integrator path for all",
            options.scene.display()
        );
    }
    Ok(())
}

/// What was drawn.
struct Frames {
    last: RenderedImage,
    frame_ms: Vec<f64>,
    edit_ms: Vec<f64>,
    refined: FillStats,
    coarse: Vec<f64>,
}

/// Draws the image, or the frames of an animation, of a path or of an orbit.
fn draw(
    options: &RenderArgs,
    (scene, world): (&mut Scene, &mut World),
    camera: Camera,
    settings: &RenderSettings,
    picture: Option<&Path>,
) -> anyhow::Result<Frames> {
    let Some(count) = options.frames else {
        let (drawn, refined) = single_image::draw(options, world, &camera, settings)?;
        if let Some(path) = picture {
            drawn.save(path)?;
        }
        return Ok(Frames {
            frame_ms: vec![drawn.duration_ms],
            last: drawn,
            edit_ms: Vec::new(),
            refined,
            coarse: world
                .levels()
                .map(Levels::coarse_share)
                .into_iter()
                .collect(),
        });
    };
    let mut refined = FillStats::default();
    let mut reel = Reel::new(settings, count, picture)?;
    reel.fill_ms = options.fill_ms.map(f64::from);
    let path = options.path.as_deref().map(|name| path_of(scene, name));
    let path = path.transpose()?.cloned();
    match (path, scene.duration().filter(|_| options.time.is_none())) {
        (Some(path), _) => {
            let step = path.duration() / count.saturating_sub(1).max(1) as f32;
            for i in 0..count {
                let camera = world.camera_at(path.at(step * i as f32));
                refined += reel.draw_levels(world, &camera)?;
            }
        }
        (None, Some(duration)) => animate(scene, world, camera, duration, &mut reel)?,
        (None, None) => {
            // What fills an image from one side may be cut from another one.
            let from_afar = world.camera_at(world.view().camera);
            let camera = options.camera.map_or(from_afar, |_| camera);
            for camera in Orbit::cameras(camera, count) {
                refined += reel.draw_levels(world, &camera)?;
            }
        }
    }
    Ok(Frames {
        last: reel.last.context("no frame was rendered")?,
        frame_ms: reel.times,
        edit_ms: reel.edits,
        refined,
        coarse: reel.coarse,
    })
}

pub(crate) fn settings(options: &RenderArgs, world: &World) -> RenderSettings {
    let defaults = world.render_settings(options.size, options.show);
    RenderSettings {
        max_steps: options.max_steps.unwrap_or(defaults.max_steps),
        epsilon: options.epsilon,
        normal_bias: options.normal_bias,
        normals: options.normals.unwrap_or_default(),
        lookup_start: options.volume.descent.unwrap_or_default(),
        samples: options.still.samples.unwrap_or(defaults.samples),
        ground: (defaults.ground || options.ground) && !options.no_ground,
        ..defaults
    }
}

/// How many frames ahead of the camera bricks are baked.
const FRAMES_AHEAD: f32 = 8.0;

/// Returns a path of the scene's view.
fn path_of<'a>(scene: &'a Scene, name: &str) -> anyhow::Result<&'a CameraPath> {
    let paths = &scene.view.paths;
    paths.get(name).with_context(|| {
        let names: Vec<&str> = paths.keys().map(String::as_str).collect();
        match names.is_empty() {
            true => "the scene's view has no paths: omit --path".to_owned(),
            false => format!("the scene has no path {name:?}, but {}", names.join(", ")),
        }
    })
}

/// A sequence of frames.
struct Reel<'a> {
    settings: &'a RenderSettings,
    path: Option<&'a Path>,
    progress: ProgressBar,
    times: Vec<f64>,
    /// Milliseconds for baking after each frame, if not all that is missing is baked before.
    fill_ms: Option<f64>,
    /// The share of hits in each frame for which a finer brick was missing.
    coarse: Vec<f64>,
    /// The camera of the last frame.
    before: Option<Camera>,
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
            fill_ms: None,
            coarse: Vec::new(),
            before: None,
            last: None,
        })
    }

    /// Draws a frame of levels. Bakes what is missing before, or for some time after it, also for where the camera will
    /// be.
    fn draw_levels(&mut self, world: &mut World, camera: &Camera) -> anyhow::Result<FillStats> {
        let Some(fill_ms) = self.fill_ms else {
            let refined = world.refine(camera, self.settings)?;
            self.draw(world, camera)?;
            return Ok(refined);
        };
        self.draw(world, camera)?;
        let lacked = world.levels().map_or(0, |levels| levels.request_count());
        if let Some(before) = self.before.replace(*camera) {
            let ahead = Camera {
                eye: camera.eye + FRAMES_AHEAD * (camera.eye - before.eye),
                target: camera.target + FRAMES_AHEAD * (camera.target - before.target),
                ..*camera
            };
            world.prefetch(&ahead, self.settings)?;
        }
        let filled = world.fill_pages(fill_ms)?;
        // What the image lacked when it was drawn.
        Ok(FillStats {
            remaining: lacked as u64,
            ..filled
        })
    }

    fn draw(&mut self, world: &World, camera: &Camera) -> anyhow::Result<()> {
        let is_last = self.progress.length() == Some(self.times.len() as u64 + 1);
        let mut settings = *self.settings;
        settings.statistics = is_last;
        settings.heat_steps = self.last.as_ref().and_then(|before| before.heat_steps);
        let mut drawn = world.render(camera, &settings)?;
        heat_legend::draw(&mut drawn);
        if let Some(path) = self.path {
            drawn.save(output::numbered(path, self.times.len()))?;
        }
        self.times.push(drawn.duration_ms);
        self.coarse.extend(world.levels().map(Levels::coarse_share));
        self.last = Some(drawn);
        self.progress.inc(1);
        if is_last {
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

/// Returns the JSON report. Times of the build, of frames and of edits are in milliseconds.
fn json_report(
    world: &World,
    drawn: &RenderedImage,
    (build_ms, frame_ms, edit_ms): (f64, &[f64], &[f64]),
    picture: Option<&Path>,
) -> anyhow::Result<Value> {
    let engine = world.engine();
    let kept = world.representation();
    let statistics = drawn.statistics.context("no ray was counted")?;
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
        "steps": output::spread(statistics.steps),
        "fetches": output::spread(statistics.steps),
        "memory_bytes": world.memory_bytes(),
        "gpu": output::gpu_counters(world.engine()),
        "heat_steps": drawn.heat_steps,
        "hit_pixels": drawn.hit_pixels,
        "picture": picture.map(|p| p.display().to_string()),
    });
    if let Some(all) = report.as_object_mut()
        && kept != Representation::Field
    {
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
    (world, from_store): (&World, Value),
    build_ms: f64,
    frames: &Frames,
    picture: Option<&Path>,
) -> anyhow::Result<()> {
    let Frames {
        last: drawn,
        frame_ms,
        edit_ms,
        refined,
        coarse,
    } = frames;
    let engine = world.engine();
    let times = output::times(frame_ms);
    let kept = world.representation();
    if options.json {
        let times = (build_ms, &frame_ms[..], &edit_ms[..]);
        let mut report = json_report(world, drawn, times, picture)?;
        if let Some(levels) = world.levels() {
            output::extend(&mut report, output::levels(levels, refined, coarse));
        }
        output::extend(&mut report, from_store);
        output::json(&report);
        return Ok(());
    }
    let [w, h] = drawn.size;
    let statistics = drawn.statistics.context("no ray was counted")?;
    let steps = statistics.steps;
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
        let about = output::levels(levels, refined, coarse);
        for (key, value) in about.as_object().into_iter().flatten() {
            output::pair(key, value);
        }
    }
    if matches!(kept, Representation::Octree(_)) {
        let counts = &statistics;
        output::line(&format!(
            "of them, means: {:.1} samples, {:.1} nodes, {:.1} cells",
            counts.samples.mean, counts.descents.mean, counts.cells.mean
        ));
    }
    Ok(())
}
