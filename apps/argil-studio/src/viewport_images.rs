//! The images in the viewport.

use crate::pipeline::Pipeline;
use crate::render_worker::{RenderRequest, WorkerImage};
use crate::texture_pool::TexturePool;
use crate::viewport_renderer::{ShownTextures, ViewportRenderer};
use argil::glam::Vec2;
use eframe::egui_wgpu::RenderState;
use std::sync::Arc;
use std::time::Duration;
use web_time::Instant;

/// The images in the viewport.
#[derive(Default)]
pub(crate) struct ViewportImages {
    pub shown: Vec<WorkerImage>,
    /// The same, ready to be drawn.
    pub textures: Option<Arc<ShownTextures>>,
    /// What draws them, unless there is no window.
    pub renderer: Option<(Arc<ViewportRenderer>, TexturePool)>,
    /// The last request that was rendered.
    pub last: Option<RenderRequest>,
    /// Duration of the last edits in milliseconds.
    pub edit_ms: Option<f64>,
    /// Time of the last movement.
    pub moved: Option<Instant>,
    /// Size of the image in points.
    pub size: Vec2,
    pub pixels_per_point: f32,
    /// Whether the final image of the current document is shown.
    pub is_settled: bool,
    /// The second pipeline of a comparison.
    pub split: Option<Pipeline>,
    /// Position of the divider, from 0 to 1.
    pub divider: f32,
    /// Whether the difference is shown instead of both images.
    pub shows_difference: bool,
    /// Duration per pixel of the last image during movement.
    pub ms_per_pixel: Option<f64>,
    pub fault: Option<String>,
    /// Duration of the last answer.
    pub duration_ms: f64,
}

/// Duration without movement before the final image is rendered.
pub(crate) const REST: Duration = Duration::from_millis(150);
/// Target duration of an image during movement.
pub(crate) const MOVING_MS: f64 = 50.0;
/// Duration above which a still image is first rendered with one sample.
pub(crate) const LONG_MS: f64 = 150.0;
/// Maximum number of outlines.
pub(crate) const MAX_OUTLINED: usize = 12;

impl ViewportImages {
    /// Creates what is shown in a window, if there is one: nothing yet.
    pub(crate) fn in_window(window: Option<&RenderState>) -> Self {
        let renderer = window.map(|state| {
            let renderer = ViewportRenderer::new(state);
            let pool = renderer.pool();
            (Arc::new(renderer), pool)
        });
        Self {
            renderer,
            ..Self::default()
        }
    }

    /// Resets the state for another document.
    pub(crate) fn forget(&mut self) {
        self.last = None;
        self.is_settled = false;
    }

    /// Switches between the difference and both images.
    pub(crate) fn switch_difference(&mut self) {
        self.shows_difference = !self.shows_difference;
    }

    /// Returns the reason why there is no image.
    pub(crate) fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Requests the image again.
    pub(crate) fn forget_request(&mut self) {
        self.last = None;
        self.is_settled = false;
    }

    /// Returns the pipelines shown, and their resolution.
    pub(crate) fn last_shown(&self) -> Option<([Option<Pipeline>; 2], u32)> {
        let last = self.last.as_ref()?;
        let pipelines = [0, 1].map(|i| last.pipelines.get(i).copied());
        Some((pipelines, last.resolution))
    }

    /// See [`Studio::shown`].
    pub(crate) fn shown_request(&self) -> Option<(u64, bool, f64)> {
        let last = self.last.as_ref()?;
        Some((last.version, last.is_still, self.duration_ms))
    }

    pub(crate) fn is_long(&self, pixels: f64) -> bool {
        self.ms_per_pixel.is_some_and(|ms| ms * pixels > LONG_MS)
    }

    pub(crate) fn scale(&self, pixels: f64) -> f64 {
        match self.ms_per_pixel {
            Some(ms) => (MOVING_MS / (ms * pixels)).sqrt().clamp(0.2, 1.0),
            None => 0.5,
        }
    }
}
