//! The oracle: distances directly from the scene, point by point, in double precision, by definitions too short to
//! be wrong. It is slow and recursive, and only for tests.

mod grids;
mod shapes;

use argil_scene::{BlendProfile, Modifier, NodeId, NodeKind, Operator, OperatorKind, Scene};
use glam::{DVec2 as V2, DVec3 as V3, Vec3};

use shapes::d3;
pub use shapes::shape;

const NOTHING: f64 = crate::FAR as f64;

/// Returns the signed distance of a scene at a point.
pub fn distance(scene: &Scene, point: Vec3) -> f64 {
    node(scene, Scene::ROOT, point.as_dvec3())
}

fn node(scene: &Scene, id: NodeId, p: V3) -> f64 {
    modified(
        scene,
        id,
        scene.node(id).at_current_time().modifiers.len(),
        p,
    )
}

/// Evaluates a node after its first `count` modifiers.
fn modified(scene: &Scene, id: NodeId, count: usize, p: V3) -> f64 {
    let entry = scene.node(id).at_current_time();
    let Some(last) = count.checked_sub(1) else {
        return match &entry.kind {
            NodeKind::Shape(s) => shape(s, p),
            NodeKind::Group => group(scene, id, p),
        };
    };
    let inner = |q: V3| modified(scene, id, last, q);
    let content = || argil_scene::Extents::of(scene).modifier_stages(id)[last];
    match entry.modifiers[last] {
        Modifier::Stretch { by } => {
            let by = d3(by);
            inner(p / by) * by.min_element()
        }
        Modifier::ScaleDistance { by } => inner(p) * f64::from(by),
        ref m @ (Modifier::Translate { .. } | Modifier::Rotate { .. } | Modifier::Scale { .. }) => {
            let map = m.affine().unwrap_or_default();
            inner(map.transform_point3(p)) * f64::from(m.scale())
        }
        Modifier::Mirror { axes } => inner(V3::select(glam::BVec3::from_array(axes), p.abs(), p)),
        Modifier::Elongate { by } => inner(p - p.clamp(-d3(by), d3(by))),
        Modifier::Round { radius } => inner(p) - f64::from(radius),
        Modifier::Shell { half_thickness } => inner(p).abs() - f64::from(half_thickness),
        Modifier::Repeat { spacing, count } => {
            let places = copies(spacing, count, p).into_iter();
            places.map(|place| inner(p - place)).fold(NOTHING, f64::min)
        }
        Modifier::RadialRepeat { count } => (0..count)
            .map(|i| {
                glam::DQuat::from_rotation_y(
                    f64::from(i) / f64::from(count) * std::f64::consts::TAU,
                ) * p
            })
            .map(inner)
            .fold(NOTHING, f64::min),
        Modifier::Instances { ref poses } => poses
            .iter()
            .map(|pose| inner(pose.own_from_outer().transform_point3(p)) * f64::from(pose.scale))
            .fold(NOTHING, f64::min),
        Modifier::Extrude { half_depth } => {
            let beyond = V2::new(
                inner(V3::new(p.x, p.y, 0.0)),
                p.z.abs() - f64::from(half_depth),
            );
            beyond.max(V2::ZERO).length() + beyond.max_element().min(0.0)
        }
        Modifier::Revolve { offset } => {
            inner(V3::new(p.x.hypot(p.z) - f64::from(offset), p.y, 0.0))
        }
        ref m => deformed(m, p, content(), &inner),
    }
}

/// Evaluates a deformation of a solid of an extent, whose distance is `inner`.
fn deformed(m: &Modifier, p: V3, content: argil_scene::Extent, inner: &dyn Fn(V3) -> f64) -> f64 {
    let stretch = f64::from(m.stretch(&content));
    match *m {
        Modifier::Twist { degrees_per_unit } | Modifier::Bend { degrees_per_unit } => {
            let Some(held) = m.clamp(&content) else {
                return NOTHING;
            };
            let q = held.nearest(p);
            let rate = f64::from(degrees_per_unit).to_radians();
            let turn = |a: V2, angle: f64| V2::from_angle(angle).rotate(a);
            let back = if matches!(m, Modifier::Twist { .. }) {
                let xz = turn(V2::new(q.x, q.z), -rate * q.y);
                V3::new(xz.x, q.y, xz.y)
            } else {
                turn(V2::new(q.x, q.y), rate * q.x).extend(q.z)
            };
            let d = inner(back) / stretch;
            if p == q {
                d
            } else {
                (p - q).length().hypot(d.max(0.0))
            }
        }
        Modifier::Shift { by, ref along } => inner(p - d3(by) * along.value(p)) / stretch,
        Modifier::Wrap {
            from,
            to,
            radius,
            ref curve,
        } => {
            let (radius, length) = (f64::from(radius), f64::from(to - from));
            let core = f64::from(argil_scene::wrap_core(radius as f32, content.aabb));
            let r = p.x.hypot(p.z);
            let turn = (-p.z).atan2(p.x) / std::f64::consts::TAU + 0.5;
            let x = f64::from(from) + length * curve.value(turn);
            let scale = 1.0 / stretch;
            let at = |x: f64| inner(V3::new(x, p.y, r.max(core) - radius)) * scale;
            let copies = argil_scene::wrap_copies([from, to], curve, content.aabb);
            let sides = copies.sides as i32;
            let places =
                (-sides..=sides).map(|copy| x + f64::from(copy) * f64::from(copies.spacing));
            let d = places.map(at).fold(NOTHING, f64::min);
            let gap = (core - r) * scale;
            let solid = if r >= core {
                d.max(gap)
            } else if r >= f64::from(argil_abi::WRAP_TRUSTED) * core {
                gap.max(d - gap)
            } else {
                gap
            };
            let ends =
                (f64::from(content.aabb.min.y) - p.y).max(p.y - f64::from(content.aabb.max.y));
            let beyond = V2::new(r - radius - f64::from(content.aabb.max.z), ends);
            solid.max(beyond.max(V2::ZERO).length() + beyond.max_element().min(0.0))
        }
        Modifier::Displace {
            amplitude,
            frequency,
            seed,
            octaves,
        } => {
            let octave = |o: u32| {
                let part = 0.5f64.powi(o as i32);
                part * f64::from(amplitude)
                    * noise(p * f64::from(frequency) / part, seed.wrapping_add(o))
            };
            let (d, noise) = (inner(p), (0..octaves).map(octave).sum::<f64>());
            let most = f64::from(amplitude) * (2.0 - 0.5f64.powi(octaves as i32 - 1));
            let steep = (d + noise) / stretch;
            steep.max(d - most).min(d + most)
        }
        _ => inner(p),
    }
}

