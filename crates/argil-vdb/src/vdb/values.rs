//! Arrays of values without those that masks give.
//!
//! A byte says what inactive values are (`io/Compression.h`): the background, its negative, another value, or two of
//! these, with a mask that selects. Then only the active values follow.

use super::bytes::Reader;
use super::{FLAG_ACTIVE_MASK, FLAG_BLOSC, FLAG_ZIP};
use crate::codec::{pack, unblosc, unzip};
use crate::{Codec, Mask, VdbError, Voxel};

/// What inactive values are.
const ALL_BACKGROUND: u8 = 0;
const ALL_NEGATIVE: u8 = 1;
const ONE_OTHER: u8 = 2;
const BOTH_SIGNS: u8 = 3;
const BACKGROUND_AND_OTHER: u8 = 4;
const TWO_OTHERS: u8 = 5;
const ALL_STORED: u8 = 6;

/// How values are written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packing<V> {
    pub background: V,
    pub codec: Codec,
    pub is_half: bool,
}

impl<V: Voxel> Packing<V> {
    /// Appends the values of a node. `active` has a bit for each value, and values of `children` do not count.
    pub(super) fn write<const N: usize>(
        &self,
        values: &[V],
        active: &Mask<N>,
        children: &Mask<N>,
        out: &mut Vec<u8>,
    ) {
        let mut others: [Option<V>; 2] = [None; 2];
        let mut is_any = true;
        'all: for (i, word) in active.0.iter().enumerate() {
            let mut left = !(word | children.0[i]);
            while left != 0 {
                let value = values[64 * i + left.trailing_zeros() as usize];
                left &= left - 1;
                let slot = others
                    .iter()
                    .position(|other| other.is_none_or(|other| other == value));
                let Some(slot) = slot else {
                    is_any = false;
                    break 'all;
                };
                others[slot] = Some(value);
            }
        }
        let negative = self.background.negated();
        let (kind, first, second) = match others {
            _ if !is_any => (ALL_STORED, None, None),
            [None, _] => (ALL_BACKGROUND, None, None),
            [Some(value), None] if value == self.background => (ALL_BACKGROUND, None, None),
            [Some(value), None] if value == negative => (ALL_NEGATIVE, None, None),
            [Some(value), None] => (ONE_OTHER, Some(value), None),
            [Some(a), Some(b)] => {
                let (a, b) = if a == self.background { (b, a) } else { (a, b) };
                match (a == negative, b == self.background) {
                    (true, true) => (BOTH_SIGNS, None, Some(b)),
                    (false, true) => (BACKGROUND_AND_OTHER, Some(a), Some(b)),
                    _ => (TWO_OTHERS, Some(a), Some(b)),
                }
            }
        };
        out.push(kind);
        let rounded = |value: V| if self.is_half { value.rounded() } else { value };
        if let Some(value) = first {
            rounded(value).write(out);
        }
        if kind == TWO_OTHERS
            && let Some(value) = second
        {
            rounded(value).write(out);
        }
        if let Some(second) = second {
            let mut select = Mask::<N>::default();
            let words = select.0.iter_mut().zip(&active.0);
            for ((word, active), values) in words.zip(values.as_chunks::<64>().0) {
                for (bit, &value) in values.iter().enumerate() {
                    *word |= u64::from(value == second) << bit;
                }
                *word &= !active;
            }
            select.write(out);
        }
        self.write_values(values, (kind != ALL_STORED).then_some(active), out);
    }

    fn write_values<const N: usize>(
        &self,
        values: &[V],
        only: Option<&Mask<N>>,
        out: &mut Vec<u8>,
    ) {
        let mut bytes = Vec::new();
        let packed = if self.codec == Codec::None {
            &mut *out
        } else {
            &mut bytes
        };
        let mut put = |values: &[V]| match self.is_half {
            true => V::write_all_half(values, packed),
            false => V::write_all(values, packed),
        };
        match only {
            Some(active) => {
                let mut chosen = [V::default(); 64];
                for (word, values) in active.0.iter().zip(values.as_chunks::<64>().0) {
                    // Each value is copied, and counted only if it is active.
                    let mut count = 0;
                    for (bit, &value) in values.iter().enumerate() {
                        chosen[count] = value;
                        count += (word >> bit & 1) as usize;
                        count &= 63;
                    }
                    match *word {
                        0 => {}
                        u64::MAX => put(values),
                        _ => put(&chosen[..count]),
                    }
                }
            }
            None => put(values),
        }
        // Without values, 16-bit ones have no length either.
        if self.codec != Codec::None && !(self.is_half && bytes.is_empty()) {
            let size = if self.is_half { 2 } else { V::BYTES };
            pack(self.codec, &bytes, size, out);
        }
    }
}

