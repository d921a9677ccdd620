// GPU version of sampler.rs. `way` is the path of this thread.

// Returns two numbers from 0 to 1, without 1.
fn random_pair() -> vec2<f32> {
    let seed = mixed(way.seed ^ mixed(way.pair));
    way.pair++;
    let index = scrambled(way.index, seed);
    let x = scrambled(reverseBits(index), mixed(seed ^ 0x68bc21ebu));
    let y = scrambled(second_dimension(index), mixed(seed ^ 0x02e5be93u));
    return vec2(unit(x), unit(y));
}

fn random_one() -> f32 {
    return random_pair().x;
}

fn unit(bits: u32) -> f32 {
    return f32(bits >> 8u) * (1.0 / 16777216.0);
}

// Multiplies by Pascal's triangle, which is the same triangle of half the size thrice, again and again.
fn second_dimension(index: u32) -> u32 {
    var x = reverseBits(index);
    x ^= x << 16u;
    x ^= (x & 0x00ff00ffu) << 8u;
    x ^= (x & 0x0f0f0f0fu) << 4u;
    x ^= (x & 0x33333333u) << 2u;
    x ^= (x & 0x55555555u) << 1u;
    return x;
}

fn scrambled(bits: u32, seed: u32) -> u32 {
    var x = reverseBits(bits) + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return reverseBits(x);
}

fn mixed(bits: u32) -> u32 {
    var x = bits;
    x ^= x >> 16u;
    x *= 0x7feb352du;
    x ^= x >> 15u;
    x *= 0x846ca68bu;
    return x ^ (x >> 16u);
}
