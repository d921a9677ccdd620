//! Ramps: values that change along a line, or with the distance from the y axis.

use crate::ValidationError;
use crate::validation::{coordinate, each, not_negative};
use glam::{DVec3, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Maximum cubic pieces of a curve.
const MAX_PIECES: usize = 256;
/// Maximum of a curve's coefficients.
const MAX_COEFFICIENT: f32 = 1e4;
/// Largest step between two pieces that counts as none.
const MAX_STEP: f32 = 1e-3;

/// A curve over the interval from 0 to 1: cubic pieces of equal length, without steps between them. Each piece holds
/// the coefficients c of c₀ + c₁u + c₂u² + c₃u³, where u goes from 0 to 1 along the piece.
///
/// ```
/// use argil_scene::Curve;
/// let squared = Curve::from_fn(1, |t| t * t);
/// assert!((squared.value(0.5) - 0.25).abs() < 1e-6);
/// assert!(Curve::linear().check("curve").is_ok());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[cfg_attr(feature = "schema", schemars(with = "Vec<[f32; 4]>"))]
#[serde(from = "Vec<[f32; 4]>", into = "Vec<[f32; 4]>")]
#[doc(alias = "easing")]
pub struct Curve(Arc<[[f32; 4]]>);

impl From<Vec<[f32; 4]>> for Curve {
    fn from(pieces: Vec<[f32; 4]>) -> Self {
        Self(pieces.into())
    }
}

impl From<Curve> for Vec<[f32; 4]> {
    fn from(curve: Curve) -> Self {
        curve.0.to_vec()
    }
}

impl Default for Curve {
    fn default() -> Self {
        Self::linear()
    }
}

impl Curve {
    /// Creates the straight line from 0 to 1.
    pub fn linear() -> Self {
        vec![[0.0, 1.0, 0.0, 0.0]].into()
    }

    /// Creates the curve of a function on the interval from 0 to 1. Each piece passes through four points of it.
    pub fn from_fn(pieces: usize, f: impl Fn(f64) -> f64) -> Self {
        let count = pieces.max(1);
        let piece = |index: usize| {
            let at = |third: usize| f((index as f64 + third as f64 / 3.0) / count as f64);
            let [a, b, c, d] = [at(0), at(1), at(2), at(3)];
            // Newton's differences, for points that are a third apart.
            let (one, two, three) = (b - a, c - 2.0 * b + a, d - 3.0 * c + 3.0 * b - a);
            [
                a,
                3.0 * one - 1.5 * two + three,
                4.5 * two - 4.5 * three,
                4.5 * three,
            ]
            .map(|c| c as f32)
        };
        (0..count).map(piece).collect::<Vec<_>>().into()
    }

    /// Returns the pieces.
    pub fn pieces(&self) -> &[[f32; 4]] {
        &self.0
    }

    /// Returns the value at a place from 0 to 1.
    pub fn value(&self, t: f64) -> f64 {
        let along = t.clamp(0.0, 1.0) * self.0.len() as f64;
        let index = (along as usize).min(self.0.len().saturating_sub(1));
        let u = along - index as f64;
        let [a, b, c, d] = self
            .0
            .get(index)
            .map_or([0.0; 4], |coefficients| coefficients.map(f64::from));
        a + u * (b + u * (c + u * d))
    }

    /// Returns the smallest and the largest value.
    pub fn range(&self) -> [f32; 2] {
        let extremes = |&[a, b, c, d]: &[f32; 4]| {
            let value = move |u: f32| a + u * (b + u * (c + u * d));
            // Where the slope b + 2cu + 3du² is 0.
            let root = (c * c - 3.0 * b * d).max(0.0).sqrt();
            let flat = [
                (-c + root) / (3.0 * d),
                (-c - root) / (3.0 * d),
                -b / (2.0 * c),
            ];
            let inner = flat
                .into_iter()
                .filter(|u| (0.0..1.0).contains(u))
                .map(value);
            inner.chain([value(0.0), value(1.0)]).collect::<Vec<_>>()
        };
        span(self.0.iter().flat_map(extremes))
    }

    /// Returns the smallest and the largest slope.
    pub fn slopes(&self) -> [f32; 2] {
        let count = self.0.len() as f32;
        let extremes = move |&[_, b, c, d]: &[f32; 4]| {
            let slope = move |u: f32| (b + u * (2.0 * c + u * 3.0 * d)) * count;
            let turn = -c / (3.0 * d);
            let inner = Some(turn).filter(|u| (0.0..1.0).contains(u)).map(slope);
            inner
                .into_iter()
                .chain([slope(0.0), slope(1.0)])
                .collect::<Vec<_>>()
        };
        span(self.0.iter().flat_map(extremes))
    }

    /// Checks the number of pieces and their coefficients, and that there is no step between two.
    ///
    /// # Errors
    /// The first piece that is not valid, with `path` in front.
    pub fn check(&self, path: &str) -> Result<(), ValidationError> {
        let count = self.0.len();
        if !(1..=MAX_PIECES).contains(&count) {
            let reason = format!("{count} pieces are not from 1 to {MAX_PIECES}");
            return Err(ValidationError::new(path, reason));
        }
        for (index, piece) in self.0.iter().enumerate() {
            let is_number = |c: &f32| c.abs() <= MAX_COEFFICIENT;
            if !piece.iter().all(is_number) {
                let reason =
                    format!("has coefficients that are not numbers up to {MAX_COEFFICIENT}");
                return Err(ValidationError::new(format!("{path}[{index}]"), reason));
            }
            let end: f32 = piece.iter().sum();
            if let Some(&[next, ..]) = self.0.get(index + 1)
                && (next - end).abs() > MAX_STEP
            {
                let reason = format!(
                    "ends at {end}, and the next piece begins at {next}: steps are not supported"
                );
                return Err(ValidationError::new(format!("{path}[{index}]"), reason));
            }
        }
        Ok(())
    }
}

fn span(values: impl Iterator<Item = f32>) -> [f32; 2] {
    values.fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], v| {
        [lo.min(v), hi.max(v)]
    })
}

