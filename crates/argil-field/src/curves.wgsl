// GPU version of curves.rs, for one point.
//
// *Length.* One function per curve, as in curves.rs.

fn box_distance(p: vec3<f32>, w: u32) -> f32 {
    let low = vec3(params[w], params[w + 1u], params[w + 2u]) - p;
    let high = p - vec3(params[w + 3u], params[w + 4u], params[w + 5u]);
    let gap = max(max(low, high), vec3(0.0));
    return sqrt(gap.x * gap.x + gap.y * gap.y + gap.z * gap.z) * 0.9999;
}

// Returns the squared distance to a quadratic curve at a parameter from 0 to 1.
fn squared2(x: f32, y: f32, t: f32, w: u32) -> f32 {
    let e1x = params[w + 3u] - params[w + 1u];
    let e1y = params[w + 4u] - params[w + 2u];
    let e2x = params[w + 1u] - 2.0 * params[w + 3u] + params[w + 5u];
    let e2y = params[w + 2u] - 2.0 * params[w + 4u] + params[w + 6u];
    let qx = t * (t * e2x + 2.0 * e1x) + params[w + 1u] - x;
    let qy = t * (t * e2y + 2.0 * e1y) + params[w + 2u] - y;
    return qx * qx + qy * qy;
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

    let ee = e1x * e1x + e1y * e1y;
    let ff = e2x * e2x + e2y * e2y;
    let ox = ax - x;
    let oy = ay - y;
    let cubic = vec4(
        ox * e1x + oy * e1y,
        2.0 * ee + (ox * e2x + oy * e2y),
        3.0 * (e1x * e2x + e1y * e2y),
        ff,
    );
    let t = clamp(minima(cubic, ff <= 4.0 * STRAIGHT_CURVE * ee), vec2(0.0), vec2(1.0));
    return vec2(min(state.x, min(squared2(x, y, t.x, w), squared2(x, y, t.y, w))), sign);
}

fn sd_outline(x: f32, y: f32, w: u32, count: u32) -> f32 {
    var state = vec2(1e30, 1.0);
    for (var i = 0u; i < count; i++) {
        state = piece(x, y, w + i * PIECE_WORDS, state);
    }
    return sqrt(state.x) * state.y;
}

fn params3(w: u32) -> vec3<f32> {
    return vec3(params[w], params[w + 1u], params[w + 2u]);
}

fn sphere_distance(o: vec3<f32>, t: f32, w: u32) -> f32 {
    let q = o + t * (t * params3(w + 6u) + params3(w + 3u));
    return length3(q.x, q.y, q.z) - (t * params[w + 10u] + params[w + 9u]);
}

fn sd_bezier_tube(p: vec3<f32>, w: u32) -> f32 {
    let o = params3(w) - p;
    let b = params3(w + 3u);
    let c = params3(w + 6u);
    let bb = dot3(b, b);
    let cc = dot3(c, c);
    let radius_change = params[w + 10u];
    let is_straight = cc <= STRAIGHT_CURVE * bb;
    var least = 1e30;
    let steps = select(TAPER_STEPS, 1u, radius_change == 0.0);
    for (var step = 0u; step < steps; step++) {
        let taper = select(radius_change, 0.0, step == 0u);
        let reach = least + params[w + 9u];
        let cubic = vec4(
            dot3(o, b) - taper * reach,
            bb + 2.0 * dot3(o, c) - taper * taper,
            3.0 * dot3(b, c),
            2.0 * cc,
        );
        // Spheres smaller than a negative bound's length cannot be nearer.
        let edge = clamp(-reach / radius_change, 0.0, 1.0);
        let low = select(0.0, edge, taper > 0.0);
        let high = select(1.0, edge, taper < 0.0);
        let t = clamp(minima(cubic, is_straight), vec2(low), vec2(high));
        let before = least;
        least = min(least, min(sphere_distance(o, t.x, w), sphere_distance(o, t.y, w)));
        // What is left to gain after a step with the taper is no more than its own gain.
        if step > 0u && before - least <= SMALL_GAIN * abs(reach) {
            break;
        }
    }
    return least;
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
