//! Paths of a font without overlaps: what the nonzero winding rule fills.
//!
//! Fonts draw strokes that cross, and islands inside of holes. Distances are exact only if each path is a part of the
//! border. So the sweep-line algorithm of `linesweeper` removes overlaps. It keeps quadratic curves.

use crate::{Path2, PathSegment};
use glam::Vec2;
use kurbo::{BezPath, PathEl, Point, Shape};
use linesweeper::topology::{Contour, Contours};
use linesweeper::{BinaryOp, FillRule, binary_op_with_eps};

/// A path of a border, and the number of paths around it: the inside of a path with an odd number is a hole.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct NestedPath {
    /// The path, which does not cross itself or others.
    pub path: Path2,
    /// The number of paths around it.
    pub depth: usize,
}

/// Returns the border of what paths fill by the nonzero winding rule, each path after the paths around it. Points move
/// by up to 1e-9 of the largest coordinate. Paths with a coordinate that is not finite fill nothing.
///
/// ```
/// use argil_scene::{Path2, nonzero_fill};
/// let square = |s: f32| Path2::new([-s, -s]).line([s, -s]).line([s, s]).line([-s, s]);
/// assert_eq!(nonzero_fill(&[square(2.0), square(1.0)]).len(), 1);
/// ```
#[doc(hidden)]
pub fn nonzero_fill(paths: &[Path2]) -> Vec<NestedPath> {
    let all: BezPath = paths.iter().flat_map(elements).collect();
    let points = paths
        .iter()
        .flat_map(Path2::segments)
        .flat_map(|(from, control, to)| [from, control.unwrap_or(to), to]);
    let largest = points.flatten().fold(0.0, |largest, x| {
        if largest < x.abs() || x.is_nan() {
            x.abs()
        } else {
            largest
        }
    });
    if !f32::is_finite(largest) {
        return Vec::new();
    }
    let accuracy = f64::from(largest) * 1e-9;
    let none = BezPath::new();
    let rule = FillRule::NonZero;
    binary_op_with_eps(&all, &none, rule, BinaryOp::Union, accuracy)
        .map(|contours| nested(&contours, accuracy * f64::from(largest)))
        .unwrap_or_default()
}

fn point([x, y]: [f32; 2]) -> Point {
    Point::new(f64::from(x), f64::from(y))
}

/// Returns the elements of a path and of the line that closes it.
fn elements(path: &Path2) -> impl Iterator<Item = PathEl> + '_ {
    let segments = path.segments().map(|(_, control, to)| match control {
        Some(control) => PathEl::QuadTo(point(control), point(to)),
        None => PathEl::LineTo(point(to)),
    });
    [PathEl::MoveTo(point(path.start))]
        .into_iter()
        .chain(segments)
        .chain([PathEl::ClosePath])
}

/// Sorts contours by the number of contours around them. Leaves out slivers, where edges coincided.
fn nested(contours: &Contours, sliver_area: f64) -> Vec<NestedPath> {
    let depth = |contour: &Contour| {
        let outer = |index| contours[index].parent;
        std::iter::successors(contour.parent, |&index| outer(index)).count()
    };
    let mut all: Vec<NestedPath> = contours
        .contours()
        .filter(|contour| contour.path.area().abs() > sliver_area)
        .map(|contour| NestedPath {
            path: path(&contour.path),
            depth: depth(contour),
        })
        .collect();
    all.sort_by_key(|nested| nested.depth);
    all
}

/// Returns a closed path in single precision, without segments that have no length there.
fn path(border: &BezPath) -> Path2 {
    let single = |p: Point| Vec2::new(p.x as f32, p.y as f32);
    let mut path = Path2::new([0.0; 2]);
    let mut at = Vec2::ZERO;
    for element in border.elements() {
        let (control, to) = match *element {
            PathEl::MoveTo(to) => {
                at = single(to);
                path.start = at.to_array();
                continue;
            }
            PathEl::ClosePath => continue,
            PathEl::LineTo(to) => (None, single(to)),
            PathEl::QuadTo(control, to) => (Some(single(control)), single(to)),
            // Sections of quadratic curves are quadratic.
            PathEl::CurveTo(first, second, to) => {
                let (start, to) = (at, single(to));
                let sum = 3.0 * (single(first) + single(second));
                (Some(0.25 * (sum - start - to)), to)
            }
        };
        if to != at || control.is_some_and(|control| control != at) {
            let control = control.map(|control| control.to_array());
            path.segments.push(PathSegment {
                control,
                to: to.to_array(),
            });
        }
        at = to;
    }
    path
}
