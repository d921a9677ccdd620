//! Threads for long work beside a program that draws and edits.

use rayon::ThreadPoolBuilder;
use std::cell::Cell;

thread_local! {
    /// Whether this thread belongs to long work.
    static IS_BACKGROUND: Cell<bool> = const { Cell::new(false) };
}

/// Runs long work on threads of its own, half as many as rayon has and at least one, and waits for it. On rayon's global threads,
/// what a frame or an edit asks for would wait until the whole work is done. Both share the machine's cores.
///
/// The work's uses of rayon stay on these threads. What it runs in the background in turn stays there, too. Where no threads can
/// be started, as in a browser, it runs on the current ones.
///
/// ```
/// use rayon::prelude::*;
/// let sum = argil_field::in_background(|| (0..100u64).into_par_iter().sum::<u64>());
/// assert_eq!(sum, 4950);
/// ```
pub fn in_background<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if IS_BACKGROUND.get() {
        return work();
    }
    let threads = ThreadPoolBuilder::new()
        .num_threads((rayon::current_num_threads() / 2).max(1))
        .thread_name(|number| format!("argil background {number}"))
        .start_handler(|_| IS_BACKGROUND.set(true))
        .build();
    match threads {
        Ok(threads) => threads.install(work),
        Err(_) => work(),
    }
}
