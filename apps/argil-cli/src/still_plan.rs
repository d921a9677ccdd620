//! What the paths of a still pass through, and how long they will take.

use argil::field::SurfaceReach;
use argil::render::{Camera, RenderSettings, StillOptions};
use argil::scene::Scene;
use argil::{BricksOptions, BuildError, Representation, World};
use std::path::Path;
use std::time::{Duration, Instant};

/// Brushes from which paths through bricks take less time than through the field, with the time to bake them.
const MANY_BRUSHES: usize = 4;
/// Voxels along the longest side of bricks, for each pixel along the image's longest side: about a pixel where all is in view.
const VOXELS_PER_PIXEL: f32 = 0.75;
/// The fewest and the most voxels along the longest side.
const VOXELS: [u32; 2] = [256, 1024];
/// How many times as short a side of the image is that is timed.
const SHRINK: u32 = 8;
/// Shorter stills are not announced.
const PATIENCE: Duration = Duration::from_secs(5);

/// Builds a world again as bricks, if paths take less time through these than through its field, and says so on stderr.
///
/// # Errors
/// If the bricks do not fit into memory.
pub(crate) fn faster(
    world: World,
    scene: &Scene,
    size: [u32; 2],
    path: &Path,
) -> Result<World, BuildError> {
    let Some(bricks) = faster_bricks(&world, size) else {
        return Ok(world);
    };
    eprintln!(
        "{}: paths pass through bricks, {} voxels along the longest side: this takes less time than the exact field (--via field)",
        path.display(),
        bricks.resolution
    );
    world.rebuilt_as(scene, bricks.into())
}

/// Returns bricks through which paths take less time than through the field of a world, if there are such. They show the same solid:
/// it ends within them. Glass, whose inside matters, stays in the field.
fn faster_bricks(world: &World, size: [u32; 2]) -> Option<BricksOptions> {
    let program = world.program();
    let is_field = world.representation() == Representation::Field;
    if !is_field || program.brush_count() < MANY_BRUSHES || program.has_glass() {
        return None;
    }
    let solid = program.aabb();
    // Bricks end at the view's bounds.
    let is_whole = world.view().bounds.is_none_or(|[min, max]| {
        let surface = SurfaceReach::new(program, solid).aabb();
        let (min, max) = (surface.min.cmpge(min.into()), surface.max.cmple(max.into()));
        min.all() && max.all()
    });
    let pixels = size.iter().copied().max().unwrap_or(0) as f32;
    let voxels = (VOXELS_PER_PIXEL * pixels) as u32;
    (solid.is_finite() && is_whole).then(|| BricksOptions {
        resolution: voxels.clamp(VOXELS[0], VOXELS[1]),
        ..BricksOptions::default()
    })
}

/// Says on stderr how long a still will take, if that is long. Times the paths of a small image.
///
/// # Errors
/// As for the still.
pub(crate) fn announce(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    asked: &StillOptions,
    path: &Path,
) -> Result<(), argil::StillError> {
    let size = settings.size.map(|side| (side / SHRINK).max(1));
    let small = RenderSettings { size, ..*settings };
    let few = StillOptions {
        samples: 1,
        ..*asked
    };
    // The first one also compiles shaders, and prepares programs.
    world.still(camera, &small, &few)?;
    let start = Instant::now();
    world.still(camera, &small, &few)?;
    let of = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
    let per_path = start.elapsed().as_secs_f64() / of(size);
    let seconds = per_path * of(settings.size) * f64::from(asked.samples);
    let limit = asked.time_limit.map_or(f64::INFINITY, |l| l.as_secs_f64());
    if seconds.min(limit) > PATIENCE.as_secs_f64() {
        let [width, height] = settings.size;
        eprintln!(
            "{}: {} paths for each of {width}x{height} pixels take about {seconds:.0} s{}",
            path.display(),
            asked.samples,
            if seconds > limit {
                format!(", of which {limit:.0} s are allowed")
            } else {
                String::new()
            }
        );
    }
    Ok(())
}
