//! All tests of this crate, as one program: its parts are linked once.

mod background;
mod copies;
mod cut_away;
mod instances;
mod lists;
mod sampled;
