//! Well distributed random numbers: Sobol' points whose digits are permuted by hashes (Burley, "Practical hash-based Owen
//! scrambling", 2020).

/// Numbers for one path. Each pair is a point of the unit square, and all paths of a pixel have well distributed ones.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    index: u32,
    seed: u32,
    pair: u32,
}

impl Sampler {
    pub(crate) fn new(pixel: u32, index: u32) -> Self {
        Self {
            index,
            seed: hash(pixel ^ 0x9e37_79b9),
            pair: 0,
        }
    }

    /// Returns two numbers from 0 to 1, without 1.
    pub(crate) fn pair(&mut self) -> [f32; 2] {
        let seed = hash(self.seed ^ hash(self.pair));
        self.pair += 1;
        let index = scrambled(self.index, seed);
        let x = scrambled(index.reverse_bits(), hash(seed ^ 0x68bc_21eb));
        let y = scrambled(second_dimension(index), hash(seed ^ 0x02e5_be93));
        [x, y].map(unit)
    }

    /// Returns a number from 0 to 1, without 1.
    pub(crate) fn one(&mut self) -> f32 {
        self.pair()[0]
    }
}

/// Returns a number below 1 by its first 24 bits.
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

/// Returns the second coordinate of a Sobol' point, whose direction numbers are the rows of Pascal's triangle. That contains the
/// triangle of half its size thrice.
fn second_dimension(index: u32) -> u32 {
    let mut x = index.reverse_bits();
    x ^= x << 16;
    for (mask, shift) in [
        (0x00ff_00ff, 8),
        (0x0f0f_0f0f, 4),
        (0x3333_3333, 2),
        (0x5555_5555, 1),
    ] {
        x ^= (x & mask) << shift;
    }
    x
}

/// Permutes digits, each by those above it.
fn scrambled(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits().wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6u32] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

/// Mixes all bits (Wellons, "Prospecting for hash functions", 2018).
pub(crate) fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 256 points: one in each of 16 × 16 squares, for all pairs.
    #[test]
    fn points_are_spread() {
        for pixel in [0, 1, 77] {
            for pair in 0..20 {
                let mut hits = [0; 256];
                for index in 0..256 {
                    let mut sampler = Sampler::new(pixel, index);
                    let mut point = [0.0; 2];
                    for _ in 0..=pair {
                        point = sampler.pair();
                    }
                    let [x, y] = point.map(|c| (16.0 * c) as usize);
                    hits[16 * y + x] += 1;
                }
                assert_eq!(hits, [1; 256], "{pixel} {pair}");
            }
        }
    }
}
