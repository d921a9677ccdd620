//! The interpreter on the CPU: one instruction at a time over [`LANES`] points. `interpret.wgsl` is the twin, one point
//! at a time.

use crate::combine::{
    Joint, combine_chamfer, combine_morph, combine_smooth, matters, union_smooth, weight_paint,
    weight_smooth,
};
use crate::curves::BLOCK;
use crate::real::{F32Lanes, LANES, Real};
use crate::space::{
    RADIAL_WORDS, REPEAT_WORDS, TWIST_WORDS, bend, map_point, radial, repeat_axis, twist, unclamp,
};
use crate::{FAR, Program, WORLD_LIMIT, curves, noise, shapes};
use argil_abi as abi;

/// Base colour, roughness, emission, metallic of each lane.
pub(crate) type MaterialLanes = [F32Lanes; 8];

/// What the interpreter works on. Allocated once, used for many batches.
pub(crate) struct Registers<R: Real> {
    /// The points, changed along the way.
    pub point: [R::Lanes; 3],
    /// Lanes in use, rounded up to whole blocks: what brushes are measured for.
    pub active: usize,
    /// The accumulated distances, and after the run the answer.
    pub acc: R::Lanes,
    /// The accumulated materials.
    pub material: Box<MaterialLanes>,
    values: Vec<R::Lanes>,
    points: Vec<[R::Lanes; 3]>,
    materials: Vec<MaterialLanes>,
    /// Candidates done of each open loop.
    loops: Vec<u32>,
    exiled: F32Lanes,
}

impl<R: Real> Registers<R> {
    pub fn new() -> Self {
        let zero = || R::splat(0.0);
        Self {
            point: [zero(), zero(), zero()],
            active: LANES,
            acc: zero(),
            material: Box::new(std::array::from_fn(|_| f32::splat(0.0))),
            values: Vec::new(),
            points: Vec::new(),
            materials: Vec::new(),
            loops: Vec::new(),
            exiled: f32::splat(0.0),
        }
    }
}

/// The first `N` words at an instruction's parameters. A program's tables agree, so the default is never used.
#[inline(always)]
fn words<const N: usize>(params: &[f32], at: usize) -> &[f32; N] {
    params
        .get(at..at + N)
        .and_then(|w| w.try_into().ok())
        .unwrap_or(&[0.0; N])
}

const HEADER: usize = abi::BRUSH_HEADER_WORDS as usize;

/// A brush's map from the point and its joint.
struct Brush<'a> {
    m: &'a [f32; 12],
    scale: f32,
    joint: Joint,
}

impl<'a> Brush<'a> {
    #[inline(always)]
    fn read(params: &'a [f32], at: usize) -> Self {
        let h: &[f32; HEADER] = words(params, at);
        Self {
            m: words(h, 0),
            scale: h[12],
            joint: Joint {
                k: h[13],
                quarter: h[14],
                sa: h[15],
                sb: h[16],
                sr: h[17],
                amount: 0.0,
            },
        }
    }
}

#[inline(always)]
fn translated<R: Real>(p: [R; 3], m: &[f32; 12]) -> [R; 3] {
    [p[0] + m[3], p[1] + m[7], p[2] + m[11]]
}

#[inline(always)]
fn mapped<R: Real>([x, y, z]: [R; 3], m: &[f32; 12]) -> [R; 3] {
    [
        x * m[0] + y * m[1] + z * m[2] + m[3],
        x * m[4] + y * m[5] + z * m[6] + m[7],
        x * m[8] + y * m[9] + z * m[10] + m[11],
    ]
}

/// The hot loop: place the points, measure, combine. The common case, a translated union, is spared the multiplications
/// by a scale and signs of 1.
#[inline(always)]
fn brush<R: Real, const N: usize>(
    point: &[R::Lanes; 3],
    acc: &mut R::Lanes,
    b: &Brush<'_>,
    active: usize,
    is_translation: bool,
    w: &[f32; N],
    shape: impl Fn([R; 3], &[f32; N]) -> R,
) {
    let [xs, ys, zs] = point;
    // Copies: the optimiser then need not prove that the words lie apart from the lanes.
    let (m, w) = (*b.m, *w);
    let active = active.min(LANES);
    let is_union = b.joint.sa > 0.0 && b.joint.sb > 0.0;
    match (is_translation, is_union) {
        (true, true) => {
            for i in 0..active {
                let d = shape(
                    translated([R::get(xs, i), R::get(ys, i), R::get(zs, i)], &m),
                    &w,
                );
                R::set(acc, i, union_smooth(R::get(acc, i), d, &b.joint));
            }
        }
        (true, false) => {
            for i in 0..active {
                let d = shape(
                    translated([R::get(xs, i), R::get(ys, i), R::get(zs, i)], &m),
                    &w,
                );
                R::set(acc, i, combine_smooth(R::get(acc, i), d, &b.joint));
            }
        }
        (false, _) => {
            for i in 0..active {
                let d = shape(
                    mapped([R::get(xs, i), R::get(ys, i), R::get(zs, i)], &m),
                    &w,
                ) * b.scale;
                R::set(acc, i, combine_smooth(R::get(acc, i), d, &b.joint));
            }
        }
    }
}

