//! Distances of sampled solids: heightmaps and grids.

use glam::DVec3 as V3;

/// Returns the vertical distance, reduced by the slope of the steepest triangle.
pub(super) fn heightmap(
    p: V3,
    grid: &argil_scene::SampledGrid,
    half: [f64; 2],
    [height, base]: [f64; 2],
) -> f64 {
    let w = grid.words();
    let n = [w[4] as usize, w[6] as usize];
    let post = |i: usize, k: usize| height * f64::from(w[8 + k * n[0] + i]);
    let step = [0, 1].map(|axis| 2.0 * half[axis] / (n[axis] - 1) as f64);
    let (mut along_x, mut along_z) = (0.0f64, 0.0f64);
    for k in 0..n[1] {
        for i in 0..n[0] {
            if i + 1 < n[0] {
                along_x = along_x.max((post(i + 1, k) - post(i, k)).abs() / step[0]);
            }
            if k + 1 < n[1] {
                along_z = along_z.max((post(i, k + 1) - post(i, k)).abs() / step[1]);
            }
        }
    }
    let cosine = 0.999_9 / (1.0 + along_x.powi(2) + along_z.powi(2)).sqrt();
    let at = [(p.x + half[0]) / step[0], (p.z + half[1]) / step[1]];
    let place = [0, 1].map(|axis| (at[axis].max(0.0) as usize).min(n[axis] - 2));
    let t = [0, 1].map(|axis| (at[axis] - place[axis] as f64).clamp(0.0, 1.0));
    let mut ground = 0.0;
    for corner in 0..4 {
        let bits = [corner & 1, corner >> 1];
        let share = |axis: usize| {
            if bits[axis] == 1 {
                t[axis]
            } else {
                1.0 - t[axis]
            }
        };
        ground += share(0) * share(1) * post(place[0] + bits[0], place[1] + bits[1]);
    }
    let posts = &w[8..];
    let top = height * posts.iter().map(|&h| f64::from(h)).fold(0.0, f64::max);
    let upright = (-p.y - base).max(p.y - top);
    let gaps = V3::new(p.x.abs() - half[0], upright, p.z.abs() - half[1]);
    let beside = gaps.max(V3::ZERO).length() + gaps.max_element().min(0.0);
    beside.max((p.y - ground) * cosine)
}

/// Interpolates between samples of the first level around the point. Beyond all levels, it returns the distance to the
/// solid's box, or the hypotenuse over the way to the last level if that is larger.
pub(super) fn sampled(p: V3, grid: &argil_scene::SampledGrid) -> f64 {
    let w = grid.words();
    let levels = w[7] as usize;
    let counts = [0, 1, 2].map(|kind| w[8 * levels + kind] as usize);
    let mut starts = [8 * levels + 16; 4];
    for kind in 1..4 {
        starts[kind] = starts[kind - 1] + counts[kind - 1] * ((1usize << kind) + 1).pow(3);
    }
    let mut table = starts[3];
    for (level, head) in w.chunks(8).take(levels).enumerate() {
        let n = [4, 5, 6].map(|i| head[i] as usize);
        let corner = V3::new(head[0].into(), head[1].into(), head[2].into());
        let whole = (p - corner) * f64::from(head[3]);
        let at = whole.clamp(V3::ZERO, V3::from_array(n.map(|n| n as f64)));
        if at != whole && level + 1 < levels {
            table += n[0] * n[1] * n[2] + (n[0] + 1) * (n[1] + 1) * (n[2] + 1);
            continue;
        }
        let least = |c: f64, most: usize| (c.max(0.0) as usize).min(most - 1);
        let place = [0, 1, 2].map(|axis| least(at[axis], n[axis]));
        let entry = w[table + (place[2] * n[1] + place[1]) * n[0] + place[0]] as usize;
        let side = 1 << (entry % 4);
        let inner = (at - V3::from_array(place.map(|c| c as f64))) * side as f64;
        let place_in = [0, 1, 2].map(|axis| least(inner[axis], side));
        let t = inner - V3::from_array(place_in.map(|c| c as f64));
        let mut d = 0.0;
        for corner in 0..8 {
            let bits = [corner & 1, corner >> 1 & 1, corner >> 2];
            let share: f64 = (0..3)
                .map(|k| if bits[k] == 1 { t[k] } else { 1.0 - t[k] })
                .product();
            let sample = if side == 1 {
                let [x, y, z] = [0, 1, 2].map(|k| place[k] + bits[k]);
                table + n[0] * n[1] * n[2] + (z * (n[1] + 1) + y) * (n[0] + 1) + x
            } else {
                let [x, y, z] = [0, 1, 2].map(|k| place_in[k] + bits[k]);
                let cell = entry / 4 * (side + 1).pow(3);
                starts[entry % 4 - 1] + cell + (z * (side + 1) + y) * (side + 1) + x
            };
            d += share * f64::from(w[sample]);
        }
        let gap = (whole - at).length() / f64::from(head[3]);
        let solid = [grid.solid().min.as_dvec3(), grid.solid().max.as_dvec3()];
        let of_box = p.distance(p.clamp(solid[0], solid[1]));
        return if gap > 0.0 {
            gap.hypot(d.max(0.0)).max(of_box)
        } else {
            d
        };
    }
    f64::INFINITY
}

/// Returns the distance to a triangle: to its plane if the foot lies within, else to its sides.
pub(super) fn triangle(p: V3, [a, b, c]: [V3; 3]) -> f64 {
    let n = (b - a).cross(c - a);
    let within = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|&(u, v)| (v - u).cross(n).dot(p - u) <= 0.0);
    if within {
        return (p - a).dot(n.normalize()).abs();
    }
    let side = |u: V3, v: V3| {
        p.distance(u + (v - u) * ((p - u).dot(v - u) / (v - u).length_squared()).clamp(0.0, 1.0))
    };
    side(a, b).min(side(b, c)).min(side(c, a))
}
