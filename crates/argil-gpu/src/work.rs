//! Futures of trait methods.

use crate::GpuError;
use std::pin::Pin;

/// A future of a trait's method. In a browser, GPU objects are not sent to other threads.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) type Work<'a, T> = Pin<Box<dyn Future<Output = Result<T, GpuError>> + Send + 'a>>;
/// A future of a trait's method in a browser.
#[cfg(target_arch = "wasm32")]
pub(crate) type Work<'a, T> = Pin<Box<dyn Future<Output = Result<T, GpuError>> + 'a>>;
