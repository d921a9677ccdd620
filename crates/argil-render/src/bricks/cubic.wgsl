// GPU version of first_root in voxel_intersect.rs: the cubic of the distance along a ray in its voxel.

struct Intersection {
    is_hit: bool,
    t: f32,
}

// The first root along the way through a voxel, from 0 to 1.
struct CubicRoot {
    is_crossed: bool,
    share: f32,
}

fn way_out(d: f32, f: f32) -> f32 {
    let way = not_zero(d);
    return select(-f, 1.0 - f, way > 0.0) / way;
}

fn cubic(c3: f32, c2: f32, c1: f32, c0: f32, s: f32) -> f32 {
    return ((c3 * s + c2) * s + c1) * s + c0;
}

// Four values at thirds of the way determine the cubic.
fn first_root(gap: f32, f1: f32, f2: f32, f3: f32) -> CubicRoot {
    let c0 = gap;
    let c1 = 0.5 * (18.0 * f1 - 11.0 * gap - 9.0 * f2 + 2.0 * f3);
    let c2 = 4.5 * (2.0 * gap - 5.0 * f1 + 4.0 * f2 - f3);
    let c3 = 4.5 * (3.0 * f1 - gap - 3.0 * f2 + f3);

    // The cubic has at most two extrema: the first interval that ends below 0 contains the first root.
    let a = 3.0 * c3;
    let root = sqrt(max(c2 * c2 - a * c1, 0.0));
    let q = -(c2 + select(root, -root, c2 < 0.0));
    let s1 = clamp(q / select(a, 1e-30, a == 0.0), 0.0, 1.0);
    let s2 = clamp(c1 / select(q, 1e-30, q == 0.0), 0.0, 1.0);
    let first = min(s1, s2);
    let second = max(s1, s2);
    let in_first = cubic(c3, c2, c1, c0, first) < 0.0;
    let in_second = cubic(c3, c2, c1, c0, second) < 0.0;
    let at_end = cubic(c3, c2, c1, c0, 1.0) < 0.0;
    var begin = second;
    var end = 1.0;
    if in_first {
        begin = 0.0;
        end = first;
    } else if in_second {
        begin = first;
        end = second;
    }
    var f_begin = cubic(c3, c2, c1, c0, begin);
    var f_end = cubic(c3, c2, c1, c0, end);
    // Regula falsi, Illinois variant: the value at the end that stays is halved.
    var share = end;
    for (var i = 0u; i < 4u; i++) {
        let span = f_begin - f_end;
        share = begin + (end - begin) * (f_begin / select(span, 1.0, span == 0.0));
        let f = cubic(c3, c2, c1, c0, share);
        if f < 0.0 {
            f_begin *= 0.5;
            end = share;
            f_end = f;
        } else {
            f_end *= 0.5;
            begin = share;
            f_begin = f;
        }
    }
    return CubicRoot(in_first || in_second || at_end, share);
}
