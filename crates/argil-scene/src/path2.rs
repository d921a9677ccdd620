//! Curves that shapes are drawn with: outlines of pieces, and splines through points.

use glam::{Vec2, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A point that a spline tube goes through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SplinePoint {
    /// Where it is.
    pub at: [f32; 3],
    /// Radius of the tube there.
    pub radius: f32,
}

impl SplinePoint {
    /// A point, with the tube's radius there.
    pub fn new(at: [f32; 3], radius: f32) -> Self {
        Self { at, radius }
    }
}

/// A piece of a spline tube: start, control point and end of a quadratic Bézier curve, radii at its start and end.
#[doc(hidden)]
pub type TubePiece = ([Vec3; 3], [f32; 2]);

/// The pieces of a tube through points, two from each to the next, which meet halfway between their control points.
#[doc(hidden)]
pub fn spline_pieces(points: &[SplinePoint]) -> impl Iterator<Item = TubePiece> + '_ {
    let at = |i: usize| Vec3::from(points[i.min(points.len() - 1)].at);
    // A quarter of the way that the curve goes at a point in the unit of its parameter.
    let quarter = move |i: usize| 0.125 * (at(i + 1) - at(i.saturating_sub(1)));
    (1..points.len()).flat_map(move |i| {
        let (a, b) = (at(i - 1), at(i));
        let (left, right) = (a + quarter(i - 1), b - quarter(i));
        let middle = 0.5 * (left + right);
        let [from, to] = [points[i - 1].radius, points[i].radius];
        let halfway = 0.5 * (from + to);
        [
            ([a, left, middle], [from, halfway]),
            ([middle, right, b], [halfway, to]),
        ]
    })
}

/// A closed outline in 2D, of lines and quadratic Bézier curves. A line closes it where the last piece ends elsewhere
/// than at the start. What lies inside is decided by the even-odd rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Path2 {
    /// Where the outline starts.
    pub start: [f32; 2],
    /// Its pieces, each from where the one before ended.
    #[serde(alias = "pieces")]
    pub segments: Vec<PathSegment>,
}

/// A piece of an outline: a line, or a curve where there is a control point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PathSegment {
    /// Control point of a quadratic Bézier curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control: Option<[f32; 2]>,
    /// Where the piece ends.
    pub to: [f32; 2],
}

impl Path2 {
    /// An outline that starts at a point.
    ///
    /// ```
    /// use argil_scene::{Path2, Shape};
    /// let outline = Path2::new([0.0, 0.0]).line([1.0, 0.0]).curve([1.0, 1.0], [0.0, 1.0]);
    /// assert!(Shape::Extrusion { outline, half_depth: 0.1 }.check().is_ok());
    /// ```
    pub fn new(start: [f32; 2]) -> Self {
        Self {
            start,
            segments: Vec::new(),
        }
    }

    /// A line from where it ends, to a point.
    #[must_use]
    pub fn line(mut self, to: [f32; 2]) -> Self {
        self.segments.push(PathSegment { control: None, to });
        self
    }

    /// A quadratic Bézier curve from where it ends, by a control point, to a point.
    #[must_use]
    pub fn curve(mut self, control: [f32; 2], to: [f32; 2]) -> Self {
        let control = Some(control);
        self.segments.push(PathSegment { control, to });
        self
    }

    /// The corners of a box around the outline: that of its points and control points.
    pub fn bounds(&self) -> (Vec2, Vec2) {
        let points = self
            .segments()
            .flat_map(|(a, b, c)| [a, b.unwrap_or(c), c])
            .map(Vec2::from);
        points.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(lo, hi), p| {
            (lo.min(p), hi.max(p))
        })
    }

    /// Start, control and end point of each piece, the closing line included; a line has no control point.
    pub fn segments(&self) -> impl Iterator<Item = ([f32; 2], Option<[f32; 2]>, [f32; 2])> + '_ {
        let mut at = self.start;
        let closing = PathSegment {
            control: None,
            to: self.start,
        };
        self.segments
            .iter()
            .copied()
            .chain([closing])
            .filter_map(move |piece| {
                let from = std::mem::replace(&mut at, piece.to);
                (from != piece.to || piece.control.is_some()).then_some((
                    from,
                    piece.control,
                    piece.to,
                ))
            })
    }
}
