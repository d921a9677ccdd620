//! Checks and boxes for the rows of the [table of shapes](crate::shape_table).

use crate::path2::spline_segments;
use crate::validation::{self, ValidationError};
use crate::{LoadedGrid, MAX_LENGTH, Path2, SplinePoint};
use argil_math::Aabb;
use glam::{Vec2, Vec3};

pub(crate) use crate::pose::poses;
pub(crate) use crate::ramp::{curve, ramp};
pub(crate) use crate::sampled_grid::mesh_resolution;
pub(crate) use crate::text::{letters, text_bounds};
pub(crate) use validation::at_most;

/// Maximum segments of a path. Each one costs every evaluation of its shape.
const MAX_PIECES: usize = 256;

/// One number, or several of the same kind.
pub(crate) trait Components {
    /// Calls a check for each number, with its path.
    fn each(
        self,
        path: &str,
        check: impl Fn(&str, f32) -> Result<(), ValidationError>,
    ) -> Result<(), ValidationError>;
}

impl Components for f32 {
    fn each(
        self,
        path: &str,
        check: impl Fn(&str, f32) -> Result<(), ValidationError>,
    ) -> Result<(), ValidationError> {
        check(path, self)
    }
}

impl<const N: usize> Components for [f32; N] {
    fn each(
        self,
        path: &str,
        check: impl Fn(&str, f32) -> Result<(), ValidationError>,
    ) -> Result<(), ValidationError> {
        let mut all = self.into_iter().enumerate();
        all.try_for_each(|(i, value)| check(&format!("{path}[{i}]"), value))
    }
}

/// Checks lengths above 0.
pub(crate) fn positive(path: &str, value: impl Components) -> Result<(), ValidationError> {
    value.each(path, validation::positive)
}

/// Checks lengths of 0 or more.
pub(crate) fn not_negative(path: &str, value: impl Components) -> Result<(), ValidationError> {
    value.each(path, validation::not_negative)
}

/// Checks coordinates.
pub(crate) fn coordinate(path: &str, value: impl Components) -> Result<(), ValidationError> {
    value.each(path, validation::coordinate)
}

/// Checks numbers in a range, including both ends.
pub(crate) fn within(
    path: &str,
    value: impl Components,
    min: f32,
    max: f32,
) -> Result<(), ValidationError> {
    value.each(path, |path, value| {
        validation::within(path, value, min, max)
    })
}

/// Checks numbers up to a limit. `what` describes the limit.
pub(crate) fn each_at_most(
    path: &str,
    value: impl Components,
    limit: f32,
    what: &str,
) -> Result<(), ValidationError> {
    value.each(path, |path, value| at_most(path, value, limit, what))
}

/// Accepts anything that can be read.
#[expect(clippy::unnecessary_wraps, reason = "a check among others")]
pub(crate) fn any<T>(_: &str, _: T) -> Result<(), ValidationError> {
    Ok(())
}

/// Checks a direction, of any length but 0.
pub(crate) fn direction(path: &str, value: [f32; 3]) -> Result<(), ValidationError> {
    coordinate(path, value)?;
    if Vec3::from(value).length() < 1e-6 {
        return Err(ValidationError::new(path, "[0, 0, 0] has no direction"));
    }
    Ok(())
}

/// Checks a count in a range, including both ends.
pub(crate) fn count(path: &str, value: u32, min: u32, max: u32) -> Result<(), ValidationError> {
    validation::within(path, value, min, max)
}

/// Checks optional counts along each axis.
pub(crate) fn counts(
    path: &str,
    value: Option<[u32; 3]>,
    min: u32,
    max: u32,
) -> Result<(), ValidationError> {
    let mut all = value.into_iter().flatten().enumerate();
    all.try_for_each(|(axis, value)| count(&format!("{path}[{axis}]"), value, min, max))
}

/// Checks the steps of a repetition: several copies must not coincide.
pub(crate) fn steps(spacing: [f32; 3], count: Option<[u32; 3]>) -> Result<(), ValidationError> {
    for (axis, step) in spacing.into_iter().enumerate() {
        if count.map_or(step != 0.0, |count| count[axis] > 1) {
            validation::positive(&format!("spacing[{axis}]"), step)?;
        }
    }
    Ok(())
}

