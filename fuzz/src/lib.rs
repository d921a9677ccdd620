//! Fuzz targets: each reader of files, on any bytes.
//!
//! *Practice.* A row of [`TARGETS`] is a reader, and seeds that reach far into it. `cargo xtask fuzz` changes seeds at random
//! and runs each target for a while, with a stable compiler. The package `libfuzzer` beside this one runs them by cargo-fuzz.

mod mutate;
mod scenes;
mod seeds;
mod targets;
mod worlds;

pub use mutate::Mutator;
pub use targets::{CONTROLS, TARGETS, Target};

/// Returns the target with a name.
pub fn find(name: &str) -> Option<&'static Target> {
    TARGETS
        .iter()
        .chain(CONTROLS)
        .find(|target| target.name == name)
}
