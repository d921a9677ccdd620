//! All tests of this crate, as one program: its parts are linked once.

mod edit;
mod file;
mod fill;
mod history_bake;
mod journal;
mod log;
mod sampled_cells;
mod temp_files;
mod views;
