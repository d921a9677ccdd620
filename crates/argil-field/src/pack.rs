//! A shape's parameters as the words that both interpreters read.

use argil_abi as abi;
use argil_scene::{Outline, Shape};
use glam::{Vec2, Vec3};

/// The shape's opcode; its words are appended to `words`.
pub(crate) fn pack(shape: &Shape, words: &mut Vec<f32>) -> u32 {
    let (op, own): (u32, Vec<f32>) = match *shape {
        Shape::Sphere { radius } => (abi::OP_SPHERE, vec![radius]),
        Shape::Ellipsoid { radii } => {
            let r = Vec3::from(radii);
            let mut own = radii.to_vec();
            own.extend(r.recip().to_array());
            own.extend([r.min_element(), r.max_element()]);
            (abi::OP_ELLIPSOID, own)
        }
        Shape::Box {
            half_size: [x, y, z],
            rounding: r,
        } => (abi::OP_BOX, vec![x - r, y - r, z - r, r]),
        Shape::BoxFrame {
            half_size: [x, y, z],
            thickness,
        } => (abi::OP_BOX_FRAME, vec![x, y, z, thickness]),
        Shape::Torus {
            major_radius,
            minor_radius,
        } => (abi::OP_TORUS, vec![major_radius, minor_radius]),
        Shape::CappedTorus {
            major_radius,
            minor_radius,
            half_angle_degrees,
        } => {
            let (sin, cos) = half_angle_degrees.to_radians().sin_cos();
            (
                abi::OP_CAPPED_TORUS,
                vec![sin, cos, major_radius, minor_radius],
            )
        }
        Shape::Link {
            half_length,
            major_radius,
            minor_radius,
        } => (abi::OP_LINK, vec![half_length, major_radius, minor_radius]),
        Shape::Capsule { from, to, radius } => {
            let axis = Vec3::from(to) - Vec3::from(from);
            let squared = axis.length_squared();
            let reciprocal = if squared > 0.0 { 1.0 / squared } else { 0.0 };
            (
                abi::OP_CAPSULE,
                [&from[..], &axis.to_array(), &[reciprocal, radius]].concat(),
            )
        }
        Shape::Cylinder {
            radius,
            half_height,
            rounding: r,
        } => (abi::OP_CYLINDER, vec![radius - r, half_height - r, r]),
        Shape::Cone { radius, height } => (
            abi::OP_CONE,
            vec![radius, height, 1.0 / (radius * radius + height * height)],
        ),
        Shape::CappedCone {
            half_height,
            bottom_radius,
            top_radius,
        } => {
            let slope = bottom_radius - top_radius;
            let side = 1.0 / (slope * slope + 4.0 * half_height * half_height);
            // The side runs from the top rim down: (slope, −2 · half height).
            (
                abi::OP_CAPPED_CONE,
                vec![half_height, bottom_radius, top_radius, -slope, side],
            )
        }
        Shape::RoundCone {
            bottom_radius,
            top_radius,
            height,
        } => {
            let sine = (bottom_radius - top_radius) / height;
            (
                abi::OP_ROUND_CONE,
                vec![
                    bottom_radius,
                    top_radius,
                    height,
                    sine,
                    (1.0 - sine * sine).sqrt(),
                ],
            )
        }
        Shape::Plane { normal, offset } => {
            let n = Vec3::from(normal).normalize();
            (abi::OP_PLANE, vec![n.x, n.y, n.z, offset])
        }
        Shape::HexPrism {
            apothem,
            half_depth,
        } => (abi::OP_HEX_PRISM, vec![apothem, half_depth]),
        Shape::TriPrism {
            half_side,
            half_depth,
        } => (abi::OP_TRI_PRISM, vec![half_side, half_depth]),
        Shape::Octahedron { radius } => (abi::OP_OCTAHEDRON, vec![radius]),
        Shape::Pyramid { base, height } => {
            let half = 0.5 * base;
            let slope = half.hypot(height);
            (
                abi::OP_PYRAMID,
                vec![half, height, slope, half / slope, height / slope],
            )
        }
        Shape::CutSphere { radius, cut } => {
            (abi::OP_CUT_SPHERE, vec![radius, cut, rim(radius, cut)])
        }
        Shape::CutHollowSphere {
            radius,
            cut,
            thickness,
        } => (
            abi::OP_CUT_HOLLOW_SPHERE,
            vec![radius, cut, rim(radius, cut), thickness],
        ),
        Shape::SolidAngle {
            radius,
            half_angle_degrees,
        } => {
            let (sin, cos) = half_angle_degrees.to_radians().sin_cos();
            (abi::OP_SOLID_ANGLE, vec![sin, cos, radius])
        }
        Shape::Rhombus {
            half_length_x: x,
            half_length_z: z,
            half_height,
            rounding,
        } => (
            abi::OP_RHOMBUS,
            vec![x, z, half_height, rounding, 1.0 / (x * x + z * z)],
        ),
        Shape::ExtrudedRoundedBox {
            half_size,
            corner_radii,
            rounding,
        } => (
            abi::OP_EXTRUDED_ROUNDED_BOX,
            [&half_size[..], &corner_radii, &rounding].concat(),
        ),
        Shape::BezierTube {
            from,
            control,
            to,
            from_radius,
            to_radius,
        } => {
            let (a, b, c) = (Vec3::from(from), Vec3::from(control), Vec3::from(to));
            let (linear, quadratic) = ((b - a) * 2.0, a - 2.0 * b + c);
            let radii = [from_radius, to_radius - from_radius];
            let curve = [&from[..], &linear.to_array(), &quadratic.to_array(), &radii].concat();
            (abi::OP_BEZIER_TUBE, [box_words(shape), curve].concat())
        }
        Shape::Lathe { ref outline } => {
            let mut own = box_words(shape);
            own.extend([0.0, 0.0]);
            own[6] = pack_outline(outline, true, &mut own) as f32;
            (abi::OP_LATHE, own)
        }
        Shape::Extrusion {
            ref outline,
            half_depth,
        } => {
            let mut own = box_words(shape);
            own.extend([0.0, half_depth]);
            own[6] = pack_outline(outline, false, &mut own) as f32;
            (abi::OP_EXTRUSION, own)
        }
        Shape::Mesh { ref grid, .. } => {
            let Some(grid) = &grid.0 else {
                // Lowering has refused it.
                return abi::OP_SHAPES_END;
            };
            // Distances are those of the grid's box at least, not of the solid's: they lie between samples.
            let region = grid.region();
            words.extend([region.min.to_array(), region.max.to_array()].concat());
            words.extend_from_slice(grid.words());
            return abi::OP_SAMPLED;
        }
    };
    words.extend(own);
    op
}

