// GPU version of domain_ops.rs and copy_loops.rs: transforms of the point, and loops over copies.

// Words of repetitions, in front of the box of what is repeated.
const REPEAT_WORDS: u32 = 16u;
const RADIAL_WORDS: u32 = 4u;

fn translated(p: vec3<f32>, w: u32) -> vec3<f32> {
    return vec3(p.x + params[w + 3u], p.y + params[w + 7u], p.z + params[w + 11u]);
}

fn mapped(p: vec3<f32>, w: u32) -> vec3<f32> {
    return vec3(
        p.x * params[w] + p.y * params[w + 1u] + p.z * params[w + 2u] + params[w + 3u],
        p.x * params[w + 4u] + p.y * params[w + 5u] + p.z * params[w + 6u] + params[w + 7u],
        p.x * params[w + 8u] + p.y * params[w + 9u] + p.z * params[w + 10u] + params[w + 11u],
    );
}

fn mirrored(p: vec3<f32>, w: u32) -> vec3<f32> {
    return select(p, abs(p), vec3(params[w], params[w + 1u], params[w + 2u]) > vec3(0.0));
}

fn elongated(p: vec3<f32>, w: u32) -> vec3<f32> {
    let by = vec3(params[w], params[w + 1u], params[w + 2u]);
    return p - clamp(p, -by, by);
}

fn nearby(own: f32, beyond: f32, j: f32, candidates: f32) -> f32 {
    let side = select(j, -j, beyond < 0.0);
    // Nearest first.
    let away = floor(0.5 * j + 0.5);
    return own + select(side, select(-away, away, 2.0 * away > j), candidates > 2.0);
}

fn repeat_axis(p: f32, j: f32, w: u32) -> f32 {
    let spacing = params[w];
    let low = params[w + 6u];
    let high = params[w + 9u];
    let shifted = p + params[w + 3u];
    let own = clamp(floor(shifted / spacing + 0.5), low, high);
    let candidates = params[w + 12u];
    let near = clamp(nearby(own, shifted - own * spacing, j, candidates), low, high);
    // Evaluate all candidates, one after the other.
    let cell = select(near, low + j, candidates > high - low);
    return shifted - cell * spacing;
}

fn repeated(p: vec3<f32>, j: u32, w: u32) -> vec3<f32> {
    // Integers as floats, which hardware divides sooner. The half keeps a quotient clear of the next integer.
    let nx = max(params[w + 12u], 1.0);
    let ny = max(params[w + 13u], 1.0);
    let row = floor((f32(j) + 0.5) / nx);
    let layer = floor((row + 0.5) / ny);
    return vec3(
        repeat_axis(p.x, f32(j) - row * nx, w),
        repeat_axis(p.y, row - layer * ny, w + 1u),
        repeat_axis(p.z, layer, w + 2u),
    );
}

fn rough_atan2(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    let ay = abs(y);
    let a = min(ax, ay) / max(max(ax, ay), 1e-30);
    let s = a * a;
    var r = ((-0.046496475 * s + 0.15931422) * s - 0.32762276) * s * a + a;
    r = select(r, 1.5707964 - r, ay > ax);
    r = select(r, 3.1415927 - r, x < 0.0);
    return select(r, -r, y < 0.0);
}

fn radial(p: vec3<f32>, j: u32, w: u32) -> vec3<f32> {
    let step = params[w + 1u];
    let angle = rough_atan2(p.z, p.x);
    let own = floor(angle / step + 0.5);
    let turn = sin_cos(own * step);
    let near = nearby(own, p.z * turn.y - p.x * turn.x, f32(j), params[w + 2u]);
    let sector = select(near, f32(j), params[w + 2u] == params[w]);
    let sc = sin_cos(sector * step);
    return vec3(p.x * sc.y + p.z * sc.x, p.y, p.z * sc.y - p.x * sc.x);
}

// Returns the point in copy `j` of a loop that begins at `begin`.
fn candidate(begin: Instruction, p: vec3<f32>, j: u32) -> vec3<f32> {
    if begin.op == OP_REPEAT {
        return repeated(p, j, begin.params);
    }
    return radial(p, j, begin.params);
}

// Whether a point in a copy's place shows that the copy is farther than the nearest one so far.
fn is_too_far(begin: Instruction, p: vec3<f32>, least: f32) -> bool {
    let w = begin.params + select(RADIAL_WORDS, REPEAT_WORDS, begin.op == OP_REPEAT);
    let low = vec3(params[w], params[w + 1u], params[w + 2u]);
    let high = vec3(params[w + 3u], params[w + 4u], params[w + 5u]);
    let beyond = p - clamp(p, low, high);
    // Within the box, nothing is known.
    let needed = max(least + params[w + 7u], 0.0);
    return (beyond.x * beyond.x + beyond.y * beyond.y + beyond.z * beyond.z) * params[w + 6u] > needed * needed;
}

fn candidates(begin: Instruction) -> u32 {
    let w = begin.params;
    if begin.op == OP_REPEAT {
        return u32(params[w + 12u] * params[w + 13u] * params[w + 14u]);
    }
    return u32(params[w + 2u]);
}

fn held(p: vec3<f32>, w: u32) -> vec3<f32> {
    let q = clamp(p, vec3(params[w], params[w + 1u], params[w + 2u]), vec3(params[w + 3u], params[w + 4u], params[w + 5u]));
    let far = q.x * q.x + q.z * q.z;
    let most = params[w + 8u] * params[w + 8u];
    let by = select(1.0, sqrt(most / far), far > most);
    return vec3(q.x * by, q.y, q.z * by);
}

fn twist(p: vec3<f32>, w: u32) -> vec3<f32> {
    let q = held(p, w);
    let sc = sin_cos(q.y * params[w + 6u]);
    return vec3(sc.y * q.x + sc.x * q.z, q.y, sc.y * q.z - sc.x * q.x);
}

fn bend(p: vec3<f32>, w: u32) -> vec3<f32> {
    let q = held(p, w);
    let sc = sin_cos(q.x * params[w + 6u]);
    return vec3(sc.y * q.x - sc.x * q.y, sc.x * q.x + sc.y * q.y, q.z);
}

fn unclamp(d: f32, p: vec3<f32>, w: u32) -> f32 {
    let gap = p - held(p, w);
    let scale = params[w + 7u];
    let outside = (gap.x * gap.x + gap.y * gap.y + gap.z * gap.z) * (scale * scale);
    let h = max(d, 0.0);
    return select(d, sqrt(outside + h * h), outside > 0.0);
}
