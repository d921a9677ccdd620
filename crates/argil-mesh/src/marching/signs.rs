//! The signs of samples, as bits.

use argil_math::bits_of;
use argil_volume::{SampleFormat, Texel};

/// Writes the signs of samples as a stream of bits.
pub(super) fn signs<T: Texel>(samples: &[T], out: &mut [u64]) {
    out.fill(0);
    match T::FORMAT {
        SampleFormat::Snorm8 => put_signs::<i8>(bytemuck::cast_slice(samples), out),
        SampleFormat::Snorm16 => put_signs::<i16>(bytemuck::cast_slice(samples), out),
    }
}

pub(super) fn put_signs<I: Copy + Default + PartialOrd>(samples: &[I], out: &mut [u64]) {
    for (part, bits) in samples.chunks(64).zip(out) {
        let mut flags = [0; 64];
        for (flag, &sample) in flags.iter_mut().zip(part) {
            *flag = u8::from(sample < I::default());
        }
        *bits = bits_of(&flags);
    }
}
