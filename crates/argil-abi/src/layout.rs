//! Where the fields of a shared struct lie.

/// A struct shared with WGSL, for the test of layouts.
#[derive(Debug)]
pub struct StructLayout {
    /// The struct's name in both languages.
    pub name: &'static str,
    /// Its size in bytes.
    pub size: usize,
    /// Each field's name and offset in bytes.
    pub fields: &'static [(&'static str, usize)],
}
