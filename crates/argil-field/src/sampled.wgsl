// GPU version of sampled.rs, for one point.

fn interpolated(t: vec3<f32>, v: u32, row: u32, layer: u32) -> f32 {
    let a0 = t.x * (params[v + 1u] - params[v]) + params[v];
    let b0 = t.x * (params[v + row + 1u] - params[v + row]) + params[v + row];
    let low = t.y * (b0 - a0) + a0;
    let u = v + layer;
    let a1 = t.x * (params[u + 1u] - params[u]) + params[u];
    let b1 = t.x * (params[u + row + 1u] - params[u + row]) + params[u + row];
    let high = t.y * (b1 - a1) + a1;
    return t.z * (high - low) + low;
}

// Moves a position in cells back to the samples that only rounding moved it away from.
fn at_samples(at: vec3<f32>, near: vec3<f32>) -> vec3<f32> {
    let sample = round(at * 8.0);
    return select(at, sample * 0.125, abs(at * 8.0 - sample) <= 8.0 * near);
}

fn sd_sampled(p: vec3<f32>, w: u32) -> f32 {
    let summary = w + SAMPLED_HEADER * u32(params[w + SAMPLED_HEADER - 1u]);
    let first = summary + SAMPLED_SUMMARY;
    let second = first + 27u * u32(params[summary]);
    let third = second + 125u * u32(params[summary + 1u]);
    var table = third + 729u * u32(params[summary + 2u]);
    var head = w;
    var at = vec3(0.0);
    var beyond = vec3(0.0);
    // The finest level that contains the point, or the last one.
    loop {
        let corner = vec3(params[head], params[head + 1u], params[head + 2u]);
        let scale = params[head + 3u];
        let count = vec3(params[head + 4u], params[head + 5u], params[head + 6u]);
        let whole = (p - corner) * scale;
        at = min(max(whole, vec3(0.0)), count);
        // How far rounding can move a place.
        let near = 9.536743e-7 * (abs(corner) * scale + count);
        beyond = select(whole - at, vec3(0.0), abs(whole - at) <= near);
        if head == w {
            at = at_samples(at, near);
        }
        if all(beyond == vec3(0.0)) || head + SAMPLED_HEADER >= summary {
            break;
        }
        let n = vec3<u32>(count);
        table += n.x * n.y * n.z + (n.x + 1u) * (n.y + 1u) * (n.z + 1u);
        head += SAMPLED_HEADER;
    }
    let count = vec3(params[head + 4u], params[head + 5u], params[head + 6u]);
    let n = vec3<u32>(count);
    let least = min(floor(at), count - vec3(1.0));
    let place = vec3<u32>(least);
    let own = u32(params[table + (place.z * n.y + place.y) * n.x + place.x]);
    let kind = own & 3u;
    var t = at - least;
    var row = n.x + 1u;
    var layer = row * (n.y + 1u);
    var samples = table + n.x * n.y * n.z + place.z * layer + place.y * row + place.x;
    if kind != 0u {
        let side = f32(1u << kind);
        let fine = t * side;
        let below = min(floor(fine), vec3(side - 1.0));
        let inner = vec3<u32>(below);
        t = fine - below;
        row = (1u << kind) + 1u;
        layer = row * row;
        samples = select(select(third, second, kind == 2u), first, kind == 1u) + (own >> 2u) * layer * row
            + inner.z * layer + inner.y * row + inner.x;
    }
    let d = interpolated(t, samples, row, layer);
    let gap = beyond.x * beyond.x + beyond.y * beyond.y + beyond.z * beyond.z;
    if gap > 0.0 {
        let h = max(d, 0.0);
        let cell = 1.0 / params[head + 3u];
        let low = vec3(params[summary + 4u], params[summary + 5u], params[summary + 6u]);
        let high = vec3(params[summary + 7u], params[summary + 8u], params[summary + 9u]);
        let b = p - min(max(p, low), high);
        return max(sqrt(gap * (cell * cell) + h * h), sqrt(b.x * b.x + b.y * b.y + b.z * b.z));
    }
    return d;
}

fn sd_heightmap(p: vec3<f32>, w: u32) -> f32 {
    let half = vec2(params[w], params[w + 1u]);
    let n = vec2(params[w + 9u], params[w + 11u]);
    let at = min(max((p.xz + half) * ((n - vec2(1.0)) / (2.0 * half)), vec2(0.0)), n - vec2(1.0));
    let least = min(floor(at), n - vec2(2.0));
    let t = at - least;
    let row = u32(n.x);
    let first = w + 5u + SAMPLED_HEADER + u32(least.y) * row + u32(least.x);
    let a = t.x * (params[first + 1u] - params[first]) + params[first];
    let b = t.x * (params[first + row + 1u] - params[first + row]) + params[first + row];
    let ground = (t.y * (b - a) + a) * params[w + 2u];
    let top = (p.y - ground) * params[w + 4u];
    let upright = max(-p.y - params[w + 3u], p.y - params[w + 2u] * params[w + 8u]);
    let gaps = vec3(abs(p.x) - half.x, upright, abs(p.z) - half.y);
    let beyond = max(gaps, vec3(0.0));
    let squared = beyond.x * beyond.x + beyond.y * beyond.y + beyond.z * beyond.z;
    if squared > 0.0 {
        return max(top, sqrt(squared));
    }
    return max(top, max(max(gaps.x, gaps.y), gaps.z));
}
