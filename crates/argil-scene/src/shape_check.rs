//! Which parameters a shape may have, and the box it lies in.

use crate::fault::{Fault, at_most, coordinate, each, not_negative, positive, within};
use crate::{Outline, Shape};
use argil_math::Aabb;
use glam::{Vec2, Vec3};

/// Most pieces of an outline: each costs every evaluation of its shape.
const MAX_PIECES: usize = 256;

impl Shape {
    /// Whether every parameter can be used; else the first that cannot.
    pub fn check(&self) -> Result<(), Fault> {
        match *self {
            Self::Sphere { radius } | Self::Octahedron { radius } => positive("radius", radius),
            Self::Ellipsoid { radii } => each("radii", radii, positive),
            Self::Box {
                half_size,
                rounding,
            } => {
                each("half_size", half_size, positive)?;
                not_negative("rounding", rounding)?;
                at_most(
                    "rounding",
                    rounding,
                    least(half_size),
                    "the least half size",
                )
            }
            Self::BoxFrame {
                half_size,
                thickness,
            } => {
                each("half_size", half_size, positive)?;
                positive("thickness", thickness)?;
                at_most(
                    "thickness",
                    thickness,
                    least(half_size),
                    "the least half size",
                )
            }
            Self::Torus {
                major_radius,
                minor_radius,
            } => ring(major_radius, minor_radius),
            Self::CappedTorus {
                major_radius,
                minor_radius,
                half_angle_degrees,
            } => {
                ring(major_radius, minor_radius)?;
                within("half_angle_degrees", half_angle_degrees, 0.1, 180.0)
            }
            Self::Link {
                half_length,
                major_radius,
                minor_radius,
            } => {
                not_negative("half_length", half_length)?;
                ring(major_radius, minor_radius)
            }
            Self::Capsule { from, to, radius } => {
                each("from", from, coordinate)?;
                each("to", to, coordinate)?;
                positive("radius", radius)
            }
            Self::Cylinder {
                radius,
                half_height,
                rounding,
            } => {
                positive("radius", radius)?;
                positive("half_height", half_height)?;
                not_negative("rounding", rounding)?;
                at_most(
                    "rounding",
                    rounding,
                    radius.min(half_height),
                    "the lesser of radius and half height",
                )
            }
            Self::Cone { radius, height } => {
                positive("radius", radius)?;
                positive("height", height)
            }
            Self::CappedCone {
                half_height,
                bottom_radius,
                top_radius,
            } => {
                positive("half_height", half_height)?;
                not_negative("bottom_radius", bottom_radius)?;
                not_negative("top_radius", top_radius)?;
                if bottom_radius.max(top_radius) < 1e-6 {
                    return Err(Fault::new(
                        "bottom_radius",
                        "both radii are 0: one must be positive",
                    ));
                }
                Ok(())
            }
            Self::RoundCone {
                bottom_radius,
                top_radius,
                height,
            } => {
                positive("bottom_radius", bottom_radius)?;
                positive("top_radius", top_radius)?;
                positive("height", height)?;
                let least = (bottom_radius - top_radius).abs();
                if height <= least * 1.0001 {
                    return Err(Fault::new(
                        "height",
                        format!("{height} is not more than the radii differ by, {least}"),
                    ));
                }
                Ok(())
            }
            Self::Plane { normal, offset } => {
                each("normal", normal, coordinate)?;
                if Vec3::from(normal).length() < 1e-6 {
                    return Err(Fault::new("normal", "[0, 0, 0] has no direction"));
                }
                coordinate("offset", offset)
            }
            Self::HexPrism {
                apothem,
                half_depth,
            } => {
                positive("apothem", apothem)?;
                positive("half_depth", half_depth)
            }
            Self::TriPrism {
                half_side,
                half_depth,
            } => {
                positive("half_side", half_side)?;
                positive("half_depth", half_depth)
            }
            Self::Pyramid { base, height } => {
                positive("base", base)?;
                positive("height", height)
            }
            Self::CutSphere { radius, cut } => cut_ball(radius, cut),
            Self::CutHollowSphere {
                radius,
                cut,
                thickness,
            } => {
                cut_ball(radius, cut)?;
                positive("thickness", thickness)
            }
            Self::SolidAngle {
                radius,
                half_angle_degrees,
            } => {
                positive("radius", radius)?;
                within("half_angle_degrees", half_angle_degrees, 0.1, 179.9)
            }
            Self::Rhombus {
                half_length_x,
                half_length_z,
                half_height,
                rounding,
            } => {
                positive("half_length_x", half_length_x)?;
                positive("half_length_z", half_length_z)?;
                positive("half_height", half_height)?;
                not_negative("rounding", rounding)
            }
            Self::ExtrudedRoundedBox {
                half_size,
                corner_radii,
                rounding,
            } => {
                each("half_size", half_size, positive)?;
                each("corner_radii", corner_radii, not_negative)?;
                each("rounding", rounding, not_negative)?;
                let flat = half_size[0].min(half_size[2]) * 1.000_001;
                for (i, r) in corner_radii.into_iter().enumerate() {
                    at_most(
                        &format!("corner_radii[{i}]"),
                        r,
                        flat,
                        "the lesser half size in x and z",
                    )?;
                }
                for (i, r) in rounding.into_iter().enumerate() {
                    at_most(
                        &format!("rounding[{i}]"),
                        r,
                        least(half_size) * 1.000_001,
                        "the least half size",
                    )?;
                }
                Ok(())
            }
            Self::BezierTube {
                from,
                control,
                to,
                from_radius,
                to_radius,
            } => {
                each("from", from, coordinate)?;
                each("control", control, coordinate)?;
                each("to", to, coordinate)?;
                positive("from_radius", from_radius)?;
                positive("to_radius", to_radius)
            }
            Self::Lathe { ref outline } => {
                check_outline(outline)?;
                let mut points = outline
                    .segments()
                    .flat_map(|(a, b, c)| [Some(a), b, Some(c)])
                    .flatten();
                match points.find(|p| p[0] < 0.0) {
                    Some(p) => Err(Fault::new(
                        "outline",
                        format!("{p:?} lies at a negative distance from the axis"),
                    )),
                    None => Ok(()),
                }
            }
            Self::Extrusion {
                ref outline,
                half_depth,
            } => {
                check_outline(outline)?;
                positive("half_depth", half_depth)
            }
            Self::Mesh {
                ref path,
                resolution,
                ..
            } => {
                if path.is_empty() {
                    return Err(Fault::new("path", "names no file"));
                }
                if !(16..=512).contains(&resolution) {
                    return Err(Fault::new(
                        "resolution",
                        format!("{resolution} is not from 16 to 512"),
                    ));
                }
                Ok(())
            }
        }
    }

