//! Bit masks.

/// Returns a mask whose bit `i` is `flags[i]`, each of which is 0 or 1.
///
/// One multiplication gathers eight bytes: it moves each byte's bit to its own place in the highest byte. Loops
/// that compute the flags vectorize.
///
/// # Examples
///
/// ```
/// let mut flags = [0; 64];
/// flags[3] = 1;
/// flags[63] = 1;
/// assert_eq!(argil_math::bits_of(&flags), 1 << 3 | 1 << 63);
/// ```
#[inline(always)]
pub fn bits_of(flags: &[u8; 64]) -> u64 {
    let words = flags.as_chunks::<8>().0.iter().zip(0..);
    words.fold(0, |bits, (word, k)| {
        let gathered = u64::from_le_bytes(*word).wrapping_mul(0x0102_0408_1020_4080) >> 56;
        bits | gathered << (8 * k)
    })
}

/// Iterates over the indices of ones among zeros, eight at a time. It is fast where ones are rare. A rest of less than
/// eight flags is left out.
///
/// # Examples
///
/// ```
/// let mut flags = [0; 64];
/// flags[3] = 1;
/// flags[63] = 1;
/// assert_eq!(argil_math::set_indices(&flags).collect::<Vec<_>>(), [3, 63]);
/// ```
#[inline(always)]
pub fn set_indices(flags: &[u8]) -> impl Iterator<Item = usize> + '_ {
    let words = flags.as_chunks::<8>().0.iter().enumerate();
    words.flat_map(|(word, bytes)| {
        let mut bits = u64::from_le_bytes(*bytes);
        std::iter::from_fn(move || {
            let bit = (bits != 0).then(|| bits.trailing_zeros() as usize)?;
            bits &= bits - 1;
            Some(8 * word + bit / 8)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_flag_has_its_bit() {
        let mut state = 1u64;
        for _ in 0..1000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let bits = state ^ state >> 29;
            let flags = std::array::from_fn(|i| (bits >> i & 1) as u8);
            assert_eq!(bits_of(&flags), bits);
        }
    }
}
