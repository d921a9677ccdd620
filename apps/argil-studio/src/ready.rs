//! Futures that wait for nothing, as those of worlds on the CPU.

use std::task::{Context, Poll, Waker};

/// What comes of it: all of its work is done here and now.
///
/// # Panics
/// If there is something to be waited for after all: of a world on a GPU, which is not what this is for.
pub(crate) fn ready<T>(work: impl Future<Output = T>) -> T {
    let work = std::pin::pin!(work);
    match work.poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => result,
        Poll::Pending => panic!("a world on the CPU waits for nothing"),
    }
}