/// How values are read.
#[derive(Clone, Copy)]
pub(super) struct Unpacking<V> {
    pub background: V,
    pub flags: u32,
    pub is_half: bool,
}

impl<V: Voxel> Unpacking<V> {
    /// Reads the values of a node.
    pub(super) fn read<const N: usize>(
        &self,
        from: &mut Reader<'_>,
        active: &Mask<N>,
        values: &mut [V],
    ) -> Result<(), VdbError> {
        let what = "values";
        let kind = from.u8(what)?;
        if kind > ALL_STORED {
            return Err(from.damaged(format!("{kind} is no kind of inactive values")));
        }
        let mut second = self.background;
        let mut first = match kind {
            ALL_BACKGROUND => self.background,
            _ => self.background.negated(),
        };
        if [ONE_OTHER, BACKGROUND_AND_OTHER, TWO_OTHERS].contains(&kind) {
            first = V::read(from.take(V::BYTES, what)?);
        }
        if kind == TWO_OTHERS {
            second = V::read(from.take(V::BYTES, what)?);
        }
        let select = match kind {
            BOTH_SIGNS | BACKGROUND_AND_OTHER | TWO_OTHERS => from.mask::<N>(what)?,
            _ => Mask::default(),
        };
        let is_masked = self.flags & FLAG_ACTIVE_MASK != 0 && kind != ALL_STORED;
        let count = if is_masked {
            active.count()
        } else {
            values.len()
        };
        let size = if self.is_half {
            2 * V::COMPONENTS
        } else {
            V::BYTES
        };
        let unpacked = self.unpack(from, count * size)?;
        let bytes = unpacked.as_ref();
        let read = |at: usize| match self.is_half {
            true => V::read_half(&bytes[at * size..]),
            false => V::read(&bytes[at * size..]),
        };
        if !is_masked {
            for (i, value) in values.iter_mut().enumerate() {
                *value = read(i);
            }
            return Ok(());
        }
        let mut next = 0;
        for (i, chunk) in values.as_chunks_mut::<64>().0.iter_mut().enumerate() {
            let (on, selected) = (active.0[i], select.0[i]);
            if on == u64::MAX {
                for value in chunk.iter_mut() {
                    *value = read(next);
                    next += 1;
                }
                continue;
            }
            for (bit, value) in chunk.iter_mut().enumerate() {
                if on >> bit & 1 != 0 {
                    *value = read(next);
                    next += 1;
                } else {
                    *value = if selected >> bit & 1 != 0 {
                        second
                    } else {
                        first
                    };
                }
            }
        }
        Ok(())
    }

    fn unpack<'a>(
        &self,
        from: &mut Reader<'a>,
        length: usize,
    ) -> Result<std::borrow::Cow<'a, [u8]>, VdbError> {
        let what = "values";
        if self.flags & (FLAG_ZIP | FLAG_BLOSC) == 0 || (self.is_half && length == 0) {
            return Ok(from.take(length, what)?.into());
        }
        let packed = from.i64("the length of packed values")?;
        let count = usize::try_from(packed.unsigned_abs()).unwrap_or(usize::MAX);
        let bytes = from.take(count, what)?;
        if packed <= 0 {
            if count != length {
                return Err(from.damaged(format!("{count} bytes of values where {length} belong")));
            }
            return Ok(bytes.into());
        }
        let unpacked = if self.flags & FLAG_BLOSC != 0 {
            unblosc(bytes, length).map_err(|reason| from.damaged(reason))?
        } else {
            unzip(bytes, length).ok_or_else(|| from.damaged("zipped values are damaged"))?
        };
        Ok(unpacked.into())
    }
}
