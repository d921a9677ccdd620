//! What the paths of a still pass through, and how long they will take.

use argil::field::SurfaceReach;
use argil::render::{Camera, RenderSettings, Still, StillOptions};
use argil::{BricksOptions, BuildError, Representation, StillError, World};
use std::path::Path;
use std::time::{Duration, Instant};

/// The fewest and the most voxels along the longest side.
const VOXELS: [f32; 2] = [256.0, 1024.0];
/// How many times as short a side of the image is that is timed, and its fewest pixels.
const SHRINK: u32 = 16;
const TIMED: u32 = 32;
/// Paths of a pixel that are timed.
const PATHS: u32 = 2;
/// Seconds: shorter stills are not announced, and not made through anything else.
const PATIENCE: f64 = 10.0;
/// Bricks take less than this share of the field's time, or the field stays.
const GAIN: f64 = 0.75;

/// A still to be made.
pub(crate) struct StillPlan<'a> {
    pub path: &'a Path,
    pub camera: &'a Camera,
    pub settings: RenderSettings,
    pub options: StillOptions,
    /// When the command began: its time limit counts from there.
    pub begin: Instant,
    /// Whether paths have to pass through the world as it is.
    pub is_fixed: bool,
}

impl StillPlan<'_> {
    /// Returns what is left of the time limit.
    pub(crate) fn time_left(&self) -> Option<Duration> {
        let limit = self.options.time_limit?;
        Some(limit.saturating_sub(self.begin.elapsed()))
    }

    /// Says on stderr how long a still will take, if that is long. If paths take less time through bricks than through the field,
    /// returns the world as bricks, and says so.
    ///
    /// # Errors
    /// As for the still, or if bricks cannot be built for another reason than memory.
    pub(crate) fn chosen(&self, world: World) -> anyhow::Result<World> {
        let limit = || self.time_left().map(|limit| limit.as_secs_f64());
        let allowed = |seconds: f64| limit().map_or(seconds, |limit| limit.min(seconds));
        let (mut world, mut seconds) = (world, 0.0);
        if allowed(f64::INFINITY) > PATIENCE {
            seconds = self.seconds(&world)?;
        }
        if allowed(seconds) > PATIENCE
            && let Some(options) = self.bricks(&world)
        {
            let start = Instant::now();
            let built = world.engine().build(world.scene())?;
            match built.with_representation(options) {
                Ok(bricks) => {
                    let build_seconds = start.elapsed().as_secs_f64();
                    let through_bricks = self.seconds(&bricks)?;
                    // Where the limit ends both, what was built is no reason any more.
                    let is_limited = limit().is_some_and(|limit| limit < seconds);
                    let spent = if is_limited { 0.0 } else { build_seconds };
                    if spent + through_bricks < GAIN * seconds {
                        eprintln!(
                            "{}: paths pass through bricks, {} voxels along the longest side. Through the exact field (--via field) \
                             they would take about {seconds:.0} s",
                            self.path.display(),
                            options.resolution
                        );
                        (world, seconds) = (bricks, through_bricks);
                    }
                }
                // The field needs no memory.
                Err(BuildError::Memory { .. } | BuildError::Bricks(_) | BuildError::Gpu(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
        if allowed(seconds) > PATIENCE {
            let [width, height] = self.settings.size;
            let of_these = match limit() {
                Some(limit) if limit < seconds => {
                    format!(", of which --time-limit leaves {limit:.0} s")
                }
                _ => String::new(),
            };
            eprintln!(
                "{}: {} paths for each of {width}x{height} pixels take about {seconds:.0} s{of_these}",
                self.path.display(),
                self.options.samples
            );
        }
        Ok(world)
    }

    /// Returns how long the paths of a still take, from those of a small image.
    fn seconds(&self, world: &World) -> anyhow::Result<f64> {
        let size = self.settings.size;
        let size = size.map(|side| (side / SHRINK).max(TIMED).min(side));
        let pixels = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
        let passes = f64::from(self.options.samples) * pixels(self.settings.size) / pixels(size);
        if world.engine().gpu_kind().is_some() {
            return Ok(self.pass_seconds(world, size)? * passes);
        }
        // A small image has too few tiles for all threads, so that one thread is timed.
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let pass = alone.install(|| self.pass_seconds(world, size))?;
        Ok(pass * passes / rayon::current_num_threads() as f64)
    }

    /// Returns how long a path for each pixel of a small image takes, without what is done once for an image.
    fn pass_seconds(&self, world: &World, size: [u32; 2]) -> Result<f64, StillError> {
        let settings = RenderSettings {
            size,
            ..self.settings
        };
        let timed = |samples: u32| {
            let options = StillOptions {
                samples,
                time_limit: None,
                ..self.options
            };
            let mut still = Still::new(size);
            let start = Instant::now();
            world.refine_still(&mut still, self.camera, &settings, &options)?;
            Ok::<f64, StillError>(start.elapsed().as_secs_f64())
        };
        // The first one also compiles shaders, and prepares programs.
        timed(1)?;
        let once = timed(1)?;
        Ok((timed(1 + PATHS)? - once).max(0.0) / f64::from(PATHS))
    }

    /// Returns bricks that look like the field of a world from the camera: their voxels are as small as the nearest pixels. Glass,
    /// whose inside matters, and what has no end stay in the field.
    fn bricks(&self, world: &World) -> Option<BricksOptions> {
        let program = world.program();
        let is_field = world.representation() == Representation::Field;
        if self.is_fixed || !is_field || program.has_glass() || !program.aabb().is_finite() {
            return None;
        }
        let surface = SurfaceReach::new(program, program.aabb()).aabb();
        let height = 2.0 * (0.5 * self.camera.field_of_view_degrees).to_radians().tan();
        let pixel = surface.distance(self.camera.eye) * height / self.settings.size[1] as f32;
        let voxels = program.aabb().size().max_element() / pixel;
        (voxels <= VOXELS[1]).then(|| BricksOptions {
            resolution: voxels.max(VOXELS[0]) as u32,
            ..BricksOptions::default()
        })
    }
}