/// The box around a shape that is searched, so that the search can be left out where it cannot matter.
fn box_words(shape: &Shape) -> Vec<f32> {
    let b = shape.aabb();
    [b.min.to_array(), b.max.to_array()].concat()
}

fn rim(radius: f32, cut: f32) -> f32 {
    (radius * radius - cut * cut).max(0.0).sqrt()
}

/// Append the pieces, each as kind (0 a line, 1 a curve), start, control, end, spare. Curves are cut where they turn
/// around in y, so that a horizontal line meets each at most once, and where they turn by more than half of a right
/// angle, so that a point has one nearest point inside each at most. Pieces on a lathe's axis are not part of its
/// surface.
fn pack_outline(outline: &Outline, is_lathe: bool, words: &mut Vec<f32>) -> usize {
    let mut count = 0;
    let mut push = |kind: f32, [a, b, c]: [Vec2; 3]| {
        words.extend([kind, a.x, a.y, b.x, b.y, c.x, c.y, 0.0]);
        count += 1;
    };
    for (a, control, c) in outline.segments() {
        let (a, c) = (Vec2::from(a), Vec2::from(c));
        let Some(b) = control.map(Vec2::from) else {
            let on_axis = is_lathe && a.x == 0.0 && c.x == 0.0;
            if !on_axis {
                push(0.0, [a, a, c]);
            }
            continue;
        };
        // y′ = 0 at t = (a − b) / (a − 2b + c).
        let turn = (a.y - b.y) / (a.y - 2.0 * b.y + c.y);
        if turn > 0.0 && turn < 1.0 {
            let [mut left, mut right] = cut([a, b, c], turn);
            // Flat at the turn: the controls' heights are exactly the turn's.
            left[1].y = left[2].y;
            right[1].y = left[2].y;
            flatten(left, 0, &mut |curve| push(1.0, curve));
            flatten(right, 0, &mut |curve| push(1.0, curve));
        } else {
            flatten([a, b, c], 0, &mut |curve| push(1.0, curve));
        }
    }
    count
}

/// Halve a curve until its ends' directions are less than 45 degrees apart, five times at most.
fn flatten(curve: [Vec2; 3], depth: u32, push: &mut impl FnMut([Vec2; 3])) {
    let [a, b, c] = curve;
    let turned = (b - a).angle_to(c - b).abs();
    if turned > std::f32::consts::FRAC_PI_4 && depth < 5 {
        let [left, right] = cut(curve, 0.5);
        flatten(left, depth + 1, push);
        flatten(right, depth + 1, push);
    } else {
        push(curve);
    }
}

/// De Casteljau's cut of a quadratic curve.
fn cut([a, b, c]: [Vec2; 3], t: f32) -> [[Vec2; 3]; 2] {
    let (left, right) = (a.lerp(b, t), b.lerp(c, t));
    let middle = left.lerp(right, t);
    [[a, left, middle], [middle, right, c]]
}