/// Returns the positions of a repetition's copies.
fn copies(spacing: [f32; 3], count: Option<[u32; 3]>, p: V3) -> Vec<V3> {
    // All copies, or for infinite repetitions, those within three cells.
    let range = |axis: usize| -> Vec<f64> {
        let step = f64::from(spacing[axis]);
        match count {
            Some(c) => (0..c[axis])
                .map(|i| (f64::from(i) - 0.5 * f64::from(c[axis] - 1)) * step)
                .collect(),
            None if step > 0.0 => (-3..=3)
                .map(|i| ((p[axis] / step).round() + f64::from(i)) * step)
                .collect(),
            None => vec![0.0],
        }
    };
    let (ys, zs) = (range(1), range(2));
    let copies = range(0)
        .into_iter()
        .flat_map(|x| ys.iter().flat_map(move |&y| [(x, y)]));
    copies
        .flat_map(|(x, y)| zs.iter().map(move |&z| V3::new(x, y, z)))
        .collect()
}

fn group(scene: &Scene, id: NodeId, p: V3) -> f64 {
    let mut all: Option<f64> = None;
    for &child in scene.node(id).children() {
        let entry = scene.node(child).at_current_time();
        if !argil_scene::Extents::of(scene).takes_part(child) {
            continue;
        }
        all = match all {
            None if entry.operator.kind == OperatorKind::Union => Some(node(scene, child, p)),
            None => None,
            Some(a) => Some(match ramped(scene, child, a, p) {
                Some(morphed) => morphed,
                None => joint(a, node(scene, child, p), &entry.operator),
            }),
        };
    }
    all.unwrap_or(NOTHING)
}

/// Morphs a distance into a node's, if that has a ramp.
fn ramped(scene: &Scene, id: NodeId, a: f64, p: V3) -> Option<f64> {
    let entry = scene.node(id).at_current_time();
    let ramp = entry.ramp.as_ref()?;
    let amount = entry.operator.morph_amount;
    let most = f64::from(ramp.max_difference);
    let difference = (node(scene, id, p) - a).clamp(-most, most);
    let share = ramp.along.value(p) * f64::from(amount);
    Some((a + difference * share) / f64::from(scene.ramp_stretch(id)))
}

/// Combines two distances with an operator.
pub fn joint(a: f64, b: f64, operator: &Operator) -> f64 {
    let k = f64::from(operator.blend);
    let smin = |a: f64, b: f64| match operator.profile {
        BlendProfile::Smooth if k > 0.0 => {
            a.min(b) - (k - (a - b).abs()).max(0.0).powi(2) / (4.0 * k)
        }
        BlendProfile::Chamfer if k > 0.0 => a.min(b).min((a + b - k) / 2f64.sqrt()),
        _ => a.min(b),
    };
    match operator.kind {
        OperatorKind::Union => smin(a, b),
        OperatorKind::Subtract => -smin(-a, b),
        OperatorKind::Intersect => -smin(-a, -b),
        OperatorKind::Paint => a,
        OperatorKind::Morph => a + (b - a) * f64::from(operator.morph_amount),
    }
}

fn noise(p: V3, seed: u32) -> f64 {
    let cell = p.floor();
    let t = p - cell;
    let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let corner = |i: u32| {
        let bit = |k: u32| f64::from(i >> k & 1);
        let c = cell + V3::new(bit(0), bit(1), bit(2));
        let weight = |k: u32| {
            if bit(k) == 1.0 {
                fade[k as usize]
            } else {
                1.0 - fade[k as usize]
            }
        };
        let value = crate::noise::lattice(c.x as i32, c.y as i32, c.z as i32, seed);
        f64::from(value) * weight(0) * weight(1) * weight(2)
    };
    (0..8).map(corner).sum()
}
