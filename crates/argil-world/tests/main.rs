//! All tests of this crate, as one program: its parts are linked once.

mod common;
mod export;
mod faults;
mod reading;
mod tile_folder;