    /// A box around the solid, in the shape's own frame; infinite for a plane.
    pub fn aabb(&self) -> Aabb {
        let tall = |r: f32, min_y: f32, max_y: f32| {
            Aabb::new(Vec3::new(-r, min_y, -r), Vec3::new(r, max_y, r))
        };
        let flat = |r: Vec2, half_depth: f32| Aabb::centered(r.extend(half_depth));
        match *self {
            Self::Sphere { radius } | Self::Octahedron { radius } => {
                Aabb::centered(Vec3::splat(radius))
            }
            Self::Ellipsoid { radii } => Aabb::centered(radii.into()),
            Self::Box { half_size, .. }
            | Self::BoxFrame { half_size, .. }
            | Self::ExtrudedRoundedBox { half_size, .. } => Aabb::centered(half_size.into()),
            Self::Torus {
                major_radius,
                minor_radius,
            } => tall(major_radius + minor_radius, -minor_radius, minor_radius),
            Self::CappedTorus {
                major_radius,
                minor_radius,
                ..
            } => flat(Vec2::splat(major_radius + minor_radius), minor_radius),
            Self::Link {
                half_length,
                major_radius,
                minor_radius,
            } => {
                let r = major_radius + minor_radius;
                flat(Vec2::new(r, half_length + r), minor_radius)
            }
            Self::Capsule { from, to, radius } => {
                Aabb::around([from.into(), to.into()]).grown(radius)
            }
            Self::Cylinder {
                radius,
                half_height,
                ..
            } => tall(radius, -half_height, half_height),
            Self::Cone { radius, height } => tall(radius, -height, 0.0),
            Self::CappedCone {
                half_height,
                bottom_radius,
                top_radius,
            } => tall(bottom_radius.max(top_radius), -half_height, half_height),
            Self::RoundCone {
                bottom_radius,
                top_radius,
                height,
            } => tall(
                bottom_radius.max(top_radius),
                -bottom_radius,
                height + top_radius,
            ),
            Self::Plane { normal, offset } => half_space(Vec3::from(normal), offset),
            Self::HexPrism {
                apothem,
                half_depth,
            } => flat(Vec2::new(apothem * 2.0 / 3f32.sqrt(), apothem), half_depth),
            Self::TriPrism {
                half_side,
                half_depth,
            } => {
                let below = half_side / 3f32.sqrt();
                Aabb::new(
                    Vec3::new(-half_side, -below, -half_depth),
                    Vec3::new(half_side, 2.0 * below, half_depth),
                )
            }
            Self::Pyramid { base, height } => tall(0.5 * base, 0.0, height),
            Self::CutSphere { radius, cut } => tall(
                if cut > 0.0 { rim(radius, cut) } else { radius },
                cut,
                radius,
            ),
            Self::CutHollowSphere {
                radius,
                cut,
                thickness,
            } => tall(
                if cut < 0.0 { rim(radius, cut) } else { radius },
                -radius,
                cut,
            )
            .grown(thickness),
            Self::SolidAngle {
                radius,
                half_angle_degrees,
            } => {
                let (sin, cos) = half_angle_degrees.to_radians().sin_cos();
                tall(
                    if cos > 0.0 { radius * sin } else { radius },
                    (radius * cos).min(0.0),
                    radius,
                )
            }
            Self::Rhombus {
                half_length_x,
                half_length_z,
                half_height,
                rounding,
            } => {
                Aabb::centered(Vec3::new(half_length_x, half_height, half_length_z)).grown(rounding)
            }
            Self::BezierTube {
                from,
                control,
                to,
                from_radius,
                to_radius,
            } => {
                // The curve lies in the hull of its three points.
                Aabb::around([from.into(), control.into(), to.into()])
                    .grown(from_radius.max(to_radius))
            }
            Self::Lathe { ref outline } => {
                let (min, max) = outline_bounds(outline);
                tall(max.x, min.y, max.y)
            }
            Self::Extrusion {
                ref outline,
                half_depth,
            } => {
                let (min, max) = outline_bounds(outline);
                Aabb::new(min.extend(-half_depth), max.extend(half_depth))
            }
            // Beyond the samples' box it is told how far that is at least, not how far the solid is.
            Self::Mesh { ref grid, .. } => {
                grid.0.as_ref().map_or(Aabb::EMPTY, |grid| grid.region())
            }
        }
    }
}

