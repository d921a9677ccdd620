//! All tests of this crate, as one program: its parts are linked once.

mod circles;
mod identifiers;
mod length;
mod prose;
mod shader_stats;
mod targets;
