//! All tests of this crate, as one program: its parts are linked once.

mod hardware;
mod measures;
mod study;
