//! The oracle's shapes, each by its definition.

use super::grids::{heightmap, sampled, triangle};
use argil_scene::{Path2, Shape};
use glam::{DVec2 as V2, DVec3 as V3, Vec3};

/// Samples along a curve.
const SAMPLES: u32 = 20_000;

pub(super) fn d3(v: [f32; 3]) -> V3 {
    Vec3::from(v).as_dvec3()
}

/// Returns the distance to a 2D box of a half size.
fn rect(p: V2, half: V2) -> f64 {
    let q = p.abs() - half;
    q.max(V2::ZERO).length() + q.max_element().min(0.0)
}

fn cuboid(p: V3, half: V3) -> f64 {
    let q = p.abs() - half;
    q.max(V3::ZERO).length() + q.max_element().min(0.0)
}

fn segment(p: V2, a: V2, b: V2) -> f64 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a + (b - a) * t)
}

fn sides(corners: &[V2]) -> impl Iterator<Item = (V2, V2)> {
    (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]))
}

/// Whether a ray along +x crosses a polygon an odd number of times.
fn is_inside(p: V2, corners: &[V2]) -> bool {
    let crosses = |(a, b): (V2, V2)| {
        (a.y <= p.y) != (b.y <= p.y) && a.x + (p.y - a.y) * (b.x - a.x) / (b.y - a.y) > p.x
    };
    sides(corners).filter(|&s| crosses(s)).count() % 2 == 1
}

fn polygon(p: V2, corners: &[V2]) -> f64 {
    let d = sides(corners)
        .map(|(a, b)| segment(p, a, b))
        .fold(f64::INFINITY, f64::min);
    if is_inside(p, corners) { -d } else { d }
}

/// Returns the distance of a 2D distance extruded along another axis.
fn extruded(flat: f64, along: f64, half: f64) -> f64 {
    corner(flat, along.abs() - half)
}

/// Returns the distance to a region behind two walls at a right angle.
fn corner(a: f64, b: f64) -> f64 {
    V2::new(a, b).max(V2::ZERO).length() + a.max(b).min(0.0)
}

fn bezier(a: V2, b: V2, c: V2, t: f64) -> V2 {
    a.lerp(b, t).lerp(b.lerp(c, t), t)
}

/// Returns the distance to a path, as a polygon with many short sides.
fn outline(o: &Path2, p: V2, is_lathe: bool) -> f64 {
    let v = |p: [f32; 2]| V2::new(f64::from(p[0]), f64::from(p[1]));
    let steps = 400;
    let mut corners = Vec::new();
    for (a, b, c) in o.segments() {
        match b {
            None => corners.push(v(a)),
            Some(b) => corners.extend(
                (0..steps).map(|i| bezier(v(a), v(b), v(c), f64::from(i) / f64::from(steps))),
            ),
        }
    }
    let kept = sides(&corners).filter(|(a, b)| !(is_lathe && a.x == 0.0 && b.x == 0.0));
    let d = kept
        .map(|(a, b)| segment(p, a, b))
        .fold(f64::INFINITY, f64::min);
    if is_inside(p, &corners) { -d } else { d }
}

