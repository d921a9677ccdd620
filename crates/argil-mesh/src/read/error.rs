//! The reason why bytes are not a mesh.

/// Maximum triangles of a mesh.
pub(super) const MAX_TRIANGLES: usize = 50_000_000;

/// The reason why bytes are not a mesh.
#[derive(Debug)]
pub(super) enum ReadFault {
    Damaged(String),
    Unsupported(String),
    /// What there is too much of, with the number and the maximum.
    TooLarge(String),
}

impl From<String> for ReadFault {
    fn from(reason: String) -> Self {
        Self::Damaged(reason)
    }
}

impl From<&str> for ReadFault {
    fn from(reason: &str) -> Self {
        Self::Damaged(reason.into())
    }
}

impl ReadFault {
    /// Adds the place to a reason.
    pub(super) fn within(self, place: &str) -> Self {
        match self {
            Self::Damaged(reason) => Self::Damaged(format!("{place}: {reason}")),
            other => other,
        }
    }
}
