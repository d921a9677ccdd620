//! All tests of this crate, as one program: its parts are linked once.

mod far_pages;
mod file;
mod instances;
mod layouts;
mod level_sets;
mod tiles;
