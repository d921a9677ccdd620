//! Errors.

/// The reason why a file cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VdbError {
    /// The first bytes are those of another format.
    #[error("not a {0} file: its first bytes are those of another format")]
    NotThis(&'static str),
    /// The file's version is not supported.
    #[error(
        "version {found} of the format is not supported, only {supported}: write it again with a newer program"
    )]
    Version {
        /// The file's version.
        found: String,
        /// Supported versions.
        supported: &'static str,
    },
    /// The file ends too early.
    #[error("the file ends at byte {at}, in the middle of {what}: it is truncated")]
    Truncated {
        /// Position.
        at: u64,
        /// What is missing.
        what: &'static str,
    },
    /// A value is impossible.
    #[error("at byte {at}: {what}: the file is damaged")]
    Damaged {
        /// Position.
        at: u64,
        /// What is wrong.
        what: String,
    },
    /// The file uses something that this crate does not read.
    #[error("{0}")]
    Unsupported(String),
    /// The checksum in the file is another than that of its content.
    #[error("the checksum is wrong: the file is damaged")]
    Checksum,
}
