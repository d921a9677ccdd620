//! The pictures that are shown.

use crate::render_worker::{Pipeline, RenderRequest, WorkerImage};
use argil::glam::Vec2;
use eframe::egui::TextureHandle;
use std::time::Duration;
use web_time::Instant;

/// A picture that is shown.
pub(crate) struct ShownImage {
    pub texture: TextureHandle,
    pub picture: WorkerImage,
}

/// See the module's page.
#[derive(Default)]
pub(crate) struct ViewportImages {
    pub shown: Vec<ShownImage>,
    pub difference: Option<TextureHandle>,
    /// What was drawn last.
    pub last: Option<RenderRequest>,
    /// What edits took the last time that there were some.
    pub edit_ms: Option<f64>,
    /// When something moved last.
    pub moved: Option<Instant>,
    /// Points of the picture.
    pub size: Vec2,
    pub pixels_per_point: f32,
    /// Whether what is shown is what there is, in full.
    pub is_settled: bool,
    /// Whether two pipelines are compared, and which is the second.
    pub split: Option<Pipeline>,
    /// Where the divider is, from 0 to 1.
    pub divider: f32,
    /// Whether their difference is shown in place of both.
    pub shows_difference: bool,
    /// What it took for each pixel of the last moving picture.
    pub ms_per_pixel: Option<f64>,
    pub fault: Option<String>,
    /// What the last answer took.
    pub duration_ms: f64,
}

/// So long nothing must move before the picture is drawn in full.
pub(crate) const REST: Duration = Duration::from_millis(150);
/// A picture that moves is to take no longer.
pub(crate) const MOVING_MS: f64 = 50.0;
/// One that is still, with one sample, is begun with where it takes longer.
pub(crate) const LONG_MS: f64 = 150.0;
/// Outlines of more than this are not drawn.
pub(crate) const MAX_OUTLINED: usize = 12;

impl ViewportImages {
    /// Another document.
    pub(crate) fn forget(&mut self) {
        self.last = None;
        self.is_settled = false;
    }

    /// Show the difference of two pictures in place of both, or both again.
    pub(crate) fn switch_difference(&mut self) {
        self.shows_difference = !self.shows_difference;
    }

    /// Why there is no picture.
    pub(crate) fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Ask for a picture anew.
    pub(crate) fn forget_request(&mut self) {
        self.last = None;
        self.is_settled = false;
    }

    /// The pipelines that are shown, and at what resolution.
    pub(crate) fn last_shown(&self) -> Option<([Option<Pipeline>; 2], u32)> {
        let last = self.last.as_ref()?;
        let pipelines = [0, 1].map(|i| last.pipelines.get(i).copied());
        Some((pipelines, last.resolution))
    }

    /// How far the ray through a part of the picture goes to a solid.
    pub(crate) fn length_at(&self, part: Vec2) -> Option<f32> {
        let is_left = part.x < self.divider;
        let shown = match &self.shown[..] {
            [_, second] if !is_left => second,
            [first, ..] => first,
            [] => return None,
        };
        let [width, height] = shown.picture.size;
        let x = (part.x * width as f32) as usize;
        let y = (part.y * height as f32) as usize;
        let all = &shown.picture.lengths;
        all.get(y.min(height as usize) * width as usize + x)
            .copied()
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
