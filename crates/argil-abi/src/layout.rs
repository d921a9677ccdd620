//! The layout of shared structs.

/// The layout of a struct that Rust and WGSL share, for tests.
#[derive(Debug)]
pub struct StructLayout {
    /// Name of the struct in both languages.
    pub name: &'static str,
    /// Size in bytes.
    pub size: usize,
    /// Name and offset in bytes of each field.
    pub fields: &'static [(&'static str, usize)],
}
