//! Futures that wait for nothing, as those of worlds on the CPU.

/// What comes of it: all of its work is done here and now.
pub fn ready<T>(work: impl Future<Output = T>) -> T {
    pollster::block_on(work)
}
