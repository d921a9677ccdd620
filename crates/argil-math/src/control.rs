//! Stopping long work, and seeing how far it is.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Stops long work from another thread, and tells how far it is. Clones control the same work.
///
/// Work that is given the [default](Control::default) cannot be stopped and tells nothing.
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

/// How far work is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub stage: &'static str,
    /// Parts of it that are done.
    pub done: u64,
    /// Parts in all; 0 where that is not known.
    pub total: u64,
}

impl Control {
    /// Nothing has begun, nothing is cancelled.
    pub fn new() -> Self {
        Self(Some(Arc::default()))
    }

    /// Lets work end as soon as it can, with an error that says so.
    pub fn cancel(&self) {
        if let Some(shared) = &self.0 {
            shared.is_cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// Whether work is to end.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        let shared = self.0.as_ref();
        shared.is_some_and(|shared| shared.is_cancelled.load(Ordering::Relaxed))
    }

    /// How far the stage is that began last. `None` before the first, and of the default.
    pub fn progress(&self) -> Option<Progress> {
        let shared = self.0.as_ref()?;
        let stage = *shared.stage.lock().unwrap_or_else(PoisonError::into_inner);
        (!stage.is_empty()).then(|| Progress {
            stage,
            done: shared.done.load(Ordering::Relaxed),
            total: shared.total.load(Ordering::Relaxed),
        })
    }

    /// Begins a stage of so many parts.
    pub fn begin(&self, stage: &'static str, total: u64) {
        if let Some(shared) = &self.0 {
            *shared.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage;
            shared.done.store(0, Ordering::Relaxed);
            shared.total.store(total, Ordering::Relaxed);
        }
    }

    /// The stage that began last is over, however many parts it had.
    pub fn end(&self) {
        if let Some(shared) = &self.0 {
            let total = shared.total.load(Ordering::Relaxed).max(1);
            shared.total.store(total, Ordering::Relaxed);
            shared.done.store(total, Ordering::Relaxed);
        }
    }

    /// Counts parts that are done.
    #[inline]
    pub fn advance(&self, parts: u64) {
        if let Some(shared) = &self.0 {
            shared.done.fetch_add(parts, Ordering::Relaxed);
        }
    }
}
