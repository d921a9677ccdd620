// GPU version of ramps.rs: curves and ramps, and what follows them.

fn curve(t: f32, w: u32) -> f32 {
    let pieces = params[w];
    let along = clamp(t, 0.0, 1.0) * pieces;
    let index = clamp(floor(along), 0.0, pieces - 1.0);
    let u = along - index;
    let own = w + 1u + 4u * u32(index);
    return u * (u * (u * params[own + 3u] + params[own + 2u]) + params[own + 1u]) + params[own];
}

fn ramp(p: vec3<f32>, w: u32) -> f32 {
    var place = p.x * params[w + 1u] + p.y * params[w + 2u] + p.z * params[w + 3u] + params[w + 4u];
    if params[w] != 0.0 {
        place = sqrt(p.x * p.x + p.z * p.z) * params[w + 1u] + params[w + 2u];
    }
    return curve(place, w + 5u);
}

fn shift(p: vec3<f32>, w: u32) -> vec3<f32> {
    return p - ramp(p, w + 3u) * vec3(params[w], params[w + 1u], params[w + 2u]);
}

fn flatten(p: vec3<f32>) -> vec3<f32> {
    return vec3(p.x, p.y, 0.0);
}

fn revolve(p: vec3<f32>, w: u32) -> vec3<f32> {
    return vec3(sqrt(p.x * p.x + p.z * p.z) - params[w], p.y, 0.0);
}

fn wrap(p: vec3<f32>, w: u32) -> vec3<f32> {
    let rough = rough_atan2(-p.z, p.x);
    let sc = sin_cos(rough);
    let across = -(p.z * sc.y) - p.x * sc.x;
    let along = p.x * sc.y - p.z * sc.x;
    let turn = select(0.0, across / along, along > 0.0);
    let place = curve((turn + rough) * 0.15915494 + 0.5, w + 9u);
    let r = max(sqrt(p.x * p.x + p.z * p.z), params[w + 3u]);
    return vec3(place * params[w + 1u] + params[w], p.y, r - params[w + 2u]);
}

fn unwrap(d: f32, p: vec3<f32>, w: u32) -> f32 {
    let core = params[w + 3u];
    let r = sqrt(p.x * p.x + p.z * p.z);
    let beyond = max(params[w + 5u] - p.y, p.y - params[w + 6u]);
    let around = corner2(r - params[w + 7u], beyond) * params[w + 8u];
    let gap = (core - r) * params[w + 4u];
    let near = select(gap, max(gap, d - gap), r >= WRAP_TRUSTED * core);
    return max(select(near, max(d, gap), r >= core), around);
}

fn extrude(d: f32, p: vec3<f32>, w: u32) -> f32 {
    let beyond = (abs(p.z) - params[w]) * params[w + 1u];
    let outside = max(d, 0.0);
    let above = max(beyond, 0.0);
    return select(max(d, beyond), sqrt(outside * outside + above * above), outside > 0.0 && above > 0.0);
}

// Evaluates a ramp behind a map.
fn ramp_value(p: vec3<f32>, w: u32) -> f32 {
    return ramp(mapped(p, w), w + 12u);
}
