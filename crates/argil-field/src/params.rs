//! Packs a shape's parameters into the words that both interpreters read.

use crate::dispatch::op;
use argil_math::Aabb;
use argil_scene::{
    Path2, Shape, ShapeParameter, SplinePoint, shape_table, spline_segments, text_outlines,
};
use glam::{Vec2, Vec3};

/// The words of a table row.
trait Words {
    /// Appends the words.
    fn append_to(self, words: &mut Vec<f32>);
}

impl<const N: usize> Words for [f32; N] {
    fn append_to(self, words: &mut Vec<f32>) {
        words.extend(self);
    }
}

impl Words for Vec<f32> {
    fn append_to(self, words: &mut Vec<f32>) {
        words.extend(self);
    }
}

impl Words for &[f32] {
    fn append_to(self, words: &mut Vec<f32>) {
        words.extend_from_slice(self);
    }
}

macro_rules! packing {
    (
        plain {$(
            $(#[$doc:meta])*
            $shape:ident($function:ident) {$(
                $(#[$about:meta])*
                $field:ident: $type:ty => $check:ident $(($($limit:expr),*))?,
            )*}
            $(rule($rule:expr))?
            words($words:expr)
            bounds($bounds:expr)
            exact($exact:expr)
            example($example:expr);
        )*}
        searched {$(
            $(#[$searched_doc:meta])*
            $searched:ident($searched_function:ident, $loops:ident) {$(
                $(#[$searched_about:meta])*
                $searched_field:ident: $searched_type:ty => $searched_check:ident $(($($searched_limit:expr),*))?,
            )*}
            $(rule($searched_rule:expr))?
            words($searched_words:expr)
            bounds($searched_bounds:expr)
            exact($searched_exact:expr)
            example($searched_example:expr);
        )*}
    ) => {
        /// Returns the shape's opcode, and appends its words. A searched shape's words follow its box.
        #[allow(unused_variables, reason = "not every shape packs all of its parameters")]
        pub(crate) fn pack(shape: &Shape, words: &mut Vec<f32>) -> u32 {
            match shape {
                $(Shape::$shape { $($field),* } => {
                    $(let $field = $field.read();)*
                    $words.append_to(words);
                    op::$shape
                })*
                $(Shape::$searched { $($searched_field),* } => {
                    let held = shape.aabb();
                    words.extend([held.min.to_array(), held.max.to_array()].concat());
                    $(let $searched_field = $searched_field.read();)*
                    $searched_words.append_to(words);
                    op::$searched
                })*
            }
        }
    };
}

shape_table!(packing);

fn rim_radius(radius: f32, cut: f32) -> f32 {
    (radius * radius - cut * cut).max(0.0).sqrt()
}

/// Returns half of each side of the box, radians per length, the reciprocal of the largest slope, and half of the
/// thickness. A sum of products of one sine and one cosine each, or of three cosines, has slope up to √3 per
/// radian.
fn sheet_words([x, y, z]: [f32; 3], period: f32, thickness: f32) -> [f32; 6] {
    let rate = std::f32::consts::TAU / period;
    [x, y, z, rate, 1.0 / (3f32.sqrt() * rate), 0.5 * thickness]
}

/// Returns the semi-axes, their reciprocals, both exponents and their reciprocals, and the radius of an inscribed
/// sphere. With exponents of 2 or more, the solid contains the ellipsoid of its axes, and otherwise their
/// octahedron.
fn superellipsoid_words(radii: [f32; 3], [n, m]: [f32; 2]) -> [f32; 11] {
    let r = Vec3::from(radii);
    let inverse = r.recip();
    let held = if n.min(m) >= 2.0 {
        r.min_element()
    } else {
        1.0 / inverse.length()
    };
    let ([a, b, c], [x, y, z]) = (radii, inverse.to_array());
    [a, b, c, x, y, z, m, n, 1.0 / m, 1.0 / n, held]
}

/// Returns a quadratic curve's coefficients, the radius at its start, and its change.
fn tube_words([from, control, to]: [[f32; 3]; 3], [from_radius, to_radius]: [f32; 2]) -> [f32; 11] {
    let (a, b, c) = (Vec3::from(from), Vec3::from(control), Vec3::from(to));
    let (linear, quadratic) = ((b - a) * 2.0, a - 2.0 * b + c);
    [
        a.x,
        a.y,
        a.z,
        linear.x,
        linear.y,
        linear.z,
        quadratic.x,
        quadratic.y,
        quadratic.z,
        from_radius,
        to_radius - from_radius,
    ]
}

/// Returns the number of segments, and the box and the curve of each.
fn spline_words(points: &[SplinePoint]) -> Vec<f32> {
    let mut words = vec![2.0 * (points.len() - 1) as f32];
    for ([a, b, c], radii) in spline_segments(points) {
        let held = Aabb::around([a, b, c]).grown(radii[0].max(radii[1]));
        words.extend([held.min.to_array(), held.max.to_array()].concat());
        words.extend(tube_words([a, b, c].map(|p| p.to_array()), radii));
    }
    words
}

/// Returns the number of segments, half of the length along z, and the segments.
fn outline_words(outline: &Path2, half_depth: f32, is_lathe: bool) -> Vec<f32> {
    let mut words = vec![0.0, half_depth];
    words[0] = pack_outline(outline, is_lathe, &mut words) as f32;
    words
}

/// Returns half sizes, height, base, and the ratio of the shortest to the vertical way to the surface, followed by
/// the grid's words.
fn heightmap_words(grid: &[f32], [x, z]: [f32; 2], [height, base]: [f32; 2]) -> Vec<f32> {
    let &[along_x, along_z, _, _, nx, _, nz, ..] = grid else {
        return Vec::new();
    };
    let slopes = [
        height * along_x * (nx - 1.0) / (2.0 * x),
        height * along_z * (nz - 1.0) / (2.0 * z),
    ];
    let steepest = slopes.iter().map(|slope| slope * slope).sum::<f32>();
    // A little less, for rounding.
    let share = 0.999_9 / (1.0 + steepest).sqrt();
    let mut words = vec![x, z, height, base, share];
    words.extend_from_slice(grid);
    words
}

/// Returns the words of a text's paths, like those of a path.
fn text_words(text: &str, size: f32, half_depth: f32) -> Vec<f32> {
    let mut words = vec![0.0, half_depth];
    let outlines = text_outlines(text, size);
    let counts = outlines
        .iter()
        .map(|outline| pack_outline(outline, false, &mut words));
    words[0] = counts.sum::<usize>() as f32;
    words
}

/// Appends the segments, each as kind (0 for a line, 1 for a curve), start, control, end, and a spare word. Curves
/// are cut where they turn in y, so that a horizontal line crosses each at most once. They are also cut where they
/// turn by more than 45 degrees, so that each has at most one nearest point inside. Segments on a lathe's axis are
/// not part of its surface.
fn pack_outline(outline: &Path2, is_lathe: bool, words: &mut Vec<f32>) -> usize {
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
            // Flat at the turn: the controls' heights equal the turn's.
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

/// Halves a curve, up to five times, until the directions at its ends differ by less than 45 degrees.
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

/// Cuts a quadratic curve (de Casteljau).
fn cut([a, b, c]: [Vec2; 3], t: f32) -> [[Vec2; 3]; 2] {
    let (left, right) = (a.lerp(b, t), b.lerp(c, t));
    let middle = left.lerp(right, t);
    [[a, left, middle], [middle, right, c]]
}
