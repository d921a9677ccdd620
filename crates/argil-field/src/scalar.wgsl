// GPU version of scalar.rs: scalar functions that shapes use.

// Returns sine and cosine by polynomials over a quarter turn.
fn sin_cos(x: f32) -> vec2<f32> {
    let turns = floor(x * 0.63661975 + 0.5);
    let r = ((x - turns * 1.5703125) - turns * 4.837513e-4) - turns * 7.54979e-8;
    let r2 = r * r;
    let s = r + r * r2 * (-1.6666655e-1 + r2 * (8.332161e-3 - r2 * 1.9515296e-4));
    let c = 1.0 - 0.5 * r2 + r2 * r2 * (4.1666646e-2 + r2 * (-1.3887316e-3 + r2 * 2.4433157e-5));
    let quarter = turns - 4.0 * floor(turns * 0.25);
    let odd = quarter == 1.0 || quarter == 3.0;
    let sine = select(s, c, odd);
    let cosine = select(c, s, odd);
    return vec2(select(sine, -sine, quarter >= 2.0), select(cosine, -cosine, quarter == 1.0 || quarter == 2.0));
}

// Returns a non-negative base to a positive exponent. A base below 1e-30 gives 0.
fn power(base: f32, exponent: f32) -> f32 {
    let bits = bitcast<u32>(base);
    let whole = bitcast<i32>(bits - 0x3f3504f3u) >> 23u;
    let mantissa = bitcast<f32>(bits - bitcast<u32>(whole << 23u));
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let t2 = t * t;
    let log2_series = 2.88539 + t2 * (0.9617967 + t2 * (0.577078 + t2 * (0.4121986 + t2 * 0.3205989)));
    let log = f32(whole) + t * log2_series;
    let x = min(max(log * exponent, -126.0), 126.0);
    let n = floor(x + 0.5);
    let f = x - n;
    let series = 1.0
        + f * (0.6931472
            + f * (0.24022651
                + f * (0.05550411 + f * (0.009618129 + f * (0.0013333558 + f * 0.0001540353)))));
    let scale = bitcast<f32>(bitcast<u32>((i32(n) + 127) << 23u));
    return select(series * scale, 0.0, base < 1e-30);
}

fn signed_as(value: f32, sign: f32) -> f32 {
    return select(value, -value, sign < 0.0);
}

// Returns true if a coordinate is finite and within the world. It tests the bits, because a shader may assume that
// no number is NaN.
fn is_in_world(c: f32) -> bool {
    return (bitcast<u32>(c) & 0x7fffffffu) <= bitcast<u32>(WORLD_LIMIT);
}
