//! An allocator that counts, and stops the program above a limit.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);

pub(crate) struct Counting;

fn add(bytes: usize) {
    let held = HELD.fetch_add(bytes, Relaxed) + bytes;
    PEAK.fetch_max(held, Relaxed);
    // Reporting takes memory itself.
    if held > LIMIT.load(Relaxed) && LIMIT.swap(usize::MAX, Relaxed) < held {
        crate::failure::fail(&format!("{held} bytes of memory"));
    }
}

// SAFETY: all memory comes from and goes to the system's allocator, with the same layouts.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.dealloc(place, layout) }
    }
}

/// Allows any memory, as messages take some.
pub(crate) fn unlimit() {
    LIMIT.store(usize::MAX, Relaxed);
}

/// Runs a function that may take some bytes of memory, and returns how many it took at once.
pub(crate) fn limited(bytes: usize, run: impl FnOnce()) -> usize {
    let before = HELD.load(Relaxed);
    PEAK.store(before, Relaxed);
    LIMIT.store(before.saturating_add(bytes), Relaxed);
    run();
    unlimit();
    PEAK.load(Relaxed).saturating_sub(before)
}
