//! Futures that never wait, such as those of worlds on the CPU.

use std::task::{Context, Poll, Waker};

/// Runs a future to its end at once.
///
/// # Panics
/// If it must wait, as a GPU world does.
pub(crate) fn ready<T>(work: impl Future<Output = T>) -> T {
    let work = std::pin::pin!(work);
    match work.poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => result,
        Poll::Pending => panic!("a world on the CPU waits for nothing"),
    }
}
