//! Curves of shapes: 2D paths, and splines through points.

use glam::{Vec2, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A point that a spline tube passes through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SplinePoint {
    /// Its position.
    pub at: [f32; 3],
    /// Radius of the tube there.
    pub radius: f32,
}

impl SplinePoint {
    /// Creates a point with the tube's radius there.
    pub fn new(at: [f32; 3], radius: f32) -> Self {
        Self { at, radius }
    }
}

/// A segment of a spline tube: the start, control point and end of a quadratic Bézier curve, and the radii at its
/// start and end.
#[doc(hidden)]
pub type TubeSegment = ([Vec3; 3], [f32; 2]);

/// Returns the segments of a tube through points: two from each point to the next, which meet halfway between their
/// control points.
#[doc(hidden)]
pub fn spline_segments(points: &[SplinePoint]) -> impl Iterator<Item = TubeSegment> + '_ {
    let at = |i: usize| Vec3::from(points[i.min(points.len() - 1)].at);
    // A quarter of the tangent at a point.
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

/// A closed 2D path of lines and quadratic Bézier curves. If the last segment does not end at the start, a line
/// closes the path. The even-odd rule decides what lies inside.
///
/// Used by [`Shape::Extrusion`](crate::Shape::Extrusion) and [`Shape::Lathe`](crate::Shape::Lathe).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Path2 {
    /// Start of the path.
    pub start: [f32; 2],
    /// Segments, each from the end of the previous one.
    #[serde(alias = "pieces")]
    pub segments: Vec<PathSegment>,
}

/// A segment of a path: a line, or a curve if it has a control point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PathSegment {
    /// Control point of a quadratic Bézier curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control: Option<[f32; 2]>,
    /// End of the segment.
    pub to: [f32; 2],
}

impl Path2 {
    /// Creates a path that starts at a point.
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

    /// Appends a line to a point.
    #[must_use]
    pub fn line(mut self, to: [f32; 2]) -> Self {
        self.segments.push(PathSegment { control: None, to });
        self
    }

    /// Appends a quadratic Bézier curve to a point.
    #[must_use]
    pub fn curve(mut self, control: [f32; 2], to: [f32; 2]) -> Self {
        let control = Some(control);
        self.segments.push(PathSegment { control, to });
        self
    }

    /// Returns the path with all coordinates multiplied by a factor.
    pub(crate) fn scaled(self, factor: f32) -> Self {
        let scaled = |at: [f32; 2]| at.map(|x| factor * x);
        let segments = self.segments.into_iter().map(|segment| PathSegment {
            control: segment.control.map(scaled),
            to: scaled(segment.to),
        });
        Self {
            start: scaled(self.start),
            segments: segments.collect(),
        }
    }

    /// Returns the corners of a box around the path's points and control points.
    pub fn bounds(&self) -> (Vec2, Vec2) {
        let points = self
            .segments()
            .flat_map(|(a, b, c)| [a, b.unwrap_or(c), c])
            .map(Vec2::from);
        points.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(lo, hi), p| {
            (lo.min(p), hi.max(p))
        })
    }

    /// Iterates over the start, control point and end of each segment, including the closing line. A line has no
    /// control point.
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