/// Checks that two places differ.
pub(crate) fn apart(path: &str, from: f32, to: f32) -> Result<(), ValidationError> {
    if (to - from).abs() < 1e-6 {
        return Err(ValidationError::new(path, "start and end coincide"));
    }
    Ok(())
}

/// Checks the samples of a mesh, if it is loaded.
pub(crate) fn distances(path: &str, grid: &LoadedGrid) -> Result<(), ValidationError> {
    match &grid.0 {
        Some(grid) if grid.has_heights() => {
            Err(ValidationError::new(path, "has heights, not distances"))
        }
        _ => Ok(()),
    }
}

/// Checks the heights of a heightmap, if it is loaded.
pub(crate) fn heights(path: &str, grid: &LoadedGrid) -> Result<(), ValidationError> {
    match &grid.0 {
        Some(grid) if !grid.has_heights() => {
            Err(ValidationError::new(path, "has distances, not heights"))
        }
        _ => Ok(()),
    }
}

/// Checks the path of a file.
pub(crate) fn path(path: &str, name: &str) -> Result<(), ValidationError> {
    if name.is_empty() {
        return Err(ValidationError::new(path, "names no file"));
    }
    Ok(())
}

/// Checks the path of an image file.
pub(crate) fn image_path(place: &str, name: &str) -> Result<(), ValidationError> {
    path(place, name)?;
    match is_image(name) {
        true => Ok(()),
        false => Err(ValidationError::new(
            place,
            format!("{name:?} is not a PNG image"),
        )),
    }
}

/// Whether a file name is that of a supported image.
pub fn is_image(name: &str) -> bool {
    let ending = name.rsplit_once('.').map(|(_, ending)| ending);
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case("png"))
}

/// Whether a file name is that of a grid of distances.
pub fn is_grid(name: &str) -> bool {
    let ending = name.rsplit_once('.').map(|(_, ending)| ending);
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case("grid"))
}

/// Checks the path of a mesh file.
pub(crate) fn mesh_path(place: &str, name: &str) -> Result<(), ValidationError> {
    path(place, name)?;
    match is_image(name) {
        true => Err(ValidationError::new(
            place,
            format!("{name:?} is an image, of a heightmap"),
        )),
        false => Ok(()),
    }
}

/// Checks the number of posts of a heightmap.
pub(crate) fn post_count(path: &str, value: u32) -> Result<(), ValidationError> {
    if (16..=crate::MAX_POSTS).contains(&value) {
        Ok(())
    } else {
        Err(ValidationError::new(
            path,
            format!("{value} is not from 16 to 2048"),
        ))
    }
}

/// Returns the box of a heightmap, empty if it is not loaded.
pub(crate) fn heightmap_bounds(
    grid: &LoadedGrid,
    [x, z]: [f32; 2],
    [height, base]: [f32; 2],
) -> Aabb {
    match &grid.0 {
        Some(grid) => {
            let top = height * grid.solid().max.y;
            Aabb::new(Vec3::new(-x, -base, -z), Vec3::new(x, top, z))
        }
        None => Aabb::EMPTY,
    }
}

/// Checks that a path to be revolved lies on one side of the axis.
pub(crate) fn beside_axis(outline: &Path2) -> Result<(), ValidationError> {
    let mut points = outline
        .segments()
        .flat_map(|(a, b, c)| [Some(a), b, Some(c)])
        .flatten();
    match points.find(|p| p[0] < 0.0) {
        Some(p) => Err(ValidationError::new(
            "outline",
            format!("{p:?} lies at a negative distance from the axis"),
        )),
        None => Ok(()),
    }
}

/// Checks that a periodic sheet leaves holes, and repeats so few times that angles are exact.
pub(crate) fn sheet_in_box(
    half_size: [f32; 3],
    period: f32,
    thickness: f32,
    share: f32,
) -> Result<(), ValidationError> {
    let limit = share * period;
    at_most("thickness", thickness, limit, &format!("{share} periods"))?;
    each_at_most("half_size", half_size, 100.0 * period, "a hundred periods")
}

