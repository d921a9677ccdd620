//! Cancels long work, and reports its progress.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Cancels long work from another thread, and reports its progress. Clones control the same work.
///
/// The [default](Control::default) cannot cancel, and reports nothing.
///
/// ```
/// use argil_math::Control;
/// let control = Control::new();
/// let seen = control.clone();
/// control.begin("bricks", 10);
/// control.advance(4);
/// assert_eq!(seen.progress().map(|p| (p.stage, p.done, p.total)), Some(("bricks", 4, 10)));
/// seen.cancel();
/// assert!(control.is_cancelled());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Control(Option<Arc<Shared>>);

#[derive(Debug, Default)]
struct Shared {
    is_cancelled: AtomicBool,
    stage: Mutex<&'static str>,
    done: AtomicU64,
    total: AtomicU64,
}

/// The progress of long work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Name of the current stage.
    pub stage: &'static str,
    /// Finished parts.
    pub done: u64,
    /// Number of parts, or 0 if it is unknown.
    pub total: u64,
}

impl Control {
    /// Creates a control for work that has not begun.
    pub fn new() -> Self {
        Self(Some(Arc::default()))
    }

    /// Cancels the work. It ends as soon as possible, with an error that says so.
    pub fn cancel(&self) {
        if let Some(shared) = &self.0 {
            shared.is_cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// Whether the work is canceled.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        let shared = self.0.as_ref();
        shared.is_some_and(|shared| shared.is_cancelled.load(Ordering::Relaxed))
    }

    /// Returns the progress of the current stage. `None` before the first one, and for the default.
    pub fn progress(&self) -> Option<Progress> {
        let shared = self.0.as_ref()?;
        let stage = *shared.stage.lock().unwrap_or_else(PoisonError::into_inner);
        (!stage.is_empty()).then(|| Progress {
            stage,
            done: shared.done.load(Ordering::Relaxed),
            total: shared.total.load(Ordering::Relaxed),
        })
    }

    /// Begins a stage with a number of parts.
    pub fn begin(&self, stage: &'static str, total: u64) {
        if let Some(shared) = &self.0 {
            *shared.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage;
            shared.done.store(0, Ordering::Relaxed);
            shared.total.store(total, Ordering::Relaxed);
        }
    }

    /// Ends the current stage.
    pub fn end(&self) {
        if let Some(shared) = &self.0 {
            let total = shared.total.load(Ordering::Relaxed).max(1);
            shared.total.store(total, Ordering::Relaxed);
            shared.done.store(total, Ordering::Relaxed);
        }
    }

    /// Counts finished parts.
    #[inline]
    pub fn advance(&self, parts: u64) {
        if let Some(shared) = &self.0 {
            shared.done.fetch_add(parts, Ordering::Relaxed);
        }
    }
}
