//! What is waited for.

use crate::GpuError;
use std::pin::Pin;

/// Work of a trait's method, to be waited for. In a browser nothing of a GPU is sent to other threads.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) type Work<'a, T> = Pin<Box<dyn Future<Output = Result<T, GpuError>> + Send + 'a>>;
/// The same in a browser.
#[cfg(target_arch = "wasm32")]
pub(crate) type Work<'a, T> = Pin<Box<dyn Future<Output = Result<T, GpuError>> + 'a>>;
