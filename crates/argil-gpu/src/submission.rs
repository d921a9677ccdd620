//! Whether commands in the encoder of a host were submitted, and are done.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const PENDING: u8 = 0;
const DONE: u8 = 1;
const DROPPED: u8 = 2;

/// The submission of commands that a host submits with others.
#[derive(Clone, Debug)]
pub(crate) struct Submission(Arc<AtomicU8>);

/// What wgpu calls when the commands are done, and drops when their encoder is dropped.
struct Notice(Arc<AtomicU8>);

impl Drop for Notice {
    fn drop(&mut self) {
        let (old, new) = (PENDING, DROPPED);
        // It fails if they are done.
        let _ = self
            .0
            .compare_exchange(old, new, Ordering::Relaxed, Ordering::Relaxed);
    }
}

impl Submission {
    /// Follows the commands of an encoder.
    pub(crate) fn of(encoder: &wgpu::CommandEncoder) -> Self {
        let state = Arc::new(AtomicU8::new(PENDING));
        let notice = Notice(state.clone());
        encoder.on_submitted_work_done(move || notice.0.store(DONE, Ordering::Relaxed));
        Self(state)
    }

    /// Returns that of commands that were submitted, after which nothing else can come before them.
    pub(crate) fn made() -> Self {
        Self(Arc::new(AtomicU8::new(DONE)))
    }

    /// Whether what is submitted from now on comes after it.
    pub(crate) fn is_done(&self) -> bool {
        self.0.load(Ordering::Relaxed) == DONE
    }

    /// Whether its encoder was dropped, so that it is never made.
    pub(crate) fn is_dropped(&self) -> bool {
        self.0.load(Ordering::Relaxed) == DROPPED
    }
}
