// GPU version of noise.rs.

fn hash(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    var h = (bitcast<u32>(x) * 0x8da6b343u)
        ^ (bitcast<u32>(y) * 0xd8163841u)
        ^ (bitcast<u32>(z) * 0xcb1ab31fu)
        ^ (seed * 0x9e3779b9u);
    h = (h ^ (h >> 16u)) * 0x7feb352du;
    h = (h ^ (h >> 15u)) * 0x846ca68bu;
    return h ^ (h >> 16u);
}

fn lattice(x: i32, y: i32, z: i32, seed: u32) -> f32 {
    return f32(hash(x, y, z, seed) >> 8u) * (2.0 / 16777215.0) - 1.0;
}

fn noise_along_x(c: vec3<i32>, u: f32, seed: u32) -> f32 {
    let a = lattice(c.x, c.y, c.z, seed);
    let b = lattice(c.x + 1, c.y, c.z, seed);
    return u * (b - a) + a;
}

fn noise_along_y(c: vec3<i32>, u: f32, v: f32, seed: u32) -> f32 {
    let a = noise_along_x(c, u, seed);
    let b = noise_along_x(c + vec3(0, 1, 0), u, seed);
    return a + (b - a) * v;
}

fn value_noise(p: vec3<f32>, seed: u32) -> f32 {
    let cell = clamp(floor(p), vec3(-1e9), vec3(1e9));
    let t = clamp(p - cell, vec3(0.0), vec3(1.0));
    let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let c = vec3<i32>(cell);
    let a = noise_along_y(c, fade.x, fade.y, seed);
    let b = noise_along_y(c + vec3(0, 0, 1), fade.x, fade.y, seed);
    return a + (b - a) * fade.z;
}

// GPU version of displace_here.
fn displace(d: f32, p: vec3<f32>, seed: u32, w: u32) -> f32 {
    var noisy = d;
    if abs(d) < params[w + 5u] {
        var amplitude = params[w];
        var frequency = params[w + 1u];
        for (var octave = 0u; octave < u32(params[w + 2u]); octave++) {
            noisy += value_noise(p * frequency, seed + octave) * amplitude;
            amplitude *= 0.5;
            frequency *= 2.0;
        }
    }
    let smooth_d = d * params[w + 3u];
    return min(max(noisy, smooth_d - params[w + 4u]), smooth_d + params[w + 4u]);
}
