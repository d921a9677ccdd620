//! All tests of this crate, as one program: its parts are linked once.

mod copies;
mod instances;
mod lists;
