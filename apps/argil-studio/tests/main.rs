//! All tests of this crate, as one program: its parts are linked once.

mod changes;
mod common;
mod consent;
mod flows;
mod lights;
mod pictures;
mod program;
mod worlds;
