//! A single image, and how long it will take.

use crate::args::RenderArgs;
use crate::heat_legend;
use argil::render::{Camera, RenderSettings};
use argil::volume::FillStats;
use argil::{RenderError, RenderedImage, Representation, World};
use std::path::Path;
use std::time::Instant;

/// Seconds: sooner images are not announced.
const PATIENCE: f64 = 10.0;
/// How many times as short a side of the image is that is timed, and its fewest pixels.
const SHRINK: u32 = 16;
const TIMED: u32 = 32;

/// Draws an image. Says on stderr how long one through the field will take, unless the field was asked for.
pub(crate) fn draw(
    options: &RenderArgs,
    world: &mut World,
    camera: &Camera,
    settings: &RenderSettings,
) -> anyhow::Result<(RenderedImage, FillStats)> {
    let is_on_cpu = world.engine().gpu_kind().is_none();
    if options.via.is_none() && is_on_cpu && world.representation() == Representation::Field {
        announce(world, camera, settings, &options.scene)?;
    }
    let refined = world.refine(camera, settings)?;
    let mut counted = *settings;
    counted.statistics = true;
    let mut drawn = world.render(camera, &counted)?;
    heat_legend::draw(&mut drawn);
    Ok((drawn, refined))
}

/// Says on stderr how long an image through the field will take, if that is long, and what is faster.
///
/// # Errors
/// As for the image.
fn announce(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    path: &Path,
) -> Result<(), RenderError> {
    let [width, height] = settings.size;
    let size = settings
        .size
        .map(|side| (side / SHRINK).max(TIMED).min(side));
    let pixels = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
    let small = RenderSettings { size, ..*settings };
    let timed = || {
        let start = Instant::now();
        world.render(camera, &small)?;
        let each = start.elapsed().as_secs_f64() / pixels(size);
        Ok::<f64, RenderError>(each * pixels(settings.size))
    };
    // The first one also prepares programs, and the second one does not.
    if timed()? <= PATIENCE {
        return Ok(());
    }
    let seconds = timed()?;
    if seconds > PATIENCE {
        let faster = match world.program().aabb().is_finite() {
            true => "--via bricks, or --via levels for what is wide",
            false => "--via levels",
        };
        eprintln!(
            "{}: this image of {width}x{height} pixels takes about {seconds:.0} s through the exact field. Sooner: {faster}",
            path.display()
        );
    }
    Ok(())
}
