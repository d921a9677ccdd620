//! The margins that worlds need for dirty boxes.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Two distances in the scene's unit. Distances below the first are stored as samples, as in a narrow band.
/// Distances below the second are stored as bounds, as in empty cells.
type Bands = [f32; 2];

/// A request for margins. While it exists, dirty boxes contain every change within these margins of a surface.
/// Worlds hold one by themselves.
///
/// ```
/// use argil_scene::{Brush, Scene, Shape};
/// let mut scene = Scene::new();
/// let request = scene.request_margins([0.5, 2.0]);
/// assert_eq!(scene.margins(), [0.5, 2.0]);
/// request.set([0.25, 3.0]);
/// assert_eq!(scene.margins(), [0.25, 3.0]);
/// ```
#[derive(Clone, Debug)]
pub struct MarginRequest(Arc<[AtomicU32; 2]>);

impl MarginRequest {
    fn new(bands: Bands) -> Self {
        let watch = Self(Arc::default());
        watch.set(bands);
        watch
    }

    /// Changes the requested margins, from the next edit on.
    pub fn set(&self, bands: Bands) {
        for (bits, band) in self.0.iter().zip(bands) {
            bits.store(band.max(0.0).to_bits(), Ordering::Relaxed);
        }
    }
}

fn bands_of(watch: &[AtomicU32; 2]) -> Bands {
    [&watch[0], &watch[1]].map(|bits| f32::from_bits(bits.load(Ordering::Relaxed)))
}

/// The requests for a scene. A clone has its own.
#[derive(Debug, Default)]
pub(crate) struct MarginRequests(Mutex<Vec<Weak<[AtomicU32; 2]>>>);

impl Clone for MarginRequests {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// The margins without requests.
const NO_MARGINS: Bands = [0.1; 2];

impl MarginRequests {
    pub(crate) fn add(&self, bands: Bands) -> MarginRequest {
        let watch = MarginRequest::new(bands);
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|watch| watch.strong_count() > 0);
        all.push(Arc::downgrade(&watch.0));
        watch
    }

    /// Returns the largest of all requested margins.
    pub(crate) fn maximum(&self) -> Bands {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let requests = all.iter().filter_map(Weak::upgrade);
        let widest = requests
            .map(|watch| bands_of(&watch))
            .reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        widest.unwrap_or(NO_MARGINS)
    }
}
