//! All tests of this crate, as one program: its parts are linked once.

mod command;
mod common;
mod compare;
mod edit;
mod export;
mod gpu_counters;
mod heat;
mod images;
mod levels;
mod mesh;
mod still;
mod studio;
mod volume;
#[cfg(feature = "world")]
mod world;
