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

fn sd_sampled(p: vec3<f32>, w: u32) -> f32 {
    let count = vec3(params[w + 4u], params[w + 5u], params[w + 6u]);
    let whole = (p - vec3(params[w], params[w + 1u], params[w + 2u])) * params[w + 3u];
    let inside = min(max(whole, vec3(0.0)), count);
    let beyond = whole - inside;
    let gap = beyond.x * beyond.x + beyond.y * beyond.y + beyond.z * beyond.z;
    let least = min(floor(inside), count - vec3(1.0));
    let place = vec3<u32>(least);
    let n = vec3<u32>(count);
    let table = w + SAMPLED_HEADER;
    let coarse = table + n.x * n.y * n.z;
    let own = params[table + (place.z * n.y + place.y) * n.x + place.x];
    var t = inside - least;
    var row = n.x + 1u;
    var layer = (n.x + 1u) * (n.y + 1u);
    var first = coarse + place.z * layer + place.y * row + place.x;
    if own != 0.0 {
        let fine = t * f32(SAMPLED_SIDE);
        let inner = min(floor(fine), vec3(f32(SAMPLED_SIDE) - 1.0));
        let at = vec3<u32>(inner);
        t = fine - inner;
        row = SAMPLED_SIDE + 1u;
        first = coarse + layer * (n.z + 1u) + (u32(own) - 1u) * row * row * row
            + (at.z * row + at.y) * row + at.x;
        layer = row * row;
    }
    let d = interpolated(t, first, row, layer);
    if gap > 0.0 {
        let h = max(d, 0.0);
        let cell = 1.0 / params[w + 3u];
        return sqrt(gap * (cell * cell) + h * h);
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
