//! Runs long work on a thread of its own, without Python's lock. Ctrl-C cancels it, and a callback hears of its progress.

use argil::math::Control;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How often Python is asked for signals, and told of progress.
const INTERVAL: Duration = Duration::from_millis(30);

/// The threads of this process. A fork has none of its parent's, and makes its own.
static THREADS: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

fn threads() -> Arc<ThreadPool> {
    let mut threads = locked(&THREADS);
    let process = std::process::id();
    if let Some((owner, pool)) = &*threads
        && *owner == process
    {
        return pool.clone();
    }
    let made = ThreadPoolBuilder::new().build();
    let pool = Arc::new(made.unwrap_or_else(|error| panic!("no threads: {error}")));
    // The parent's threads are not here to be ended.
    std::mem::forget(threads.replace((process, pool.clone())));
    pool
}

/// Runs work that a [`Control`] can cancel.
///
/// # Errors
/// KeyboardInterrupt, what the callback raised, or RuntimeError if the work panicked.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> T + Send,
) -> PyResult<T> {
    let control = Control::new();
    let mut stopped = None;
    let result = std::thread::scope(|scope| {
        let (done, finished) = channel();
        let control = &control;
        let worker = scope.spawn(move || {
            let pool = threads();
            let result = catch_unwind(AssertUnwindSafe(|| pool.install(|| work(control))));
            // The receiver outlives this thread.
            let _ = done.send(());
            result
        });
        let finished = Mutex::new(finished);
        let wait = || match finished.lock() {
            Ok(finished) => finished.recv_timeout(INTERVAL),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        };
        loop {
            let waited = py.detach(wait);
            if !matches!(waited, Err(RecvTimeoutError::Timeout)) {
                break;
            }
            let heard = py
                .check_signals()
                .and_then(|()| progress.map_or(Ok(()), |callback| report(control, callback)));
            if let Err(error) = heard {
                control.cancel();
                stopped.get_or_insert(error);
            }
        }
        py.detach(|| worker.join())
    });
    if let Some(error) = stopped {
        return Err(error);
    }
    match result {
        Ok(Ok(result)) => Ok(result),
        Ok(Err(panic)) | Err(panic) => Err(internal_error(&*panic)),
    }
}

/// Runs short work without Python's lock.
///
/// # Errors
/// RuntimeError if the work panicked.
pub fn run_short<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = threads();
    let result = py.detach(|| catch_unwind(AssertUnwindSafe(|| pool.install(work))));
    result.map_err(|panic| internal_error(&*panic))
}

fn internal_error(panic: &(dyn std::any::Any + Send)) -> PyErr {
    let text = panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("unknown");
    PyRuntimeError::new_err(format!("internal error of argil, please report it: {text}"))
}

fn report(control: &Control, callback: &Bound<'_, PyAny>) -> PyResult<()> {
    if let Some(progress) = control.progress() {
        callback.call1((progress.stage, progress.done, progress.total))?;
    }
    Ok(())
}

/// Locks what no panic leaves half done.
pub fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
