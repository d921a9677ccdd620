// GPU version of curves.rs, for one point.
//
// *Length.* One function per curve, as in curves.rs.

fn box_distance(p: vec3<f32>, w: u32) -> f32 {
    let low = vec3(params[w], params[w + 1u], params[w + 2u]) - p;
    let high = p - vec3(params[w + 3u], params[w + 4u], params[w + 5u]);
    let gap = max(max(low, high), vec3(0.0));
    return sqrt(gap.x * gap.x + gap.y * gap.y + gap.z * gap.z) * 0.9999;
}

// Returns the squared distance to a quadratic curve at t, and the terms of a Newton step.
fn curve2(x: f32, y: f32, t: f32, w: u32) -> vec3<f32> {
    let e1x = params[w + 3u] - params[w + 1u];
    let e1y = params[w + 4u] - params[w + 2u];
    let e2x = params[w + 1u] - 2.0 * params[w + 3u] + params[w + 5u];
    let e2y = params[w + 2u] - 2.0 * params[w + 4u] + params[w + 6u];
    let qx = t * (t * e2x + 2.0 * e1x) + params[w + 1u] - x;
    let qy = t * (t * e2y + 2.0 * e1y) + params[w + 2u] - y;
    let vx = t * (2.0 * e2x) + 2.0 * e1x;
    let vy = t * (2.0 * e2y) + 2.0 * e1y;
    let speed = vx * vx + vy * vy;
    let slope = speed + (qx * (2.0 * e2x) + qy * (2.0 * e2y));
    return vec3(qx * qx + qy * qy, qx * vx + qy * vy, max(slope, speed * 0.05 + 1e-12));
}

// Evaluates one segment of an outline: `state.x` becomes the lower squared distance, and `state.y` flips at a
// crossing.
fn piece(x: f32, y: f32, w: u32, state: vec2<f32>) -> vec2<f32> {
    let ax = params[w + 1u];
    let ay = params[w + 2u];
    let bx = params[w + 3u];
    let by = params[w + 4u];
    let cx = params[w + 5u];
    let cy = params[w + 6u];
    if params[w] == 0.0 {
        let ex = cx - ax;
        let ey = cy - ay;
        let reciprocal = 1.0 / (ex * ex + ey * ey);
        var slant = 0.0;
        if ey != 0.0 {
            slant = ex / ey;
        }
        let px = x - ax;
        let py = y - ay;
        let t = clamp((px * ex + py * ey) * reciprocal, 0.0, 1.0);
        let dx = px - t * ex;
        let dy = py - t * ey;
        let crosses = ((ay <= y) != (cy <= y)) && (ax + py * slant > x);
        return vec2(min(state.x, dx * dx + dy * dy), select(state.y, -state.y, crosses));
    }
    let rising = select(-1.0, 1.0, cy > ay);
    let e1x = bx - ax;
    let e1y = by - ay;
    let e2x = ax - 2.0 * bx + cx;
    let e2y = ay - 2.0 * by + cy;
    let height = ay - y;
    let root = sqrt(max(e1y * e1y - e2y * height, 0.0));
    let descent = e1y + rising * root;
    // Both are 0 at the height of a start that is level.
    let s = clamp(select(-height / descent, 0.0, descent == 0.0), 0.0, 1.0);
    let crossing = ax + s * (2.0 * e1x + s * e2x);
    let crosses = ((ay <= y) != (cy <= y)) && (crossing > x);
    let sign = select(state.y, -state.y, crosses);
    let gap_x = max(max(min(ax, min(bx, cx)) - x, x - max(ax, max(bx, cx))), 0.0);
    let gap_y = max(max(min(ay, cy) - y, y - max(ay, cy)), 0.0);
    if (gap_x * gap_x + gap_y * gap_y) * 0.9999 >= state.x {
        return vec2(state.x, sign);
    }

    let step = 1.0 / f32(PIECE_SAMPLES);
    var start = 0.0;
    var least = 1e30;
    for (var i = 0u; i <= PIECE_SAMPLES; i++) {
        let sampled = f32(i) * step;
        let d = curve2(x, y, sampled, w).x;
        if d < least {
            least = d;
            start = sampled;
        }
    }
    var t = start;
    for (var i = 0u; i < NEWTON_STEPS; i++) {
        let c = curve2(x, y, t, w);
        t = clamp(t - c.y / c.z, max(start - step, 0.0), min(start + step, 1.0));
    }
    return vec2(min(state.x, min(curve2(x, y, t, w).x, least)), sign);
}

fn sd_outline(x: f32, y: f32, w: u32, count: u32) -> f32 {
    var state = vec2(1e30, 1.0);
    for (var i = 0u; i < count; i++) {
        state = piece(x, y, w + i * PIECE_WORDS, state);
    }
    return sqrt(state.x) * state.y;
}

fn curve3(p: vec3<f32>, t: f32, w: u32) -> vec3<f32> {
    return vec3(
        t * (t * params[w + 6u] + params[w + 3u]) + params[w] - p.x,
        t * (t * params[w + 7u] + params[w + 4u]) + params[w + 1u] - p.y,
        t * (t * params[w + 8u] + params[w + 5u]) + params[w + 2u] - p.z,
    );
}

fn sphere_box(p: vec3<f32>, t: f32, w: u32) -> f32 {
    let q = curve3(p, t, w);
    return length3(q.x, q.y, q.z) - (t * params[w + 10u] + params[w + 9u]);
}

fn sd_bezier_tube(p: vec3<f32>, w: u32) -> f32 {
    let step = 1.0 / f32(TUBE_SAMPLES);
    var best = 1e30;
    var at = 0.0;
    for (var i = 0u; i <= TUBE_SAMPLES; i++) {
        let t = f32(i) * step;
        let d = sphere_box(p, t, w);
        if d < best {
            best = d;
            at = t;
        }
    }
    let low = max(at - step, 0.0);
    let high = min(at + step, 1.0);
    var t = at;
    for (var i = 0u; i < NEWTON_STEPS; i++) {
        let q = curve3(p, t, w);
        let vx = t * (2.0 * params[w + 6u]) + params[w + 3u];
        let vy = t * (2.0 * params[w + 7u]) + params[w + 4u];
        let vz = t * (2.0 * params[w + 8u]) + params[w + 5u];
        let speed = vx * vx + vy * vy + vz * vz;
        let distance = length3(q.x, q.y, q.z);
        let pull = q.x * vx + q.y * vy + q.z * vz - distance * params[w + 10u];
        let slope = speed
            + (q.x * (2.0 * params[w + 6u]) + q.y * (2.0 * params[w + 7u]) + q.z * (2.0 * params[w + 8u]));
        t = clamp(t - pull / max(slope, speed * 0.05 + 1e-12), low, high);
    }
    return min(best, sphere_box(p, t, w));
}

fn sd_spline_tube(p: vec3<f32>, w: u32) -> f32 {
    var best = 1e30;
    for (var i = 0u; i < u32(params[w]); i++) {
        let own = w + 1u + i * TUBE_WORDS;
        if box_distance(p, own) <= max(best, 0.0) {
            best = min(best, sd_bezier_tube(p, own + 6u));
        }
    }
    return best;
}

fn sd_lathe(p: vec3<f32>, w: u32) -> f32 {
    return sd_outline(length2(p.x, p.z), p.y, w + 2u, u32(params[w]));
}

fn sd_extrusion(p: vec3<f32>, w: u32) -> f32 {
    return corner2(sd_outline(p.x, p.y, w + 2u, u32(params[w])), abs(p.z) - params[w + 1u]);
}
