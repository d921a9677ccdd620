//! Waiting for a device.

/// What comes of work that waits for nothing but a device: everywhere but in a browser that is waited for in place.
///
/// # Panics
/// In a browser, if there is something to be waited for. Worlds on the CPU have nothing; for those on a GPU there are the
/// asynchronous methods.
pub(crate) fn wait<T>(work: impl Future<Output = T>) -> T {
    #[cfg(not(target_arch = "wasm32"))]
    {
        pollster::block_on(work)
    }
    #[cfg(target_arch = "wasm32")]
    {
        use std::task::{Context, Poll, Waker};
        let work = std::pin::pin!(work);
        match work.poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(result) => result,
            Poll::Pending => panic!("a browser's GPU is waited for by the asynchronous methods"),
        }
    }
}
