//! Levels of detail: brings the pages that images need.

use super::World;
use crate::program_cache::ProgramCache;
use crate::representation::Storage;
use crate::{RenderError, Representation};
use argil_render::{Camera, RenderMode, RenderSettings};
use argil_volume::{FillStats, Levels, Volume};
use web_time::{Duration, Instant};

/// Maximum images of one refinement. Each brings the next finer level.
const MAX_PASSES: u32 = 64;

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

    /// Brings what a view lacks, as a future: see [`World::refine`].
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
        // Light comes from the field.
        let quick = RenderSettings {
            mode: RenderMode::Normal,
            ..*settings
        };
        for _ in 0..MAX_PASSES {
            self.render_async(camera, &quick).await?;
            let Some(own) = self.fill_pages(f64::INFINITY) else {
                break;
            };
            done += own;
            if own.answered == 0 || own.is_full {
                break;
            }
        }
        Ok(done)
    }
}