fn least(v: [f32; 3]) -> f32 {
    Vec3::from(v).min_element()
}

/// The radius of the circle in which a ball is cut.
fn rim(radius: f32, cut: f32) -> f32 {
    (radius * radius - cut * cut).max(0.0).sqrt()
}

fn ring(major_radius: f32, minor_radius: f32) -> Result<(), Fault> {
    positive("major_radius", major_radius)?;
    positive("minor_radius", minor_radius)
}

fn cut_ball(radius: f32, cut: f32) -> Result<(), Fault> {
    positive("radius", radius)?;
    coordinate("cut", cut)?;
    if cut.abs() < radius * 0.9999 {
        Ok(())
    } else {
        Err(Fault::new(
            "cut",
            format!("{cut} does not cut a ball of radius {radius}"),
        ))
    }
}

fn half_space(normal: Vec3, offset: f32) -> Aabb {
    let n = normal.normalize();
    let mut b = Aabb::ALL;
    for axis in 0..3 {
        if n[axis] == 1.0 {
            b.max[axis] = offset;
        } else if n[axis] == -1.0 {
            b.min[axis] = -offset;
        }
    }
    b
}

fn check_outline(outline: &Outline) -> Result<(), Fault> {
    each("outline.start", outline.start, coordinate)?;
    for (i, piece) in outline.pieces.iter().enumerate() {
        let at = format!("outline.pieces[{i}]");
        each("to", piece.to, coordinate).map_err(|f| f.within(&at))?;
        if let Some(control) = piece.control {
            each("control", control, coordinate).map_err(|f| f.within(&at))?;
        }
    }
    if outline.pieces.len() > MAX_PIECES {
        let count = outline.pieces.len();
        return Err(Fault::new(
            "outline.pieces",
            format!("{count} pieces are more than the limit, {MAX_PIECES}"),
        ));
    }
    let (min, max) = outline_bounds(outline);
    if (max - min).min_element() < 1e-6 {
        return Err(Fault::new("outline", "the outline encloses no area"));
    }
    Ok(())
}

fn outline_bounds(outline: &Outline) -> (Vec2, Vec2) {
    let points = outline
        .segments()
        .flat_map(|(a, b, c)| [a, b.unwrap_or(c), c])
        .map(Vec2::from);
    points.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(lo, hi), p| {
        (lo.min(p), hi.max(p))
    })
}