/// A brush whose shape searches along curves, block by block, where it can matter: not where the distance to the
/// shape's box already leaves the accumulator as it is.
#[inline(always)]
fn curve_brush<R: Real>(
    r: &mut Registers<R>,
    program: &Program,
    op: u32,
    b: &Brush<'_>,
    at: usize,
) {
    let j = &b.joint;
    let m = *b.m;
    let bounds: [f32; 6] = *words(&program.params, at);
    let [xs, ys, zs] = &r.point;
    for first in (0..r.active.min(LANES)).step_by(BLOCK) {
        let zero = [R::constant(0.0); BLOCK];
        let [mut x, mut y, mut z, mut a] = [zero; 4];
        let mut concerned = 0u32;
        for i in 0..BLOCK {
            let lane = first + i;
            [x[i], y[i], z[i]] = mapped([R::get(xs, lane), R::get(ys, lane), R::get(zs, lane)], &m);
            a[i] = R::get(&r.acc, lane);
            let least =
                curves::box_distance(x[i].value(), y[i].value(), z[i].value(), &bounds) * b.scale;
            concerned |= u32::from(matters(a[i].value(), least, j));
        }
        if concerned == 0 {
            continue;
        }
        let d = curve_shape::<R>(program, op, at + 6, [&mut x, &mut y, &mut z]);
        for i in 0..BLOCK {
            R::set(
                &mut r.acc,
                first + i,
                combine_smooth(a[i], d[i] * b.scale, j),
            );
        }
    }
}

/// The distances of a block of points in the shape's frame.
#[inline(always)]
fn curve_shape<R: Real>(
    program: &Program,
    op: u32,
    at: usize,
    [x, y, z]: [&mut curves::Block<R>; 3],
) -> curves::Block<R> {
    if op == abi::OP_BEZIER_TUBE {
        return curves::sd_bezier_tube::<R>([x, y, z], words(&program.params, at));
    }
    let &[count, half_depth]: &[f32; 2] = words(&program.params, at);
    let end = at + 2 + count as usize * abi::PIECE_WORDS as usize;
    let pieces = program.params.get(at + 2..end).unwrap_or_default();
    if op == abi::OP_LATHE {
        for i in 0..BLOCK {
            x[i] = shapes::length2(x[i], z[i]);
        }
        return curves::sd_outline::<R>(x, y, pieces);
    }
    let mut d = curves::sd_outline::<R>(x, y, pieces);
    for i in 0..BLOCK {
        d[i] = shapes::corner2(d[i], z[i].abs() - half_depth);
    }
    d
}

/// `a` ← mix(a, b, weights).
#[inline(always)]
fn mix_materials(a: &mut MaterialLanes, b: impl Fn(usize, usize) -> f32, weights: &F32Lanes) {
    for (k, lanes) in a.iter_mut().enumerate() {
        for i in 0..LANES {
            lanes.0[i] += (b(k, i) - lanes.0[i]) * weights.0[i];
        }
    }
}

#[inline(always)]
fn weights<R: Real>(a: &R::Lanes, b: &R::Lanes, j: &Joint, flags: u32) -> F32Lanes {
    let mut out = f32::splat(0.0);
    if flags & abi::FLAG_KEEP_MATERIAL != 0 {
        return out;
    }
    for i in 0..LANES {
        let (a, b) = (R::get(a, i).value(), R::get(b, i).value());
        out.0[i] = match flags & abi::COMBINE_MASK {
            abi::COMBINE_PAINT => weight_paint(b, j),
            abi::COMBINE_MORPH => j.amount,
            _ => weight_smooth(a, b, j),
        };
    }
    out
}

