//! Packs the codes of a brick's samples.
//!
//! *Theory.* Distances near a surface are smooth. The Lorenzo predictor (Ibarria et al., "Out-of-core compression and
//! decompression of large n-dimensional scalar fields", 2003) expects a sample from seven neighbors: it is exact for
//! polynomials without a term in x · y · z. What is left is small, and takes as many bits as the largest of a row needs.

use multiversion::multiversion;

/// Samples along a brick's side.
const SIDE: usize = 9;
const LAYER: usize = SIDE * SIDE;
/// Samples of a brick.
pub(crate) const BRICK_SAMPLES: usize = SIDE * LAYER;

/// Bytes that are still to be read.
pub(super) struct Reader<'a>(pub &'a [u8]);

impl<'a> Reader<'a> {
    pub(super) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (own, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(own)
    }

    pub(super) fn word(&mut self) -> Option<u32> {
        let own = self.take(4)?;
        Some(u32::from_le_bytes(own.try_into().ok()?))
    }
}

/// Bits that tell how many bits the codes of a row take.
const WIDTH_BITS: u32 = 5;

/// What samples are predicted from.
struct Predictor {
    below: [i16; LAYER],
    row_before: [i16; SIDE],
    before_below: [i16; SIDE],
    /// The change of the first sample in the row before, and in the first row of the layer below.
    first: i16,
    first_below: i16,
}

impl Predictor {
    fn new() -> Self {
        Self {
            below: [0; LAYER],
            row_before: [0; SIDE],
            before_below: [0; SIDE],
            first: 0,
            first_below: 0,
        }
    }

    /// Begins a row. Returns the change that is expected of its first sample.
    fn begin_row(&mut self, row: usize) -> i16 {
        match row {
            0 => {
                (self.row_before, self.before_below) = ([0; SIDE], [0; SIDE]);
                self.first_below
            }
            1 => 0,
            _ => self.first,
        }
    }

    /// Returns what a sample is expected to be, but for its change along x.
    fn base(&self, row: usize, i: usize) -> i16 {
        let up_before = self.row_before[i].wrapping_sub(self.before_below[i]);
        self.below[SIDE * row + i].wrapping_add(up_before)
    }

    /// Ends a row, with the change of its first sample.
    fn end_row(&mut self, row: usize, samples: &[i16], first: i16) {
        let under = &mut self.below[SIDE * row..SIDE * (row + 1)];
        self.before_below.copy_from_slice(under);
        under.copy_from_slice(samples);
        self.row_before.copy_from_slice(samples);
        self.first = first;
        if row == 0 {
            self.first_below = first;
        }
    }
}

/// The most bytes that a brick takes: all rows take all bits.
pub(super) const MAX_BRICK_BYTES: usize = (LAYER * (WIDTH_BITS as usize + 16 * SIDE)).div_ceil(8);

/// Appends the samples of bricks.
#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+bmi2+lzcnt",
    "x86_64+avx2+bmi2+lzcnt"
))]
pub(super) fn pack(bricks: &[[i16; BRICK_SAMPLES]], out: &mut Vec<u8>) {
    let (mut changes, mut rest) = ([0; BRICK_SAMPLES], [0; BRICK_SAMPLES]);
    let mut bits = BitWriter::new();
    for codes in bricks {
        changes_of(codes, &mut changes);
        surprises_of(&changes, &mut rest);
        for row in rest.as_chunks::<SIDE>().0 {
            // Four codes at once take at most 64 bits.
            let [first, a @ .., _, _, _, _] = *row;
            let [_, _, _, _, _, b @ ..] = *row;
            let (a, b) = (word_of(a), word_of(b));
            let mut all = a | b;
            all |= all >> 32;
            let all = (all | all >> 16) as u16 | first;
            let width = 16 - all.leading_zeros();
            bits.put(
                u64::from(width) | u64::from(first) << WIDTH_BITS,
                WIDTH_BITS + width,
            );
            bits.put(squeezed(a, width), 4 * width);
            bits.put(squeezed(b, width), 4 * width);
        }
        out.extend_from_slice(bits.finish());
    }
}

/// Returns four codes in one word, the first one in the lowest bits.
#[inline(always)]
fn word_of(codes: [u16; 4]) -> u64 {
    let [a, b, c, d] = codes.map(u64::from);
    a | b << 16 | c << 32 | d << 48
}

/// Removes the bits between a word's codes of some width.
#[inline(always)]
fn squeezed(word: u64, width: u32) -> u64 {
    const LOW: u64 = 0xffff_0000_ffff;
    let pairs = (word & LOW) | (word >> 16 & LOW) << width;
    (pairs & 0xffff_ffff) | (pairs >> 32) << (2 * width)
}

/// Subtracts from samples those a layer and a row before.
#[inline(always)]
fn changes_of(codes: &[i16; BRICK_SAMPLES], changes: &mut [i16; BRICK_SAMPLES]) {
    let mut layers = *codes;
    for (own, below) in layers[LAYER..].iter_mut().zip(codes) {
        *own = own.wrapping_sub(*below);
    }
    *changes = layers;
    let rows = layers.as_chunks::<LAYER>().0;
    for (own, before) in changes.as_chunks_mut::<LAYER>().0.iter_mut().zip(rows) {
        for (own, before) in own[SIDE..].iter_mut().zip(before) {
            *own = own.wrapping_sub(*before);
        }
    }
}

