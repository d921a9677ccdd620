//! `argil render --integrator path`.

use crate::args::RenderArgs;
use crate::still_args::{Integrator, StillArgs};
use crate::still_plan::StillPlan;
use crate::{input, output};
use anyhow::{Context, bail, ensure};
use argil::math::Control;
use argil::render::{Development, RenderMode, Still, StillOptions, denoised, developed};
use argil::{World, save_png};
use image::{DynamicImage, ImageFormat, Rgb32FImage, Rgba32FImage, RgbaImage};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The still that is being made.
static MAKING: Mutex<Option<Control>> = Mutex::new(None);

/// Ends the still that is being made. Returns false if there is none, or if it was asked to end before.
pub(crate) fn interrupt() -> bool {
    let making = MAKING.lock().unwrap_or_else(PoisonError::into_inner).take();
    making.inspect(Control::cancel).is_some()
}

/// Refuses flags that mean nothing for one of the integrators.
pub(crate) fn check(options: &RenderArgs) -> anyhow::Result<()> {
    let flags = &options.still;
    if flags.integrator == Integrator::Direct {
        let of_paths = [
            ("--denoise", flags.denoise),
            ("--transparent", flags.transparent),
            ("--time-limit", flags.time_limit.is_some()),
            ("--firefly-clamp", flags.firefly_clamp.is_some()),
        ];
        let found = of_paths.iter().find(|(_, is_given)| *is_given);
        ensure!(
            found.is_none(),
            "{}: add --integrator path",
            found.map_or("", |(flag, _)| flag)
        );
        return Ok(());
    }
    let of_direct = [
        ("--frames", options.frames.is_some()),
        ("--show", options.show != RenderMode::Shaded),
        ("--specialize", options.specialize),
        ("--normals", options.normals.is_some()),
    ];
    let found = of_direct.iter().find(|(_, is_given)| *is_given);
    ensure!(
        found.is_none(),
        "{}: --integrator path makes a shaded still: omit it",
        found.map_or("", |(flag, _)| flag)
    );
    Ok(())
}

fn still_options(flags: &StillArgs) -> StillOptions {
    let defaults = StillOptions::default();
    StillOptions {
        samples: flags.samples.unwrap_or(defaults.samples),
        firefly_clamp: flags.firefly_clamp,
        time_limit: flags.time_limit.map(Duration::from_secs_f32),
        is_transparent: flags.transparent,
        ..defaults
    }
}

pub(crate) fn run(options: &RenderArgs) -> anyhow::Result<()> {
    let path = picture_path(options)?;
    output::check_place(&path, &options.scene)?;
    let on = &options.on;
    let begin = Instant::now();
    let control = crate::progress::control();
    let engine = input::engine(on)?.with_control(&control);
    let start = Instant::now();
    let (_, mut world) = input::world(
        &options.scene,
        &engine,
        options.via,
        &options.volume,
        (options.time, on.allow_external_meshes),
    )?;
    let folder = options.scene.parent().unwrap_or(Path::new("."));
    world.load_environment(folder, on.allow_external_meshes)?;
    let camera = options
        .camera
        .map_or_else(|| world.camera(), |placement| world.camera_at(placement));
    let settings = crate::render::settings(options, &world);
    let asked = still_options(&options.still);
    let plan = StillPlan {
        path: &options.scene,
        camera: &camera,
        settings,
        options: asked,
        begin,
        is_fixed: options.via.is_some(),
    };
    let world = plan.chosen(world)?;
    let build_ms = start.elapsed().as_secs_f64() * 1e3;
    let asked = StillOptions {
        time_limit: plan.time_left(),
        ..asked
    };
    let start = Instant::now();
    *MAKING.lock().unwrap_or_else(PoisonError::into_inner) = Some(control.clone());
    let still = world.still(&camera, &settings, &asked);
    MAKING.lock().unwrap_or_else(PoisonError::into_inner).take();
    let mut still = still?;
    let is_interrupted = control.is_cancelled();
    let samples = still.samples();
    fill_gaps(&path, &mut still)?;
    let paths_ms = start.elapsed().as_secs_f64() * 1e3;
    write(&path, options, &world, &still)?;
    let [width, height] = still.size();
    if options.json {
        output::json(&json!({
            "device": engine.device(),
            "via": world.representation().name(),
            "integrator": "path",
            "size": [width, height],
            "brushes": world.program().brush_count(),
            "samples": samples,
            "interrupted": is_interrupted,
            "build_ms": build_ms,
            "frame_ms": output::times(&[paths_ms]),
            "hit_pixels": still.hit_pixels(),
            "gpu": output::gpu_counters(&engine),
            "picture": path.display().to_string(),
        }));
        return Ok(());
    }
    output::line(&format!("{} ({width}x{height})", path.display()));
    output::line(&format!(
        "{samples} paths a pixel in {:.1} s{}",
        1e-3 * paths_ms,
        if is_interrupted { ", interrupted" } else { "" }
    ));
    Ok(())
}