/// Run a program on the points in the registers. `MATERIALS`: whether to carry materials along.
#[inline(always)]
pub(crate) fn run<R: Real, const MATERIALS: bool>(program: &Program, r: &mut Registers<R>) {
    r.acc = R::splat(FAR);
    r.exiled = exile::<R>(&mut r.point);
    let params = &program.params[..];
    let mut pc = 0;
    while let Some(&abi::Instr {
        op,
        flags,
        params: at,
        operand,
    }) = program.instrs.get(pc)
    {
        pc += 1;
        let at = at as usize;
        if op < abi::OP_SHAPES_END {
            // With materials the brush is measured alone first, then combined with its weight.
            let mut b = Brush::read(params, at);
            let joint = b.joint;
            if MATERIALS {
                b.joint = Joint {
                    k: 0.0,
                    quarter: 0.0,
                    sa: 1.0,
                    sb: 1.0,
                    sr: 1.0,
                    amount: 0.0,
                };
                r.values.push(std::mem::replace(&mut r.acc, R::splat(FAR)));
            }
            measure(program, r, op, flags, &b, at + HEADER);
            if MATERIALS && let Some(a) = r.values.pop() {
                let w = weights::<R>(&a, &r.acc, &joint, flags);
                let m = &program.materials[operand as usize];
                let of = |k: usize| {
                    if k < 4 {
                        m.base_roughness[k]
                    } else {
                        m.emission_metallic[k - 4]
                    }
                };
                mix_materials(&mut r.material, |k, _| of(k), &w);
                for i in 0..LANES {
                    let d = combine_smooth(R::get(&a, i), R::get(&r.acc, i), &joint);
                    R::set(&mut r.acc, i, d);
                }
            }
            continue;
        }
        match op {
            abi::OP_PUSH_VALUE => {
                r.values.push(std::mem::replace(&mut r.acc, R::splat(FAR)));
                if MATERIALS {
                    r.materials.push((*r.material).clone());
                }
            }
            abi::OP_COMBINE => {
                let w: &[f32; 6] = words(params, at);
                let j = Joint {
                    k: w[0],
                    quarter: w[1],
                    sa: w[2],
                    sb: w[3],
                    sr: w[4],
                    amount: w[5],
                };
                let Some(mut saved) = r.values.pop() else {
                    continue;
                };
                // From here `saved` is a and the accumulator b.
                if flags & abi::FLAG_SWAPPED != 0 {
                    std::mem::swap(&mut saved, &mut r.acc);
                }
                if MATERIALS && let Some(mut other) = r.materials.pop() {
                    if flags & abi::FLAG_SWAPPED != 0 {
                        std::mem::swap(&mut other, &mut r.material);
                    }
                    let w = weights::<R>(&saved, &r.acc, &j, flags);
                    mix_materials(&mut other, |k, i| r.material[k].0[i], &w);
                    *r.material = other;
                }
                for i in 0..LANES {
                    let (a, b) = (R::get(&saved, i), R::get(&r.acc, i));
                    let d = match flags & abi::COMBINE_MASK {
                        abi::COMBINE_CHAMFER => combine_chamfer(a, b, &j),
                        abi::COMBINE_PAINT => a,
                        abi::COMBINE_MORPH => combine_morph(a, b, &j),
                        _ => combine_smooth(a, b, &j),
                    };
                    R::set(&mut r.acc, i, d);
                }
            }
            abi::OP_PUSH_POINT => r.points.push(r.point.clone()),
            abi::OP_POP_POINT => {
                if let Some(point) = r.points.pop() {
                    r.point = point;
                }
            }
            abi::OP_AFFINE => {
                let m = words(params, at);
                map_point::<R>(&mut r.point, |p| mapped(p, m));
            }
            abi::OP_MIRROR => {
                let w: &[f32; 3] = words(params, at);
                map_point::<R>(&mut r.point, |[x, y, z]| {
                    let fold = |c: R, on: f32| if on > 0.0 { c.abs() } else { c };
                    [fold(x, w[0]), fold(y, w[1]), fold(z, w[2])]
                });
            }
            abi::OP_ELONGATE => {
                let w: &[f32; 3] = words(params, at);
                map_point::<R>(&mut r.point, |[x, y, z]| {
                    let pull = |c: R, by: f32| c - c.clamp_to(-by, by);
                    [pull(x, w[0]), pull(y, w[1]), pull(z, w[2])]
                });
            }
            abi::OP_REPEAT | abi::OP_RADIAL => {
                r.points.push(r.point.clone());
                r.values.push(std::mem::replace(&mut r.acc, R::splat(FAR)));
                if MATERIALS {
                    r.materials.push((*r.material).clone());
                }
                r.loops.push(0);
                candidate(r, params, op, at, 0);
            }
            abi::OP_NEXT => {
                let begin = program.instrs[operand as usize];
                let (Some(done), Some(least)) = (r.loops.last_mut(), r.values.last_mut()) else {
                    continue;
                };
                *done += 1;
                let done = *done;
                // Keep the nearer of this copy and the nearest before it.
                for i in 0..LANES {
                    let (a, b) = (R::get(least, i), R::get(&r.acc, i));
                    let nearer = b.value() < a.value();
                    R::set(least, i, if nearer { b } else { a });
                    if MATERIALS
                        && nearer
                        && let Some(kept) = r.materials.last_mut()
                    {
                        for (kept, own) in kept.iter_mut().zip(r.material.iter()) {
                            kept.0[i] = own.0[i];
                        }
                    }
                }
                if done < candidates(params, begin.op, begin.params as usize) {
                    r.acc = R::splat(FAR);
                    candidate(r, params, begin.op, begin.params as usize, done);
                    pc = operand as usize + 1;
                } else {
                    r.loops.pop();
                    r.acc = r.values.pop().unwrap_or_else(|| R::splat(FAR));
                    if MATERIALS && let Some(kept) = r.materials.pop() {
                        *r.material = kept;
                    }
                    if let Some(point) = r.points.pop() {
                        r.point = point;
                    }
                }
            }
            abi::OP_TWIST | abi::OP_BEND => {
                r.points.push(r.point.clone());
                let w: &[f32; TWIST_WORDS] = words(params, at);
                map_point::<R>(&mut r.point, |p| {
                    let held = [
                        p[0].clamp_to(w[0], w[3]),
                        p[1].clamp_to(w[1], w[4]),
                        p[2].clamp_to(w[2], w[5]),
                    ];
                    if op == abi::OP_TWIST {
                        twist(held, w[6])
                    } else {
                        bend(held, w[6])
                    }
                });
            }
            abi::OP_UNCLAMP => {
                let w: &[f32; TWIST_WORDS] = words(params, at);
                if let Some(point) = r.points.pop() {
                    r.point = point;
                }
                let [xs, ys, zs] = &r.point;
                for i in 0..LANES {
                    let d = unclamp(
                        R::get(&r.acc, i),
                        [R::get(xs, i), R::get(ys, i), R::get(zs, i)],
                        w,
                    );
                    R::set(&mut r.acc, i, d);
                }
            }
            abi::OP_ROUND => {
                let &[radius]: &[f32; 1] = words(params, at);
                for i in 0..LANES {
                    let d = R::get(&r.acc, i) - radius;
                    R::set(&mut r.acc, i, d);
                }
            }
            abi::OP_SHELL => {
                let &[thickness]: &[f32; 1] = words(params, at);
                for i in 0..LANES {
                    let d = R::get(&r.acc, i).abs() - thickness;
                    R::set(&mut r.acc, i, d);
                }
            }
            abi::OP_DISPLACE => {
                let &[amplitude, frequency]: &[f32; 2] = words(params, at);
                let [xs, ys, zs] = &r.point;
                for i in 0..LANES {
                    let p = [
                        R::get(xs, i) * frequency,
                        R::get(ys, i) * frequency,
                        R::get(zs, i) * frequency,
                    ];
                    let d = R::get(&r.acc, i) + noise::value_noise(p, operand) * amplitude;
                    R::set(&mut r.acc, i, d);
                }
            }
            _ => {}
        }
    }
    for i in 0..LANES {
        let d = if r.exiled.0[i] > 0.0 {
            R::constant(FAR)
        } else {
            R::get(&r.acc, i)
        };
        R::set(&mut r.acc, i, d);
    }
}