/// Subtracts from changes what the predictor expects. Signs are in the lowest bit.
#[inline(always)]
fn surprises_of(changes: &[i16; BRICK_SAMPLES], rest: &mut [u16; BRICK_SAMPLES]) {
    let unsigned = |off: i16| ((off << 1) ^ (off >> 15)) as u16;
    rest[0] = unsigned(changes[0]);
    for (own, pair) in rest[1..].iter_mut().zip(changes.windows(2)) {
        *own = unsigned(pair[1].wrapping_sub(pair[0]));
    }
    let mut first_below = 0;
    for (own, changes) in rest
        .as_chunks_mut::<LAYER>()
        .0
        .iter_mut()
        .zip(changes.as_chunks::<LAYER>().0)
    {
        let mut left = first_below;
        first_below = changes[0];
        for at in (0..LAYER).step_by(SIDE) {
            own[at] = unsigned(changes[at].wrapping_sub(left));
            // The second row has none before it that begins as it does.
            left = if at == 0 { 0 } else { changes[at] };
        }
    }
}

/// Writes the bits of a brick.
struct BitWriter {
    bytes: [u8; MAX_BRICK_BYTES + 8],
    /// Whole bytes that were written.
    at: usize,
    held: u64,
    /// Bits that are held, fewer than 64.
    count: u32,
}

impl BitWriter {
    fn new() -> Self {
        Self {
            bytes: [0; MAX_BRICK_BYTES + 8],
            at: 0,
            held: 0,
            count: 0,
        }
    }

    /// Appends at most 64 bits.
    #[inline(always)]
    fn put(&mut self, codes: u64, bits: u32) {
        let low = self.held | codes << (self.count & 63);
        // Two shifts, because one by 64 is none.
        let high = codes >> 1 >> (63 - (self.count & 63));
        if let Some(word) = self.bytes[self.at..].first_chunk_mut() {
            *word = low.to_le_bytes();
        }
        let sum = self.count + bits;
        let is_full = sum >= 64;
        self.at += if is_full { 8 } else { 0 };
        self.held = if is_full { high } else { low };
        self.count = sum & 63;
    }

    /// Returns all bytes, and starts over.
    #[inline(always)]
    fn finish(&mut self) -> &[u8] {
        // The last word is there, but for bits behind a full one.
        if let Some(word) = self.bytes[self.at..].first_chunk_mut() {
            *word = self.held.to_le_bytes();
        }
        let end = self.at + self.count.div_ceil(8) as usize;
        (self.at, self.held, self.count) = (0, 0, 0);
        &self.bytes[..end]
    }
}

/// Reads the samples of a brick behind others. Returns `None` if there are too few bytes.
pub(super) fn unpack(from: &mut Reader<'_>, codes: &mut Vec<i16>) -> Option<()> {
    let mut predictor = Predictor::new();
    let (mut held, mut count) = (0u64, 0);
    let mut get = |bits: u32| {
        while count < bits {
            held |= u64::from(from.take(1)?[0]) << count;
            count += 8;
        }
        let code = held & ((1 << bits) - 1);
        held >>= bits;
        count -= bits;
        Some(code as u16)
    };
    for index in 0..LAYER {
        let index = index % SIDE;
        let bits = u32::from(get(WIDTH_BITS)?);
        if bits > 16 {
            return None;
        }
        let mut left = predictor.begin_row(index);
        let (mut row, mut first) = ([0i16; SIDE], 0);
        for (i, sample) in row.iter_mut().enumerate() {
            let code = get(bits)?;
            let off = (code >> 1) as i16 ^ -((code & 1) as i16);
            let change = off.wrapping_add(left);
            left = change;
            if i == 0 {
                first = change;
            }
            *sample = predictor.base(index, i).wrapping_add(change);
        }
        predictor.end_row(index, &row, first);
        codes.extend_from_slice(&row);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bricks_of(codes: &[i16]) -> &[[i16; BRICK_SAMPLES]] {
        codes.as_chunks().0
    }

    /// Any codes come back, smooth ones in few bytes.
    #[test]
    fn bricks_come_back() {
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as u32
        };
        let place = |i: usize| [i % SIDE, i / SIDE % SIDE, i / LAYER].map(|c| c as f32);
        let smooth = |i: usize| {
            let [x, y, z] = place(i);
            (1800.0 * ((x - 2.5).hypot(y - 14.0).hypot(z - 3.0) - 9.0)) as i16
        };
        let cases: [Vec<i16>; 5] = [
            vec![0; BRICK_SAMPLES],
            vec![i16::MIN; BRICK_SAMPLES],
            (0..BRICK_SAMPLES).map(|_| random() as i16).collect(),
            (0..BRICK_SAMPLES)
                .map(|_| [i16::MIN, i16::MAX][random() as usize % 2])
                .collect(),
            (0..BRICK_SAMPLES).map(smooth).collect(),
        ];
        for (index, codes) in cases.iter().enumerate() {
            let mut bytes = Vec::new();
            pack(bricks_of(codes), &mut bytes);
            let mut back = Vec::new();
            let mut reader = Reader(&bytes);
            assert_eq!(unpack(&mut reader, &mut back), Some(()), "{index}");
            assert!(reader.0.is_empty() && back == *codes, "{index}");
            let mut short = Reader(&bytes[..bytes.len() - 1]);
            assert_eq!(unpack(&mut short, &mut Vec::new()), None, "{index}");
        }
        let mut bytes = Vec::new();
        pack(bricks_of(&cases[4]), &mut bytes);
        assert!(bytes.len() < 2 * BRICK_SAMPLES / 2, "{}", bytes.len());
    }
}
