//! Levels of detail: bakes the pages that images need.

use super::World;
use crate::program_cache::ProgramCache;
use crate::representation::Storage;
use crate::{RenderError, Representation};
use argil_render::{Camera, RenderMode, RenderSettings};
use argil_volume::{FillStats, Levels, Volume};
use web_time::{Duration, Instant};

/// Maximum images of one refinement. Each asks for the next finer level.
const MAX_PASSES: u32 = 64;
/// How many times as short the sides of the first images are.
const SHRINK: u32 = 4;
/// The same for images that only prefetch.
const PREFETCH: u32 = 8;

impl World {
    /// Returns the levels of detail, or `None` for another representation.
    pub fn levels(&self) -> Option<&Levels> {
        match &self.storage {
            Storage::Cpu(Volume::Levels(levels)) => Some(levels),
            _ => None,
        }
    }

    /// Bakes bricks of levels of detail that images asked for since the last call, the most urgent first, until
    /// `max_ms` milliseconds have passed. Call it after each frame. Returns `None` for another representation.
    ///
    /// ```
    /// use argil::{LevelsOptions, prelude::*};
    /// let mut scene = Scene::new();
    /// scene.push(Shape::sphere(0.5))?;
    /// let mut world = Engine::cpu().build(&scene)?.with_representation(LevelsOptions::from(4096))?;
    /// let settings = world.render_settings([640, 360], RenderMode::Normal);
    /// world.render(&world.camera(), &settings)?;
    /// let filled = world.fill_pages(5.0).expect("levels");
    /// assert!(filled.bricks > 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fill_pages(&mut self, max_ms: f64) -> Option<FillStats> {
        let Storage::Cpu(Volume::Levels(levels)) = &mut self.storage else {
            return None;
        };
        let program = &ProgramCache::of(&self.program, &self.edits).program;
        let seconds = (max_ms * 1e-3).clamp(0.0, 1e6);
        let until = max_ms
            .is_finite()
            .then(|| Instant::now() + Duration::from_secs_f64(seconds));
        Some(levels.fill(program, until))
    }

    /// Bakes the bricks that a view is missing, as a future: see [`World::refine`].
    ///
    /// # Errors
    /// If a setting is out of range, or the work was canceled.
    pub async fn refine_async(
        &mut self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<FillStats, RenderError> {
        let mut done = FillStats::default();
        if !matches!(self.representation, Representation::Levels(_)) {
            return Ok(done);
        }
        // Small images ask for most of what large ones need, level after level.
        for shrink in [SHRINK, 1] {
            let usual = self.set_pixel_error(|usual| usual / shrink as f32);
            let passes = self.refine_passes(camera, settings, shrink).await;
            self.set_pixel_error(|_| usual);
            let own = passes?;
            done += own;
        }
        Ok(done)
    }

    /// Renders images whose sides are `shrink` times as short, and bakes what they are missing.
    async fn refine_passes(
        &mut self,
        camera: &Camera,
        settings: &RenderSettings,
        shrink: u32,
    ) -> Result<FillStats, RenderError> {
        // Light comes from the field.
        let quick = RenderSettings {
            mode: RenderMode::Normal,
            size: settings.size.map(|side| side.div_ceil(shrink)),
            ..*settings
        };
        let mut done = FillStats::default();
        for _ in 0..MAX_PASSES {
            self.render_async(camera, &quick).await?;
            let Some(own) = self.fill_pages(f64::INFINITY) else {
                break;
            };
            done += own;
            if own.answered == 0 && !own.is_full {
                break;
            }
        }
        Ok(done)
    }

    /// Asks for the bricks that a view will need, as a future: see [`World::prefetch`].
    ///
    /// # Errors
    /// If a setting is out of range, or the work was canceled.
    pub async fn prefetch_async(
        &mut self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<(), RenderError> {
        if !matches!(self.representation, Representation::Levels(_)) {
            return Ok(());
        }
        let quick = RenderSettings {
            mode: RenderMode::Normal,
            samples: 1,
            size: settings.size.map(|side| side.div_ceil(PREFETCH)),
            ..*settings
        };
        let usual = self.set_pixel_error(|usual| usual / PREFETCH as f32);
        let drawn = self.render_async(camera, &quick).await;
        self.set_pixel_error(|_| usual);
        drawn.map(|_| ())
    }

    /// Changes the size of a voxel that a ray accepts. Returns the size before.
    fn set_pixel_error(&mut self, change: impl FnOnce(f32) -> f32) -> f32 {
        let Storage::Cpu(Volume::Levels(levels)) = &mut self.storage else {
            return 1.0;
        };
        let usual = levels.pixel_error();
        levels.set_pixel_error(change(usual));
        usual
    }
}
