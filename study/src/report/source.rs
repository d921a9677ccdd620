//! Where records come from.

use crate::record::Record;
use std::path::PathBuf;

/// Records of all places, with where their pictures are.
pub(crate) struct Source {
    /// What was found there.
    pub record: Record,
    /// The folder of its pictures.
    pub pictures: PathBuf,
}
