//! Sources of records.

use crate::record::Record;
use std::path::PathBuf;

/// A record with the folder of its images.
pub(crate) struct StoredRecord {
    /// The record.
    pub record: Record,
    /// The folder of its images.
    pub pictures: PathBuf,
    /// Whether it had times that do not count.
    pub lost_times: bool,
}