/// Returns a shape's signed distance at a point in its own frame.
#[expect(
    clippy::too_many_lines,
    reason = "an arm for each shape, each as short as its definition"
)]
pub fn shape(s: &Shape, p: V3) -> f64 {
    let f = f64::from;
    let q = V2::new(p.x.hypot(p.z), p.y);
    match *s {
        Shape::Sphere { radius } => p.length() - f(radius),
        Shape::Ellipsoid { radii } => {
            let r = d3(radii);
            let scaled = ((p / r).length() - 1.0) * r.min_element();
            scaled.max(cuboid(p, r)).max(p.length() - r.max_element())
        }
        Shape::Box {
            half_size,
            rounding,
        } => cuboid(p, d3(half_size) - f(rounding)) - f(rounding),
        Shape::BoxFrame {
            half_size,
            half_thickness,
        } => {
            // Twelve beams, of which symmetry leaves three.
            let (h, e) = (d3(half_size), f(half_thickness));
            let beam = |axis: usize| {
                let mut half = V3::splat(e);
                half[axis] = h[axis];
                let mut middle = h - e;
                middle[axis] = 0.0;
                cuboid(p.abs() - middle, half)
            };
            beam(0).min(beam(1)).min(beam(2))
        }
        Shape::Torus {
            major_radius,
            minor_radius,
        } => (q - V2::new(f(major_radius), 0.0)).length() - f(minor_radius),
        Shape::CappedTorus {
            major_radius,
            minor_radius,
            half_angle_degrees,
        } => {
            let angle =
                p.x.abs()
                    .atan2(p.y)
                    .clamp(0.0, f(half_angle_degrees).to_radians());
            let nearest = V3::new(angle.sin(), angle.cos(), 0.0) * f(major_radius);
            V3::new(p.x.abs(), p.y, p.z).distance(nearest) - f(minor_radius)
        }
        Shape::Link {
            half_length,
            major_radius,
            minor_radius,
        } => {
            let flat =
                V2::new(p.x, (p.y.abs() - f(half_length)).max(0.0)).length() - f(major_radius);
            flat.hypot(p.z) - f(minor_radius)
        }
        Shape::Capsule { from, to, radius } => {
            let (a, axis) = (d3(from), d3(to) - d3(from));
            let t = if axis == V3::ZERO {
                0.0
            } else {
                ((p - a).dot(axis) / axis.length_squared()).clamp(0.0, 1.0)
            };
            p.distance(a + axis * t) - f(radius)
        }
        Shape::Cylinder {
            radius,
            half_height,
            rounding,
        } => {
            let half = V2::new(f(radius), f(half_height)) - f(rounding);
            rect(q, half) - f(rounding)
        }
        Shape::Cone { radius, height } => polygon(
            q,
            &[
                V2::ZERO,
                V2::new(f(radius), -f(height)),
                V2::new(-f(radius), -f(height)),
            ],
        ),
        Shape::CappedCone {
            half_height: h,
            bottom_radius: b,
            top_radius: t,
        } => {
            let (h, b, t) = (f(h), f(b), f(t));
            polygon(
                q,
                &[
                    V2::new(-b, -h),
                    V2::new(b, -h),
                    V2::new(t, h),
                    V2::new(-t, h),
                ],
            )
        }
        Shape::RoundCone {
            bottom_radius,
            top_radius,
            height,
        } => (0..=SAMPLES)
            .map(|i| f64::from(i) / f64::from(SAMPLES))
            .map(|t| {
                q.distance(V2::new(0.0, t * f(height)))
                    - (f(bottom_radius) * (1.0 - t) + f(top_radius) * t)
            })
            .fold(f64::INFINITY, f64::min),
        Shape::Plane { normal, offset } => p.dot(d3(normal).normalize()) - f(offset),
        Shape::HexPrism {
            apothem,
            half_depth,
        } => {
            let r = f(apothem) * 2.0 / 3f64.sqrt();
            let corner = |i: u32| V2::from_angle(f64::from(i) * std::f64::consts::FRAC_PI_3) * r;
            extruded(
                polygon(V2::new(p.x, p.y), &[0, 1, 2, 3, 4, 5].map(corner)),
                p.z,
                f(half_depth),
            )
        }
        Shape::TriPrism {
            half_side,
            half_depth,
        } => {
            let (s, below) = (f(half_side), f(half_side) / 3f64.sqrt());
            let corners = [
                V2::new(-s, -below),
                V2::new(s, -below),
                V2::new(0.0, 2.0 * below),
            ];
            extruded(polygon(V2::new(p.x, p.y), &corners), p.z, f(half_depth))
        }
        Shape::Octahedron { radius } => {
            let r = f(radius);
            let face = [V3::X * r, V3::Y * r, V3::Z * r];
            let inside = (p.abs().element_sum() - r) / 3f64.sqrt();
            if inside < 0.0 {
                inside
            } else {
                triangle(p.abs(), face)
            }
        }
        Shape::Pyramid { base, height } => {
            let (b, tip) = (0.5 * f(base), V3::Y * f(height));
            let corners = [
                V3::new(b, 0.0, b),
                V3::new(b, 0.0, -b),
                V3::new(-b, 0.0, -b),
                V3::new(-b, 0.0, b),
            ];
            let faces = (0..4).map(|i| [corners[i], corners[(i + 1) % 4], tip]);
            let floor = [
                [corners[0], corners[1], corners[2]],
                [corners[0], corners[2], corners[3]],
            ];
            let d = faces
                .chain(floor)
                .map(|t| triangle(p, t))
                .fold(f64::INFINITY, f64::min);
            let inside = p.y > 0.0 && p.x.abs().max(p.z.abs()) < b * (1.0 - p.y / f(height));
            if inside { -d } else { d }
        }
        Shape::CutSphere { radius, cut } => {
            let (r, h) = (f(radius), f(cut));
            let rim = V2::new((r * r - h * h).sqrt(), h);
            // The sphere where its nearest point is kept, the disc, and the rim between them.
            let on_ball = q * (r / q.length().max(1e-300));
            let ball = if on_ball.y >= h {
                (q.length() - r).abs()
            } else {
                f64::INFINITY
            };
            let d = ball
                .min(segment(q, V2::new(-rim.x, h), rim))
                .min(q.distance(rim));
            if q.length() < r && q.y > h { -d } else { d }
        }
        Shape::CutHollowSphere {
            radius,
            cut,
            half_thickness,
        } => {
            let (r, h) = (f(radius), f(cut));
            let rim = V2::new((r * r - h * h).sqrt(), h);
            let on_ball = q * (r / q.length().max(1e-300));
            let ball = if on_ball.y <= h {
                (q.length() - r).abs()
            } else {
                f64::INFINITY
            };
            ball.min(q.distance(rim)) - f(half_thickness)
        }
        Shape::SolidAngle {
            radius,
            half_angle_degrees,
        } => {
            let (r, angle) = (f(radius), f(half_angle_degrees).to_radians());
            let within = q.x.atan2(q.y) < angle;
            let side = segment(q, V2::ZERO, V2::new(angle.sin(), angle.cos()) * r);
            let ball = q.length() - r;
            match (within, ball < 0.0) {
                (true, true) => ball.max(-side),
                (true, false) => ball,
                (false, _) => side,
            }
        }
        Shape::Rhombus {
            half_length_x: x,
            half_length_z: z,
            half_height,
            rounding,
        } => {
            let corners = [
                V2::new(f(x), 0.0),
                V2::new(0.0, f(z)),
                V2::new(-f(x), 0.0),
                V2::new(0.0, -f(z)),
            ];
            extruded(
                polygon(V2::new(p.x, p.z), &corners) - f(rounding),
                p.y,
                f(half_height),
            )
        }
        Shape::ExtrudedRoundedBox {
            half_size,
            corner_radii,
            rounding,
        } => {
            let which = usize::from(p.x <= 0.0) * 2 + usize::from(p.z <= 0.0);
            let (h, r) = (d3(half_size), f(corner_radii[which]));
            let flat = rect(V2::new(p.x, p.z), V2::new(h.x, h.z) - r) - r;
            let rim = f(rounding[usize::from(p.y <= 0.0)]);
            corner(flat + rim, p.y.abs() - (h.y - rim)) - rim
        }
        Shape::Gyroid {
            half_size,
            period,
            thickness,
        } => sheet(p, half_size, [period, thickness], |a| {
            a.x.sin() * a.y.cos() + a.y.sin() * a.z.cos() + a.z.sin() * a.x.cos()
        }),
        Shape::SchwarzP {
            half_size,
            period,
            thickness,
        } => sheet(p, half_size, [period, thickness], |a| {
            a.x.cos() + a.y.cos() + a.z.cos()
        }),
        Shape::Superellipsoid {
            radii,
            exponents: [n, m],
        } => {
            let (n, m, q) = (f(n), f(m), (p / d3(radii)).abs());
            let level = (q.x.powf(m) + q.z.powf(m)).powf(1.0 / m);
            let norm = (level.powf(n) + q.y.powf(n)).powf(1.0 / n);
            // The slope along each axis of an inscribed octahedron, or the smallest axis of an ellipsoid.
            let held = if n.min(m) >= 2.0 {
                d3(radii).min_element()
            } else {
                1.0 / d3(radii).recip().length()
            };
            ((norm - 1.0) * held).max(cuboid(p, d3(radii)))
        }
        Shape::BezierTube {
            from,
            control,
            to,
            from_radius,
            to_radius,
        } => (0..=SAMPLES)
            .map(|i| f64::from(i) / f64::from(SAMPLES))
            .map(|t| {
                let c = d3(from)
                    .lerp(d3(control), t)
                    .lerp(d3(control).lerp(d3(to), t), t);
                p.distance(c) - (f(from_radius) * (1.0 - t) + f(to_radius) * t)
            })
            .fold(f64::INFINITY, f64::min),
        Shape::SplineTube { ref points } => argil_scene::spline_segments(points)
            .flat_map(|([a, b, c], [from, to])| {
                let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
                (0..=SAMPLES / 10).map(move |i| {
                    let t = f64::from(10 * i) / f64::from(SAMPLES);
                    let at = a.lerp(b, t).lerp(b.lerp(c, t), t);
                    p.distance(at) - (f(from) * (1.0 - t) + f(to) * t)
                })
            })
            .fold(f64::INFINITY, f64::min),
        Shape::Lathe { outline: ref o } => outline(o, q, true),
        Shape::Extrusion {
            outline: ref o,
            half_depth,
        } => extruded(outline(o, V2::new(p.x, p.y), false), p.z, f(half_depth)),
        Shape::Text {
            ref text,
            size,
            half_depth,
        } => {
            let all = argil_scene::text_outlines(text, size);
            let distances = all.iter().map(|o| outline(o, V2::new(p.x, p.y), false));
            // Inside an odd number of them, and as far as the nearest.
            let (d, sign) = distances.fold((f64::INFINITY, 1.0f64), |(d, sign), outline_d| {
                (d.min(outline_d.abs()), sign * outline_d.signum())
            });
            extruded(d * sign, p.z, f(half_depth))
        }
        Shape::Heightmap {
            half_size,
            height,
            base,
            ref grid,
            ..
        } => grid.0.as_ref().map_or(1e30, |grid| {
            heightmap(
                p,
                grid,
                half_size.map(f64::from),
                [height, base].map(f64::from),
            )
        }),
        Shape::Mesh { ref grid, .. } => grid.0.as_ref().map_or(1e30, |grid| sampled(p, grid)),
    }
}

/// Returns the distance to a sheet along a level set with slope up to √3 per radian, in a box.
fn sheet(p: V3, half_size: [f32; 3], [period, thickness]: [f32; 2], level: fn(V3) -> f64) -> f64 {
    let (half, rate) = (d3(half_size), std::f64::consts::TAU / f64::from(period));
    let level = level(p.clamp(-half, half) * rate);
    let sheet = level.abs() / (3f64.sqrt() * rate) - 0.5 * f64::from(thickness);
    sheet.max(cuboid(p, half))
}