/// Move the points that are not in the world to its origin, so that no arithmetic overflows; whether there were any is
/// 1 in the answer, lane by lane.
#[inline(always)]
fn exile<R: Real>([xs, ys, zs]: &mut [R::Lanes; 3]) -> F32Lanes {
    let mut exiled = f32::splat(0.0);
    for i in 0..LANES {
        let [x, y, z] = [R::get(xs, i), R::get(ys, i), R::get(zs, i)];
        let is_in_world = |c: R| c.value().abs() <= WORLD_LIMIT;
        let stays = is_in_world(x) & is_in_world(y) & is_in_world(z);
        let keep = |c: R| if stays { c } else { R::constant(0.0) };
        R::set(xs, i, keep(x));
        R::set(ys, i, keep(y));
        R::set(zs, i, keep(z));
        exiled.0[i] = if stays { 0.0 } else { 1.0 };
    }
    exiled
}

/// How many copies a loop looks at.
fn candidates(params: &[f32], op: u32, at: usize) -> u32 {
    if op == abi::OP_REPEAT {
        let w: &[f32; REPEAT_WORDS] = words(params, at);
        (w[12] * w[13] * w[14]) as u32
    } else {
        let w: &[f32; RADIAL_WORDS] = words(params, at);
        w[2] as u32
    }
}

