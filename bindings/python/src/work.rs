//! Runs long work on a thread of its own, without Python's lock. Ctrl-C cancels it, and a callback hears of its progress.

use argil::math::Control;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How often Python is asked for signals, and told of progress.
const INTERVAL: Duration = Duration::from_millis(30);

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
            let result = catch_unwind(AssertUnwindSafe(|| work(control)));
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
    let result = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
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
