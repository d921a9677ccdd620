//! Random changes of files.

/// Numbers that readers stumble over, as text.
const WORDS: &[&str] = &[
    "0",
    "-1",
    "1",
    "2147483647",
    "4294967295",
    "-2147483648",
    "18446744073709551615",
    "1e39",
    "-1e-39",
    "nan",
    "inf",
    "0.5",
    "99999999",
    "\"",
    "\n",
    "{}",
    "[]",
    "null",
    "#",
    "\\",
];

/// Numbers that readers stumble over, as bytes.
const NUMBERS: &[u32] = &[
    0,
    1,
    2,
    0x7f,
    0x80,
    0xff,
    0x7fff,
    0xffff,
    0x10000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7f80_0000,
    0x7fc0_0000,
];

/// Maximum bytes of an input.
const MAX_BYTES: usize = 1 << 16;

/// Makes inputs from seeds, always the same ones for a name.
#[derive(Debug)]
pub struct Mutator {
    state: u64,
    seeds: Vec<Vec<u8>>,
}

impl Mutator {
    /// Begins a sequence of inputs.
    pub fn new(name: &str, seeds: Vec<Vec<u8>>) -> Self {
        // FNV-1a.
        let hash = |state: u64, byte: u8| (state ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        let state = name.bytes().fold(0xcbf2_9ce4_8422_2325, hash);
        Self { state, seeds }
    }

    /// Returns a random number (SplitMix64).
    fn random(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.random() % end.max(1) as u64) as usize
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// Returns the next input: a seed with one to six changes.
    pub fn next_input(&mut self) -> Vec<u8> {
        let index = self.below(self.seeds.len());
        let mut bytes = self.seeds.get(index).cloned().unwrap_or_default();
        for _ in 0..=self.below(6) {
            self.change(&mut bytes);
        }
        bytes.truncate(MAX_BYTES);
        bytes
    }

    fn change(&mut self, bytes: &mut Vec<u8>) {
        let at = self.below(bytes.len());
        let end = at + self.below(bytes.len() - at + 1).min(1 << self.below(12));
        match self.below(9) {
            0 => {
                let bit = self.below(8);
                bytes
                    .iter_mut()
                    .skip(at)
                    .take(1)
                    .for_each(|byte| *byte ^= 1 << bit);
            }
            1 => bytes.truncate(at),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let copy = bytes[at..end].to_vec();
                let to = self.below(bytes.len());
                bytes.splice(to..to, copy);
            }
            4 => {
                let number = self.one_of(NUMBERS).to_le_bytes();
                let room = bytes.iter_mut().skip(at);
                room.zip(number).for_each(|(byte, new)| *byte = new);
            }
            5 | 6 => self.change_number(bytes, at),
            7 => {
                let word = self.one_of(WORDS);
                bytes.splice(at..at, word.bytes());
            }
            _ => {
                let index = self.below(self.seeds.len());
                let other = self.seeds.get(index).cloned().unwrap_or_default();
                let from = self.below(other.len());
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..]);
            }
        }
    }

    /// Replaces the next number in text.
    fn change_number(&mut self, bytes: &mut Vec<u8>, at: usize) {
        let is_digit = |byte: &u8| byte.is_ascii_digit();
        let Some(start) = bytes[at..]
            .iter()
            .position(is_digit)
            .map(|first| at + first)
        else {
            return;
        };
        let length = bytes[start..]
            .iter()
            .take_while(|byte| is_digit(byte))
            .count();
        let word = self.one_of(WORDS);
        bytes.splice(start..start + length, word.bytes());
    }
}