/// Maximum points of a spline tube. Each one costs every evaluation of its shape.
const MAX_SPLINE_POINTS: usize = 128;

/// Checks the points of a spline tube.
pub(crate) fn spline(path: &str, points: &[SplinePoint]) -> Result<(), ValidationError> {
    let count = points.len();
    if !(2..=MAX_SPLINE_POINTS).contains(&count) {
        let reason = format!("{count} points are not from 2 to {MAX_SPLINE_POINTS}");
        return Err(ValidationError::new(path, reason));
    }
    for (i, point) in points.iter().enumerate() {
        coordinate(&format!("{path}[{i}].at"), point.at)?;
        positive(&format!("{path}[{i}].radius"), point.radius)?;
    }
    Ok(())
}

/// Returns the box of a spline tube: each segment lies in the hull of its three points.
pub(crate) fn spline_bounds(points: &[SplinePoint]) -> Aabb {
    let boxes =
        spline_segments(points).map(|(curve, [from, to])| Aabb::around(curve).grown(from.max(to)));
    boxes.fold(Aabb::EMPTY, |all, bounds| all.union(bounds))
}

/// Returns a box that is infinite along each side that ends at the largest length.
pub(crate) fn endless(solid: Aabb) -> Aabb {
    let is_end = |end: f32| end.abs() >= MAX_LENGTH;
    let extended = |end: Vec3| {
        end.to_array().map(|end| {
            if is_end(end) {
                end * f32::INFINITY
            } else {
                end
            }
        })
    };
    Aabb::new(extended(solid.min).into(), extended(solid.max).into())
}

/// Returns the box of a sphere.
pub(crate) fn enclosing_sphere_box(radius: f32) -> Aabb {
    Aabb::centered(Vec3::splat(radius))
}

/// Returns the box of a solid of revolution about y.
pub(crate) fn upright(radius: f32, min_y: f32, max_y: f32) -> Aabb {
    Aabb::new(
        Vec3::new(-radius, min_y, -radius),
        Vec3::new(radius, max_y, radius),
    )
}

/// Returns the box of a solid that is extruded along z.
pub(crate) fn along_z(half_size: Vec2, half_depth: f32) -> Aabb {
    Aabb::centered(half_size.extend(half_depth))
}

/// Returns the smallest of three numbers.
pub(crate) fn least(v: [f32; 3]) -> f32 {
    Vec3::from(v).min_element()
}

/// Returns the radius of the circle in which a plane cuts a sphere.
pub(crate) fn rim_radius(radius: f32, cut: f32) -> f32 {
    (radius * radius - cut * cut).max(0.0).sqrt()
}

/// Checks that a plane cuts a sphere.
pub(crate) fn cut_inside_sphere(radius: f32, cut: f32) -> Result<(), ValidationError> {
    if cut.abs() < radius * 0.9999 {
        Ok(())
    } else {
        Err(ValidationError::new(
            "cut",
            format!("{cut} does not cut a sphere of radius {radius}"),
        ))
    }
}

/// Returns the box of a half space.
pub(crate) fn half_space(normal: Vec3, offset: f32) -> Aabb {
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

/// Checks the points of a path: not too many, and around some area.
pub(crate) fn outline(path: &str, outline: &Path2) -> Result<(), ValidationError> {
    coordinate(&format!("{path}.start"), outline.start)?;
    for (i, piece) in outline.segments.iter().enumerate() {
        let at = format!("{path}.segments[{i}]");
        coordinate(&format!("{at}.to"), piece.to)?;
        if let Some(control) = piece.control {
            coordinate(&format!("{at}.control"), control)?;
        }
    }
    if outline.segments.len() > MAX_PIECES {
        let count = outline.segments.len();
        return Err(ValidationError::new(
            format!("{path}.segments"),
            format!("{count} segments, and the limit is {MAX_PIECES}"),
        ));
    }
    let (min, max) = outline.bounds();
    if (max - min).min_element() < 1e-6 {
        return Err(ValidationError::new(path, "the outline encloses no area"));
    }
    Ok(())
}
