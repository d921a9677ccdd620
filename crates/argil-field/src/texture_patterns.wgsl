// GPU version of texture_patterns.rs.

fn texture_word(at: u32) -> f32 {
    let entry = materials[at >> 3u];
    if (at & 4u) == 0u {
        return entry.base_roughness[at & 3u];
    }
    return entry.emission_metallic[at & 3u];
}

fn texture_color(at: u32) -> vec3<f32> {
    return vec3(texture_word(at), texture_word(at + 1u), texture_word(at + 2u));
}

fn texture_layers(p: vec3<f32>, octaves: u32) -> f32 {
    var sum = 0.0;
    var all = 0.0;
    var amplitude = 1.0;
    var frequency = 1.0;
    for (var octave = 0u; octave < octaves; octave++) {
        sum += amplitude * value_noise(p * frequency, octave);
        all += amplitude;
        amplitude *= 0.5;
        frequency *= 2.0;
    }
    return sum / all;
}

fn texture_solid(kind: u32, parameter: f32, p: vec3<f32>) -> f32 {
    switch kind {
        case 0u: {
            let cell = vec3<i32>(clamp(floor(2.0 * p + 1e-4), vec3(-1e9), vec3(1e9)));
            return f32((cell.x ^ cell.y ^ cell.z) & 1);
        }
        case 1u: { return clamp(0.5 + 2.0 * sin(6.2831855 * (p.z - trunc(p.z))), 0.0, 1.0); }
        case 2u: { return 0.5 + 0.5 * texture_layers(p, u32(parameter)); }
        case 3u: {
            let bent = sqrt(p.x * p.x + p.z * p.z) + 0.12 * texture_layers(p * vec3(1.5, 0.3, 1.5), 2u);
            let share = bent - floor(bent);
            let ring = share * share * (1.0 - smoothstep(0.85, 1.0, share));
            let grain = 0.5 + 0.5 * value_noise(vec3(24.0, 1.5, 24.0) * p, 7u);
            return clamp(0.8 * ring + 0.25 * grain, 0.0, 1.0);
        }
        default: {
            let bent = p.x + 1.2 * texture_layers(p, 5u);
            return sqrt(abs(sin(3.1415927 * (bent - 2.0 * floor(0.5 * bent)))));
        }
    }
}

fn texture_brick(uv: vec2<f32>) -> f32 {
    let row = floor(2.0 * uv.y);
    let odd = row - 2.0 * floor(0.5 * row);
    let u = uv.x + 0.5 * odd;
    let inner = vec2(u - floor(u), 0.5 * (2.0 * uv.y - row));
    let side = min(inner, vec2(1.0, 0.5) - inner);
    return smoothstep(0.02, 0.035, min(side.x, side.y));
}

fn texture_wrapped(x: f32, length: f32) -> f32 {
    return clamp(x - length * floor(x / length), 0.0, length - 1e-3 * min(length, 1.0));
}

fn texture_texel(own: u32, column: f32, row: f32, size: vec2<f32>) -> vec3<f32> {
    let at = u32(texture_wrapped(row, size.y)) * u32(size.x) + u32(texture_wrapped(column, size.x));
    let word = u32(texture_word(8u * u32(texture_word(own + 7u)) + at));
    let roots = vec3(f32(word & 255u), f32(word >> 8u & 255u), f32(word >> 16u & 255u)) / 255.0;
    return roots * roots;
}

fn texture_image(own: u32, uv: vec2<f32>) -> vec3<f32> {
    let size = vec2(texture_word(own + 11u), texture_word(own + 12u));
    let x = (uv.x + 0.5 - floor(uv.x + 0.5)) * size.x - 0.5;
    let y = texture_wrapped(uv.y * size.x + 0.5 * size.y, size.y) - 0.5;
    let column = floor(x);
    let row = floor(y);
    let above = mix(texture_texel(own, column, row, size), texture_texel(own, column + 1.0, row, size), x - column);
    let below = mix(texture_texel(own, column, row + 1.0, size), texture_texel(own, column + 1.0, row + 1.0, size), x - column);
    return mix(above, below, y - row);
}