/// Shows a neighbor where no path was, and says so.
fn fill_gaps(path: &Path, still: &mut Still) -> anyhow::Result<()> {
    let count = still.fill_gaps();
    let path = path.display();
    ensure!(
        still.samples() > 0,
        "{path}: interrupted before each pixel had a path"
    );
    if count > 0 {
        let [width, height] = still.size();
        let all = width * height;
        eprintln!(
            "{path}: it ended before each pixel had a path: {count} of {all} show a neighbor's"
        );
    }
    Ok(())
}

/// Writes a still, without noise if that was asked for.
fn write(path: &Path, options: &RenderArgs, world: &World, still: &Still) -> anyhow::Result<()> {
    let radiance = if options.still.denoise {
        denoised(still)
    } else {
        still.radiance()
    };
    let development = Development::of_view(world.view());
    let opacity = options.still.transparent.then(|| still.opacity());
    let picture = Picture {
        size: still.size(),
        radiance: &radiance,
        opacity: opacity.as_deref(),
    };
    picture.write(path, &development)
}

fn is_exr(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("exr"))
}

fn picture_path(options: &RenderArgs) -> anyhow::Result<PathBuf> {
    if let Some(path) = &options.output
        && is_exr(path)
    {
        return Ok(path.clone());
    }
    let is_other = |path: &PathBuf| {
        let ending = path.extension();
        ending.is_some_and(|ending| !ending.eq_ignore_ascii_case("png"))
    };
    if let Some(path) = options.output.as_ref().filter(|path| is_other(path)) {
        bail!(
            "{}: stills are written as PNG or EXR; name it .png or .exr",
            path.display()
        );
    }
    let path = output::picture_path(options)?;
    path.context("a still needs a name: add -o")
}

/// What is written.
struct Picture<'a> {
    size: [u32; 2],
    radiance: &'a [[f32; 3]],
    /// How much of each pixel is hidden, if what is behind is left out.
    opacity: Option<&'a [f32]>,
}

impl Picture<'_> {
    fn write(&self, path: &Path, development: &Development) -> anyhow::Result<()> {
        let Some(opacity) = self.opacity else {
            if !is_exr(path) {
                save_png(
                    path,
                    self.size,
                    &developed(self.radiance, self.size[0], development),
                )?;
                return Ok(());
            }
            let pixels = self.radiance.as_flattened().to_vec();
            return self.encode(path, ImageFormat::OpenExr, |[w, h]| {
                Rgb32FImage::from_raw(w, h, pixels).map(DynamicImage::from)
            });
        };
        let all = self.radiance.iter().zip(opacity);
        if is_exr(path) {
            // Light of what is seen through is left out, as compositors expect (premultiplied).
            let pixels = all
                .flat_map(|(&[r, g, b], &share)| [r, g, b, share])
                .collect();
            return self.encode(path, ImageFormat::OpenExr, |[w, h]| {
                Rgba32FImage::from_raw(w, h, pixels).map(DynamicImage::from)
            });
        }
        let rows: Vec<[f32; 3]> = all
            .map(|(light, &share)| light.map(|c| c / share.max(1e-3)))
            .collect();
        let rgb = developed(&rows, self.size[0], development);
        let pixels = rgb
            .chunks_exact(3)
            .zip(opacity)
            .flat_map(|(rgb, &share)| [rgb[0], rgb[1], rgb[2], (255.0 * share + 0.5) as u8])
            .collect();
        self.encode(path, ImageFormat::Png, |[w, h]| {
            RgbaImage::from_raw(w, h, pixels).map(DynamicImage::from)
        })
    }

    fn encode(
        &self,
        path: &Path,
        format: ImageFormat,
        image: impl FnOnce([u32; 2]) -> Option<DynamicImage>,
    ) -> anyhow::Result<()> {
        let image = image(self.size).context("the picture has other pixels than its size")?;
        let mut bytes = std::io::Cursor::new(Vec::new());
        let place = || path.display().to_string();
        image.write_to(&mut bytes, format).with_context(place)?;
        argil::scene::write_atomically(path, |out| out.write_all(bytes.get_ref()))
            .with_context(place)
    }
}