/// Place the points relative to a loop's copy number `j`.
#[inline(always)]
fn candidate<R: Real>(r: &mut Registers<R>, params: &[f32], op: u32, at: usize, j: u32) {
    let Some(saved) = r.points.last() else { return };
    let [xs, ys, zs] = saved;
    let [px, py, pz] = &mut r.point;
    if op == abi::OP_REPEAT {
        let w: &[f32; REPEAT_WORDS] = words(params, at);
        let (nx, ny) = (w[12] as u32, w[13] as u32);
        let (jx, jy, jz) = (
            (j % nx.max(1)) as f32,
            (j / nx.max(1) % ny.max(1)) as f32,
            (j / (nx * ny).max(1)) as f32,
        );
        for i in 0..LANES {
            R::set(px, i, repeat_axis(R::get(xs, i), jx, w, 0));
            R::set(py, i, repeat_axis(R::get(ys, i), jy, w, 1));
            R::set(pz, i, repeat_axis(R::get(zs, i), jz, w, 2));
        }
    } else {
        let w: &[f32; RADIAL_WORDS] = words(params, at);
        for i in 0..LANES {
            let (x, z) = radial(R::get(xs, i), R::get(zs, i), j as f32, w);
            R::set(px, i, x);
            R::set(pz, i, z);
        }
        *py = ys.clone();
    }
}

/// Combine one brush with the accumulator.
#[inline(always)]
fn measure<R: Real>(
    program: &Program,
    r: &mut Registers<R>,
    op: u32,
    flags: u32,
    b: &Brush<'_>,
    at: usize,
) {
    let is_translation = flags & abi::FLAG_TRANSLATION != 0;
    let params = &program.params[..];
    macro_rules! shape {
        ($function:path) => {{
            let w = words(params, at);
            brush::<R, _>(
                &r.point,
                &mut r.acc,
                b,
                r.active,
                is_translation,
                w,
                $function,
            )
        }};
    }
    match op {
        abi::OP_SPHERE => shape!(shapes::sd_sphere),
        abi::OP_ELLIPSOID => shape!(shapes::sd_ellipsoid),
        abi::OP_BOX => shape!(shapes::sd_box),
        abi::OP_BOX_FRAME => shape!(shapes::sd_box_frame),
        abi::OP_TORUS => shape!(shapes::sd_torus),
        abi::OP_CAPPED_TORUS => shape!(shapes::sd_capped_torus),
        abi::OP_LINK => shape!(shapes::sd_link),
        abi::OP_CAPSULE => shape!(shapes::sd_capsule),
        abi::OP_CYLINDER => shape!(shapes::sd_cylinder),
        abi::OP_CONE => shape!(shapes::sd_cone),
        abi::OP_CAPPED_CONE => shape!(shapes::sd_capped_cone),
        abi::OP_ROUND_CONE => shape!(shapes::sd_round_cone),
        abi::OP_PLANE => shape!(shapes::sd_plane),
        abi::OP_HEX_PRISM => shape!(shapes::sd_hex_prism),
        abi::OP_TRI_PRISM => shape!(shapes::sd_tri_prism),
        abi::OP_OCTAHEDRON => shape!(shapes::sd_octahedron),
        abi::OP_PYRAMID => shape!(shapes::sd_pyramid),
        abi::OP_CUT_SPHERE => shape!(shapes::sd_cut_sphere),
        abi::OP_CUT_HOLLOW_SPHERE => shape!(shapes::sd_cut_hollow_sphere),
        abi::OP_SOLID_ANGLE => shape!(shapes::sd_solid_angle),
        abi::OP_RHOMBUS => shape!(shapes::sd_rhombus),
        abi::OP_EXTRUDED_ROUNDED_BOX => shape!(shapes::sd_extruded_rounded_box),
        _ => curve_brush(r, program, op, b, at),
    }
}
