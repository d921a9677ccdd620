//! Levels of detail: bakes the pages that images need.

use super::World;
use crate::device::Device;
use crate::program_cache::ProgramCache;
use crate::{RenderError, Representation};
use argil_render::{Camera, RenderMode, RenderSettings};
use argil_volume::{FillStats, Levels, TileSource};
use std::sync::Arc;
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
        self.device.levels()
    }

    /// Takes pages of levels of detail from a store from now on, as far as edits did not change them. Without
    /// `bakes_missing`, rays see what is coarser where the store lacks a tile. Returns false for another representation.
    pub fn set_tile_source(&mut self, source: Arc<dyn TileSource>, bakes_missing: bool) -> bool {
        let program = &ProgramCache::of(&self.program, &self.edits).program;
        let Some(levels) = self.device.levels_mut() else {
            return false;
        };
        levels.set_source(source, program, bakes_missing);
        true
    }

    /// Bakes bricks of levels of detail that images asked for since the last call, the most urgent first, until
    /// `max_ms` milliseconds have passed. Call it after each frame. Does nothing for another representation.
    ///
    /// ```
    /// use argil::{LevelsOptions, prelude::*};
    /// let mut scene = Scene::new();
    /// scene.push(Shape::sphere(0.5))?;
    /// let mut world = Engine::cpu().build(&scene)?.with_representation(LevelsOptions::from(4096))?;
    /// let settings = world.render_settings([640, 360], RenderMode::Normal);
    /// world.render(&world.camera(), &settings)?;
    /// let filled = world.fill_pages(5.0)?;
    /// assert!(filled.bricks > 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the device fails.
    pub fn fill_pages(&mut self, max_ms: f64) -> Result<FillStats, RenderError> {
        let seconds = (max_ms * 1e-3).clamp(0.0, 1e6);
        let until = max_ms
            .is_finite()
            .then(|| Instant::now() + Duration::from_secs_f64(seconds));
        let Some(levels) = self.device.levels_mut() else {
            return Ok(FillStats::default());
        };
        let program = &ProgramCache::of(&self.program, &self.edits).program;
        let filled = levels.fill(program, until);
        self.device.follow_levels()?;
        Ok(filled)
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
        // Small images ask for most of what large ones need, level after level. What only light reads comes last.
        let normals = [(SHRINK, RenderMode::Normal), (1, RenderMode::Normal)];
        let light = [(SHRINK, RenderMode::Shaded), (1, RenderMode::Shaded)];
        let is_lit = settings.mode == RenderMode::Shaded;
        let light = light.into_iter().filter(|_| is_lit);
        for (shrink, mode) in normals.into_iter().chain(light) {
            let usual = self.set_pixel_error(|usual| usual / shrink as f32);
            let shrunk = RenderSettings {
                mode,
                size: settings.size.map(|side| side.div_ceil(shrink)),
                ..*settings
            };
            let passes = self.refine_passes(camera, &shrunk).await;
            self.set_pixel_error(|_| usual);
            done += passes?;
        }
        Ok(done)
    }

    /// Renders images, and bakes what they are missing, until they lack nothing.
    async fn refine_passes(
        &mut self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<FillStats, RenderError> {
        let mut done = FillStats::default();
        for _ in 0..MAX_PASSES {
            self.render_async(camera, settings).await?;
            let filled = self.fill_pages(f64::INFINITY)?;
            done += filled;
            if filled.answered == 0 && !filled.is_full {
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
        let Some(levels) = self.device.levels_mut() else {
            return 1.0;
        };
        let usual = levels.pixel_error();
        levels.set_pixel_error(change(usual));
        usual
    }
}
