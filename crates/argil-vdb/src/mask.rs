//! Bits of a node.

/// A bit for each of `64 · N` places of a node. The place of a child or voxel `(x, y, z)` is `(x · D + y) · D + z`,
/// where D is the node's side.
#[derive(Clone, PartialEq, Eq)]
pub struct Mask<const N: usize>(pub [u64; N]);

impl<const N: usize> std::fmt::Debug for Mask<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Mask({} of {} bits)", self.count(), 64 * N)
    }
}

impl<const N: usize> Default for Mask<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

impl<const N: usize> Mask<N> {
    /// Returns whether a bit is set.
    #[inline]
    pub fn is_on(&self, place: usize) -> bool {
        self.0[place / 64] >> (place % 64) & 1 != 0
    }

    /// Sets or clears a bit.
    #[inline]
    pub fn set(&mut self, place: usize, on: bool) {
        let bit = 1 << (place % 64);
        let word = &mut self.0[place / 64];
        *word = if on { *word | bit } else { *word & !bit };
    }

    /// Counts the bits that are set.
    pub fn count(&self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Returns whether no bit is set.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|&word| word == 0)
    }

    /// Returns the places of the bits that are set, ascending.
    pub fn places(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().enumerate().flat_map(|(i, &word)| {
            let mut left = word;
            std::iter::from_fn(move || {
                let bit = left.trailing_zeros() as usize;
                left &= left.wrapping_sub(1);
                (bit < 64).then_some(64 * i + bit)
            })
        })
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) {
        out.extend(self.0.iter().flat_map(|word| word.to_le_bytes()));
    }
}
