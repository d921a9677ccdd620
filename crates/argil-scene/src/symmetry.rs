//! Mirror symmetry of distances, which tells when the nearest of many copies is the one in a point's own cell.
//!
//! *Theory.* Let copies of a solid stand side by side along an axis, each in the middle of its cell. Of two neighbors, one is
//! the other's mirror image in the plane between their cells, if the solid is even: symmetric about the plane through
//! its middle. The copy in a point's own cell is then the nearest in two cases.
//!
//! 1. The distance is *rising*: it never falls with |x|, as every convex function that is even. The point's own cell has the
//!    smallest |x|.
//! 2. The distance outside is Euclidean, and the solid stays in its cell. The mirror image of any point of a copy beyond
//!    the plane is a point of the own copy, and it is nearer.
//!
//! Minima and maxima of rising distances are rising, and so are smooth ones, because they grow with both operands.

use crate::{Modifier, Operator, OperatorKind, Shape};
use glam::Vec3;

/// What is known of a distance along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Symmetry {
    /// Whether d(−x) = d(x).
    pub even: [bool; 3],
    /// Whether it is even, and never falls with |x|.
    pub rising: [bool; 3],
}

impl Symmetry {
    /// Nothing is known.
    pub(crate) const NONE: Self = Self {
        even: [false; 3],
        rising: [false; 3],
    };

    /// A convex solid with an exact distance, which is even along some axes.
    const fn convex(even: [bool; 3]) -> Self {
        Self { even, rising: even }
    }

    /// Returns the symmetry of a shape's distance.
    pub(crate) fn of_shape(shape: &Shape) -> Self {
        const ALL: [bool; 3] = [true; 3];
        const ABOUT_Y: [bool; 3] = [true, false, true];
        match *shape {
            Shape::Sphere { .. }
            | Shape::Box { .. }
            | Shape::Cylinder { .. }
            | Shape::HexPrism { .. }
            | Shape::Octahedron { .. }
            | Shape::Rhombus { .. } => Self::convex(ALL),
            Shape::Cone { .. }
            | Shape::CappedCone { .. }
            | Shape::RoundCone { .. }
            | Shape::Pyramid { .. }
            | Shape::CutSphere { .. } => Self::convex(ABOUT_Y),
            Shape::TriPrism { .. } => Self::convex(ABOUT_Y),
            Shape::Capsule { from, to, .. } => Self::convex(even_axes_of_segment(from, to)),
            Shape::Torus { .. } => Self {
                even: ALL,
                rising: [false, true, false],
            },
            Shape::CappedTorus { .. } => Self {
                even: ABOUT_Y,
                rising: [false, false, true],
            },
            Shape::Link { .. } => Self {
                even: ALL,
                rising: [false, false, true],
            },
            Shape::Ellipsoid { .. } | Shape::BoxFrame { .. } | Shape::Superellipsoid { .. } => {
                Self {
                    even: ALL,
                    rising: [false; 3],
                }
            }
            Shape::CutHollowSphere { .. } | Shape::SolidAngle { .. } => Self {
                even: ABOUT_Y,
                rising: [false; 3],
            },
            _ => Self::NONE,
        }
    }

    /// Returns the symmetry after a modifier.
    pub(crate) fn under(self, modifier: &Modifier) -> Self {
        let only = |keeps: [bool; 3]| Self {
            even: std::array::from_fn(|axis| self.even[axis] && keeps[axis]),
            rising: std::array::from_fn(|axis| self.rising[axis] && keeps[axis]),
        };
        match *modifier {
            Modifier::Translate { by } => only(by.map(|length| length == 0.0)),
            // The axis itself stays; a turn mixes the others.
            Modifier::Rotate { axis, degrees } => {
                if degrees == 0.0 {
                    return self;
                }
                let others = |index: usize| (0..3).all(|i| i == index || axis[i] == 0.0);
                only(std::array::from_fn(others))
            }
            Modifier::Scale { .. }
            | Modifier::Stretch { .. }
            | Modifier::ScaleDistance { .. }
            | Modifier::Round { .. }
            | Modifier::Elongate { .. } => self,
            // Where a solid crosses the mirror, its distance is no longer Euclidean.
            Modifier::Mirror { axes } => {
                let is_same = (0..3).all(|axis| !axes[axis] || self.even[axis]);
                let even = if is_same { self.even } else { self.rising };
                Self { even, ..self }
            }
            Modifier::Shell { .. } => Self {
                rising: [false; 3],
                ..self
            },
            Modifier::Repeat { spacing, count } => only(std::array::from_fn(|axis| match count {
                Some(count) => count[axis] <= 1,
                None => spacing[axis] <= 0.0,
            })),
            Modifier::RadialRepeat { .. } => only([false, true, false]),
            _ => Self::NONE,
        }
    }

    /// Returns the symmetry of a distance that an operator joins with another. A ramp is not even.
    pub(crate) fn joined(self, other: Self, operator: &Operator, has_ramp: bool) -> Self {
        let both = |a: [bool; 3], b: [bool; 3]| std::array::from_fn(|axis| a[axis] && b[axis]);
        match operator.kind {
            OperatorKind::Paint => self,
            _ if has_ramp => Self::NONE,
            OperatorKind::Subtract => Self {
                even: both(self.even, other.even),
                rising: [false; 3],
            },
            // A morph is a weighted mean only if neither weight is negative.
            OperatorKind::Morph if !(0.0..=1.0).contains(&operator.morph_amount) => Self {
                even: both(self.even, other.even),
                rising: [false; 3],
            },
            OperatorKind::Union | OperatorKind::Intersect | OperatorKind::Morph => Self {
                even: both(self.even, other.even),
                rising: both(self.rising, other.rising),
            },
        }
    }
}

/// Returns the axes along which a segment is its own mirror image.
fn even_axes_of_segment(from: [f32; 3], to: [f32; 3]) -> [bool; 3] {
    let along = Vec3::from(to) - Vec3::from(from);
    std::array::from_fn(|axis| {
        let lies_in_plane = from[axis] == 0.0 && to[axis] == 0.0;
        let is_parallel = (0..3).all(|i| i == axis || along[i] == 0.0);
        lies_in_plane || (is_parallel && from[axis] == -to[axis])
    })
}
