// Converts a frame to bytes, and counts what its rays did. GPU version of `show` in picture.rs and `RayCounts` in
// ray_stats.rs. One pixel per thread.

// The sRGB transfer function (IEC 61966-2-1).
fn srgb_from_linear(c: vec3<f32>) -> vec3<f32> {
    return select(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, c * 12.92, c <= vec3(0.0031308));
}

// Returns the share of the gap to the next byte from which on that is taken.
fn threshold(x: u32, y: u32) -> f32 {
    return fract(52.982918 * fract(0.06711056 * f32(x) + 0.00583715 * f32(y)));
}

// Three bytes of sRGB, and whether at least half of the samples hit a solid.
@compute @workgroup_size(8, 8)
fn resolve(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let at = id.y * frame.width + id.x;
    let color = colors[at];
    let shown = select(color.xyz, srgb_from_linear(max(color.xyz, vec3(0.0))), frame.mode == MODE_SHADED);
    // Light is dithered.
    let exact = clamp(shown, vec3(0.0), vec3(1.0)) * 255.0;
    let whole = floor(exact + 1e-3);
    let limit = select(0.5, threshold(id.x, id.y), frame.mode == MODE_SHADED);
    let bytes = min(vec3<u32>(whole) + select(vec3(0u), vec3(1u), exact - whole > vec3(limit)), vec3(255u));
    let is_hit = select(0u, 1u, color.w >= 0.499);
    pixels[at] = bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (is_hit << 24u);
}

// Adds a ray to a histogram.
fn add_to_histogram(histogram: u32, times: u32) {
    let bins = arrayLength(&counts) / 5u;
    atomicAdd(&counts[histogram * bins + min(times, bins - 1u)], 1u);
}

// Rays with a count of 0 are not recorded: they are the remainder. Most rays only sample distances.
@compute @workgroup_size(8, 8)
fn count(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let did = hits[counts_at(id.y * frame.width + id.x)];
    let steps = did.x;
    if steps == 0u {
        return;
    }
    let other = did.y + did.z;
    if other == 0u {
        add_to_histogram(0u, steps);
        return;
    }
    add_to_histogram(1u, steps);
    add_to_histogram(2u, steps - min(other, steps));
    add_to_histogram(3u, did.y);
    add_to_histogram(4u, did.z);
}