/// A value that follows a curve along a line, or with the distance from the y axis. It is constant before the start
/// and after the end.
///
/// ```
/// use argil_scene::{Curve, Ramp};
/// let up = Ramp::Line { from: [0.0; 3], to: [0.0, 2.0, 0.0], curve: Curve::linear() };
/// assert_eq!(up.value([5.0, 1.0, 0.0].into()), 0.5);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Ramp {
    /// Along the line between two points.
    Line {
        /// The start.
        from: [f32; 3],
        /// The end.
        to: [f32; 3],
        /// Its values from start to end.
        #[serde(default)]
        curve: Curve,
    },
    /// With the distance from the y axis.
    Radius {
        /// The distance at the start.
        from: f32,
        /// The distance at the end, which may be smaller.
        to: f32,
        /// Its values from start to end.
        #[serde(default)]
        curve: Curve,
    },
}

impl Ramp {
    /// Returns the curve.
    pub fn curve(&self) -> &Curve {
        let (Self::Line { curve, .. } | Self::Radius { curve, .. }) = self;
        curve
    }

    /// Returns the value at a point.
    pub fn value(&self, point: DVec3) -> f64 {
        self.curve().value(self.place(point))
    }

    fn place(&self, p: DVec3) -> f64 {
        match *self {
            Self::Line { from, to, .. } => {
                let (start, end) = (Vec3::from(from).as_dvec3(), Vec3::from(to).as_dvec3());
                let line = end - start;
                (p - start).dot(line) / line.length_squared()
            }
            Self::Radius { from, to, .. } => {
                (p.x.hypot(p.z) - f64::from(from)) / (f64::from(to) - f64::from(from))
            }
        }
    }

    /// Returns the length over which the value changes.
    fn length(&self) -> f32 {
        match *self {
            Self::Line { from, to, .. } => Vec3::from(from).distance(to.into()),
            Self::Radius { from, to, .. } => (to - from).abs(),
        }
    }

    /// Returns the largest change of the value per unit of length.
    pub fn steepness(&self) -> f32 {
        let [low, high] = self.curve().slopes();
        low.abs().max(high.abs()) / self.length()
    }

