//! All tests of this crate, as one program: its parts are linked once.

mod instances;
mod lists;
