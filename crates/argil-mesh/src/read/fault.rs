//! Why bytes are no mesh.

/// Most triangles of a mesh.
pub(super) const MAX_TRIANGLES: usize = 50_000_000;

/// Why bytes are no mesh.
#[derive(Debug)]
pub(super) enum ReadFault {
    Damaged(String),
    Unsupported(String),
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
