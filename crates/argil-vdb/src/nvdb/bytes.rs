//! Appends numbers to bytes, little-endian.

/// Appends numbers.
#[derive(Default)]
pub(super) struct Bytes(pub(super) Vec<u8>);

impl Bytes {
    pub(super) fn u32(&mut self, n: u32) -> &mut Self {
        self.0.extend(n.to_le_bytes());
        self
    }

    pub(super) fn u64(&mut self, n: u64) -> &mut Self {
        self.0.extend(n.to_le_bytes());
        self
    }

    pub(super) fn float(&mut self, n: f32) -> &mut Self {
        self.0.extend(n.to_le_bytes());
        self
    }

    pub(super) fn floats(&mut self, all: &[f32]) -> &mut Self {
        self.0.extend(all.iter().flat_map(|n| n.to_le_bytes()));
        self
    }

    pub(super) fn doubles(&mut self, all: &[f64]) -> &mut Self {
        self.0.extend(all.iter().flat_map(|n| n.to_le_bytes()));
        self
    }

    pub(super) fn ints(&mut self, all: &[i32]) -> &mut Self {
        self.0.extend(all.iter().flat_map(|n| n.to_le_bytes()));
        self
    }
}
