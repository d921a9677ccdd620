//! Who follows a scene, and from how far edits matter to them.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Two distances in the scene's unit: those below the first are kept as they are, as in a volume's narrow band; those below the second
/// at least as bounds, as in its empty cells.
type Bands = [f32; 2];

/// What follows a scene's edits holds one: while it does, the boxes of edits hold every change within its bands.
/// Worlds do so by themselves.
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

    /// From how far edits matter from now on.
    pub fn set(&self, bands: Bands) {
        for (own, band) in self.0.iter().zip(bands) {
            own.store(band.max(0.0).to_bits(), Ordering::Relaxed);
        }
    }
}

fn bands_of(watch: &[AtomicU32; 2]) -> Bands {
    [&watch[0], &watch[1]].map(|bits| f32::from_bits(bits.load(Ordering::Relaxed)))
}

/// The watches of a scene; its clones have their own.
#[derive(Debug, Default)]
pub(crate) struct MarginRequests(Mutex<Vec<Weak<[AtomicU32; 2]>>>);

impl Clone for MarginRequests {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// The bands where nobody follows: edits tell boxes all the same.
const NO_MARGINS: Bands = [0.1; 2];

impl MarginRequests {
    pub(crate) fn add(&self, bands: Bands) -> MarginRequest {
        let watch = MarginRequest::new(bands);
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|watch| watch.strong_count() > 0);
        all.push(Arc::downgrade(&watch.0));
        watch
    }

    /// The widest of all that are held.
    pub(crate) fn maximum(&self) -> Bands {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let held = all.iter().filter_map(Weak::upgrade);
        let widest = held
            .map(|watch| bands_of(&watch))
            .reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        widest.unwrap_or(NO_MARGINS)
    }
}
