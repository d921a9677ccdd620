//! What the paths of a still pass through, and how long they will take.

use argil::field::SurfaceReach;
use argil::render::{Camera, RenderSettings, StillOptions};
use argil::{BricksOptions, Representation, World};
use std::path::Path;
use std::time::Instant;

/// Voxels along the longest side of bricks, for each pixel along the image's longest side: about a pixel where all is in view.
const VOXELS_PER_PIXEL: f32 = 0.75;
/// The fewest and the most voxels along the longest side.
const VOXELS: [u32; 2] = [256, 1024];
/// How many times as short a side of the image is that is timed.
const SHRINK: u32 = 8;
/// Seconds: shorter stills are not announced, and not made through anything else.
const PATIENCE: f64 = 10.0;
/// Bricks take less than this share of the field's time, or the field stays.
const GAIN: f64 = 0.75;

/// A still to be made.
pub(crate) struct StillPlan<'a> {
    pub path: &'a Path,
    pub settings: RenderSettings,
    pub options: StillOptions,
    /// Whether paths have to pass through the world as it is.
    pub is_fixed: bool,
}

impl StillPlan<'_> {
    /// Says on stderr how long a still will take, if that is long. If paths take less time through bricks than through the field,
    /// returns the world as bricks, and says so.
    ///
    /// # Errors
    /// As for the still.
    pub(crate) fn chosen(&self, world: World, camera: &Camera) -> anyhow::Result<World> {
        let mut world = world;
        let mut seconds = self.seconds(&world, camera)?;
        if seconds > PATIENCE
            && let Some(options) = self.bricks(&world)
        {
            let start = Instant::now();
            let built = world.engine().build(world.scene())?;
            // Bricks that do not fit into memory are none.
            if let Ok(bricks) = built.with_representation(options) {
                let build_seconds = start.elapsed().as_secs_f64();
                let through_bricks = self.seconds(&bricks, camera)?;
                if build_seconds + through_bricks < GAIN * seconds {
                    eprintln!(
                        "{}: paths pass through bricks, {} voxels along the longest side. Through the exact field (--via field) they \
                         would take about {seconds:.0} s",
                        self.path.display(),
                        options.resolution
                    );
                    (world, seconds) = (bricks, through_bricks);
                }
            }
        }
        if seconds > PATIENCE {
            let [width, height] = self.settings.size;
            let of_these = match self.options.time_limit {
                Some(limit) if limit.as_secs_f64() < seconds => {
                    format!(", of which --time-limit allows {} s", limit.as_secs_f64())
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

    /// Returns how long a still takes, from the paths of a small image.
    fn seconds(&self, world: &World, camera: &Camera) -> anyhow::Result<f64> {
        let size = self.settings.size.map(|side| (side / SHRINK).max(1));
        let small = RenderSettings {
            size,
            ..self.settings
        };
        let few = StillOptions {
            samples: 1,
            ..self.options
        };
        // The first one also compiles shaders, and prepares programs.
        world.still(camera, &small, &few)?;
        let start = Instant::now();
        world.still(camera, &small, &few)?;
        let pixels = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
        let paths = pixels(self.settings.size) * f64::from(self.options.samples);
        Ok(start.elapsed().as_secs_f64() * paths / pixels(size))
    }

    /// Returns bricks that show the same solid as the field of a world, if there are such. Glass, whose inside matters, and what has
    /// no end stay in the field.
    fn bricks(&self, world: &World) -> Option<BricksOptions> {
        let program = world.program();
        let is_field = world.representation() == Representation::Field;
        if self.is_fixed || !is_field || program.has_glass() {
            return None;
        }
        let solid = program.aabb();
        // Bricks end at the view's bounds.
        let is_whole = world.view().bounds.is_none_or(|[min, max]| {
            let surface = SurfaceReach::new(program, solid).aabb();
            let (min, max) = (surface.min.cmpge(min.into()), surface.max.cmple(max.into()));
            min.all() && max.all()
        });
        let pixels = self.settings.size.into_iter().max().unwrap_or(0) as f32;
        let voxels = (VOXELS_PER_PIXEL * pixels) as u32;
        (solid.is_finite() && is_whole).then(|| BricksOptions {
            resolution: voxels.clamp(VOXELS[0], VOXELS[1]),
            ..BricksOptions::default()
        })
    }
}