    /// Returns the largest factor by which moving points by `by` times the value stretches a length.
    ///
    /// The derivative is I − e′ · by ⊗ n with the ramp's direction n. In the plane of both vectors, its singular
    /// values follow from its trace and its determinant.
    pub(crate) fn shift_stretch(&self, by: [f32; 3]) -> f32 {
        let by = Vec3::from(by).as_dvec3();
        let (along, against) = match *self {
            Self::Line { from, to, .. } => {
                let along = by.dot((Vec3::from(to) - Vec3::from(from)).as_dvec3().normalize());
                (along, along)
            }
            // In any level direction.
            Self::Radius { .. } => (by.x.hypot(by.z), -by.x.hypot(by.z)),
        };
        let per_length = 1.0 / f64::from(self.length());
        let of_slope = |slope: f64| {
            let part = move |along: f64| {
                let (along, squared) = (
                    -slope * along * per_length,
                    (slope * per_length).powi(2) * by.length_squared(),
                );
                let (trace, determinant) = (2.0 + 2.0 * along + squared, (1.0 + along).powi(2));
                let root = (trace * trace - 4.0 * determinant).max(0.0).sqrt();
                (0.5 * (trace + root)).sqrt()
            };
            part(along).max(part(against))
        };
        let [low, high] = self.curve().slopes().map(f64::from);
        of_slope(low).max(of_slope(high)).max(1.0) as f32
    }

    /// Returns the heap bytes.
    pub(crate) fn heap_bytes(&self) -> usize {
        size_of_val(self.curve().pieces())
    }
}

/// Checks a ramp.
pub(crate) fn ramp(path: &str, ramp: &Ramp) -> Result<(), ValidationError> {
    let name = match ramp {
        Ramp::Line { from, to, .. } => {
            each(&format!("{path}.line.from"), *from, coordinate)?;
            each(&format!("{path}.line.to"), *to, coordinate)?;
            "line"
        }
        Ramp::Radius { from, to, .. } => {
            not_negative(&format!("{path}.radius.from"), *from)?;
            not_negative(&format!("{path}.radius.to"), *to)?;
            "radius"
        }
    };
    if ramp.length() < 1e-6 {
        let reason = "start and end coincide";
        return Err(ValidationError::new(format!("{path}.{name}.to"), reason));
    }
    ramp.curve().check(&format!("{path}.{name}.curve"))
}

/// Checks a curve.
pub(crate) fn curve(path: &str, curve: &Curve) -> Result<(), ValidationError> {
    curve.check(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_passes_through_its_function_and_bounds_it() {
        let f = |t: f64| (7.0 * t).sin() + t * t;
        let curve = Curve::from_fn(16, f);
        let [low, high] = curve.range().map(f64::from);
        let [down, up] = curve.slopes().map(f64::from);
        let mut last = f(0.0);
        for i in 1..=1000 {
            let t = f64::from(i) / 1000.0;
            let value = curve.value(t);
            assert!((value - f(t)).abs() < 1e-4, "{t}: {value}");
            assert!(value >= low - 1e-6 && value <= high + 1e-6, "{t}");
            let slope = (value - last) * 1000.0;
            assert!(slope >= down - 0.05 && slope <= up + 0.05, "{t}: {slope}");
            last = value;
        }
        assert!(low > -1.0 && high < 2.0 && down > -7.5 && up < 9.0);
    }

    #[test]
    fn steps_are_refused() {
        let stepped: Curve = vec![[0.0; 4], [1.0, 0.0, 0.0, 0.0]].into();
        let error = stepped.check("curve").expect_err("a step");
        assert!(error.to_string().contains("begins at 1"), "{error}");
        assert!(Curve::from(Vec::new()).check("curve").is_err());
        assert!(Curve::from(vec![[f32::NAN; 4]]).check("curve").is_err());
    }

    #[test]
    fn no_pair_of_points_is_stretched_by_more_than_the_bound() {
        for (by, to) in [
            ([0.0, 1.0, 0.0], [2.0, 0.0, 0.0]),
            ([0.5, 0.2, 0.0], [1.0, 1.0, 0.3]),
            ([1.5, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ] {
            let curve = Curve::from_fn(2, |t| t * t * (3.0 - 2.0 * t));
            let from = [0.0; 3];
            let ramp = Ramp::Line { from, to, curve };
            let bound = f64::from(ramp.shift_stretch(by));
            let by = Vec3::from(by).as_dvec3();
            let moved = |p: DVec3| p - by * ramp.value(p);
            let mut greatest = 0.0f64;
            let mut state = 1u32;
            let mut random = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state >> 8) / f64::from(1 << 24)
            };
            for _ in 0..20_000 {
                let p = DVec3::new(random(), random(), random()) * 2.0 - 0.5;
                let away = DVec3::new(random(), random(), random()) - 0.5;
                let q = p + 1e-4 * away;
                greatest = greatest.max(moved(p).distance(moved(q)) / p.distance(q).max(1e-9));
            }
            assert!(
                greatest <= bound * 1.001 && greatest > 0.8 * bound,
                "{greatest} {bound}"
            );
        }
    }
}
