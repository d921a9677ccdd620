use crate::shape::ShapeParameter;
use crate::shape_checks as rules;
use crate::{Curve, Pose, Poses, Ramp, ValidationError};
use argil_math::Aabb;
use glam::{DAffine3, DQuat, DVec3, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Generates [`Modifier`] from a table. Each row has parameters with checks, a rule between parameters, and an
/// example. Other files define how a modifier changes boxes ([`Extents`](crate::Extents)), distances
/// (`regularity.rs` of argil-field), instructions (`lower/solid.rs`), and the oracle.
macro_rules! modifiers {
    ($(
        $(#[$doc:meta])*
        $modifier:ident {$(
            $(#[$about:meta])*
            $field:ident: $type:ty => $check:ident $(($($limit:expr),*))?,
        )*}
        $(rule($rule:expr))?
        example($example:expr);
    )*) => {
        /// A transform or a deformation. A node's modifiers act in order: the first on the solid itself, and the
        /// next on its result.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(JsonSchema))]
        #[serde(
            tag = "type",
            rename_all = "snake_case",
            deny_unknown_fields,
            expecting = "an object with a \"type\""
        )]
        pub enum Modifier {$(
            $(#[$doc])*
            $modifier {$(
                $(#[$about])*
                $field: $type,
            )*},
        )*}

        impl Modifier {
            /// Checks that every parameter is in its range.
            ///
            /// # Errors
            /// The first parameter that is out of range.
            pub fn check(&self) -> Result<(), ValidationError> {
                match self {$(
                    Self::$modifier { $($field),* } => {
                        $(let $field = $field.read();)*
                        $(rules::$check(stringify!($field), $field $($(, $limit)*)?)?;)*
                        $($rule?;)?
                        Ok(())
                    }
                )*}
            }

            /// Returns the heap bytes of the modifier.
            pub(crate) fn heap_bytes(&self) -> usize {
                match self {$(
                    Self::$modifier { $($field),* } => 0 $(+ $field.heap_bytes())*,
                )*}
            }

            /// Returns the name of the modifier: the variant's name.
            ///
            /// ```
            /// let modifier = argil_scene::Modifier::Round { radius: 0.1 };
            /// assert_eq!(modifier.kind(), "Round");
            /// ```
            pub fn kind(&self) -> &'static str {
                match self {$(
                    Self::$modifier { .. } => stringify!($modifier),
                )*}
            }

            /// Returns an example of each modifier, in the order of the table, as an editor inserts it.
            ///
            /// ```
            /// let examples = argil_scene::Modifier::examples();
            /// assert!(examples.iter().all(|modifier| modifier.check().is_ok()));
            /// ```
            pub fn examples() -> Vec<Self> {
                vec![$($example),*]
            }
        }
    };
}

modifiers! {
    /// Translates.
    Translate {
        /// Translation along each axis.
        by: [f32; 3] => coordinate,
    }
    example(Self::Translate { by: [0.0; 3] });

    /// Rotates about an axis through the origin, counterclockwise when the axis points at the viewer.
    Rotate {
        /// The axis, of any length but 0.
        axis: [f32; 3] => direction,
        /// The angle in degrees.
        degrees: f32 => coordinate,
    }
    example(Self::Rotate { axis: [0.0, 1.0, 0.0], degrees: 0.0 });

    /// Scales about the origin, by the same factor along all axes.
    Scale {
        /// The factor, from 1e-4 to 1e4.
        by: f32 => within(1e-4, 1e4),
    }
    example(Self::Scale { by: 1.0 });

    /// Scales about the origin, by a factor per axis. The distance becomes a lower bound: the solid's distance
    /// times the smallest factor.
    Stretch {
        /// The factors, from 1e-3 to 1e3 each.
        by: [f32; 3] => within(1e-3, 1e3),
    }
    example(Self::Stretch { by: [1.0; 3] });

    /// Cuts the solid at the origin, keeps the positive side, and adds its mirror image, along each selected axis.
    Mirror {
        /// The axes to mirror.
        axes: [bool; 3] => any,
    }
    example(Self::Mirror { axes: [true, false, false] });

    /// Repeats on a grid that is centered on the origin. The solid should stay within its cell; if it does not, up
    /// to 125 copies are evaluated per point.
    Repeat {
        /// Distance between copies along each axis; 0 for an axis without copies, whose count is then 1.
        spacing: [f32; 3] => not_negative,
        /// Number of copies along each axis. Infinite if it is missing.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        count: Option<[u32; 3]> => counts(1, 1_000_000),
    }
    rule(rules::steps(spacing, count))
    example(Self::Repeat { spacing: [1.5, 0.0, 0.0], count: Some([3, 1, 1]) });

    /// Repeats around the y axis at equal angles. The solid belongs on the +x side.
    RadialRepeat {
        /// Number of copies.
        count: u32 => count(1, 10_000),
    }
    example(Self::RadialRepeat { count: 6 });

    /// Copies the solid to many poses, up to a million. A copy of a brush takes about 130 bytes. Copies of a group share its
    /// parameters, and each takes 16 bytes for each of its brushes and about 200 more.
    #[doc(alias = "scatter")]
    Instances {
        /// The pose of each copy: position, rotation about the y axis in degrees, and scale.
        poses: Poses => poses,
    }
    example(Self::Instances {
        poses: [[0.0, 0.0, 0.0, 0.0, 1.0], [1.5, 0.0, 0.5, 40.0, 0.7]].map(Pose::from).to_vec().into(),
    });

    /// Cuts the solid at the origin and pulls the halves apart along each axis.
    Elongate {
        /// Half of the inserted length per axis.
        by: [f32; 3] => not_negative,
    }
    example(Self::Elongate { by: [0.2, 0.0, 0.0] });

    /// Moves the surface outward, which rounds edges, or inward by a negative distance.
    #[doc(alias = "offset")]
    #[doc(alias = "dilate")]
    #[doc(alias = "erode")]
    Round {
        /// The distance.
        radius: f32 => coordinate,
    }
    example(Self::Round { radius: 0.05 });

    /// Keeps only a shell around the surface.
    #[doc(alias = "onion")]
    #[doc(alias = "hollow")]
    Shell {
        /// Half the thickness of the shell: the surface moves by this distance to both sides.
        #[serde(alias = "thickness")]
        half_thickness: f32 => positive,
    }
    example(Self::Shell { half_thickness: 0.03 });

    /// Rotates about the y axis by an angle that grows with y.
    Twist {
        /// Degrees per unit of length.
        degrees_per_unit: f32 => within(-1e5, 1e5),
    }
    example(Self::Twist { degrees_per_unit: 45.0 });

    /// Rotates in the x–y plane by an angle that grows with x.
    Bend {
        /// Degrees per unit of length.
        degrees_per_unit: f32 => within(-1e5, 1e5),
    }
    example(Self::Bend { degrees_per_unit: 30.0 });

    /// Translates each point of the solid by a share of a vector that follows a ramp, as for a shear or the curve of
    /// a letter S.
    #[doc(alias = "shear")]
    Shift {
        /// The translation where the ramp's value is 1.
        by: [f32; 3] => coordinate,
        /// The share of it at each place.
        along: Ramp => ramp,
    }
    example(Self::Shift {
        by: [0.0, 0.3, 0.0],
        along: Ramp::Line {
            from: [-0.5, 0.0, 0.0],
            to: [0.5, 0.0, 0.0],
            curve: Curve::from_fn(1, |t| t * t * (3.0 - 2.0 * t)),
        },
    });

    /// Wraps the solid around the y axis: the part between two places on the x axis becomes a full turn, counterclockwise
    /// seen from above, from −x on. Its z becomes the distance outward from the radius. What is beyond the two places goes on
    /// around the axis. Near the axis, the solid is cut off.
    #[doc(alias = "roll")]
    Wrap {
        /// Where the turn begins on the x axis.
        from: f32 => coordinate,
        /// Where the turn ends on the x axis.
        to: f32 => coordinate,
        /// Distance from the axis at which z is 0.
        radius: f32 => positive,
        /// How the place on the x axis follows the angle.
        #[serde(default)]
        curve: Curve => curve,
    }
    rule(rules::apart("to", from, to))
    example(Self::Wrap { from: -1.57, to: 1.57, radius: 0.5, curve: Curve::linear() });

    /// Extrudes the section of the solid at z = 0 along z.
    Extrude {
        /// Half of the length along z. An extrusion of 1e6 or more is infinite.
        half_depth: f32 => positive,
    }
    example(Self::Extrude { half_depth: 0.2 });

    /// Revolves the section of the solid at z = 0 about the y axis. Its part at x < −offset is cut off.
    #[doc(alias = "lathe")]
    Revolve {
        /// Distance from the axis to the section's own origin.
        offset: f32 => coordinate,
    }
    example(Self::Revolve { offset: 0.5 });

    /// Scales distances without moving the surface. Blends and offsets measure distances, so a solid whose distances are
    /// divided, such as a twisted one, blends evenly with an exact solid whose distances are scaled by the same factor.
    ScaleDistance {
        /// The factor, from 1e-4 to 1. Rays take more steps where it is small.
        by: f32 => within(1e-4, 1.0),
    }
    example(Self::ScaleDistance { by: 0.5 });

    /// Moves the surface in and out by value noise. Each octave has half the amplitude and twice the frequency of
    /// the one before.
    Displace {
        /// Maximum displacement of the first octave.
        amplitude: f32 => not_negative,
        /// Noise cells of the first octave per unit of length.
        frequency: f32 => within(1e-4, 1e4),
        /// Seed of the noise.
        #[serde(default)]
        seed: u32 => any,
        /// Number of octaves, from 1 to 8.
        #[serde(default = "one")]
        octaves: u32 => count(1, 8),
    }
    example(Self::Displace { amplitude: 0.05, frequency: 4.0, seed: 0, octaves: 3 });
}

fn one() -> u32 {
    1
}

/// The steepest slope of value noise in [−1, 1] on a unit grid with the fade 6t⁵ − 15t⁴ + 10t³. Along a grid edge
/// from −1 to 1, it is twice the fade's slope of 15/8 at its middle.
pub(crate) const NOISE_LIPSCHITZ: f32 = 3.75;

impl Modifier {
    /// Whether the modifier preserves angles: translate, rotate or scale.
    pub fn is_similarity(&self) -> bool {
        matches!(
            self,
            Self::Translate { .. } | Self::Rotate { .. } | Self::Scale { .. }
        )
    }

    /// Returns the map from the modified frame to the solid's own frame, for translate, rotate, scale and stretch, and for a scale
    /// of distances only.
    pub fn affine(&self) -> Option<DAffine3> {
        match *self {
            Self::Translate { by } => Some(DAffine3::from_translation(-Vec3::from(by).as_dvec3())),
            Self::Rotate { axis, degrees } => {
                let axis = Vec3::from(axis).as_dvec3().normalize();
                Some(DAffine3::from_quat(DQuat::from_axis_angle(
                    axis,
                    -f64::from(degrees).to_radians(),
                )))
            }
            Self::Scale { by } => Some(DAffine3::from_scale(DVec3::splat(1.0 / f64::from(by)))),
            Self::Stretch { by } => Some(DAffine3::from_scale(Vec3::from(by).as_dvec3().recip())),
            Self::ScaleDistance { .. } => Some(DAffine3::IDENTITY),
            _ => None,
        }
    }

    /// Returns the factor by which distances grow: the factor of a scale, the smallest of a stretch, and 1 otherwise.
    /// Lengths grow at least by it.
    pub fn scale(&self) -> f32 {
        match *self {
            Self::Scale { by } | Self::ScaleDistance { by } => by,
            Self::Stretch { by } => Vec3::from(by).min_element(),
            _ => 1.0,
        }
    }
}

/// Up to this many overlapping copies with bounded distances are all evaluated, so that nothing jumps.
pub(crate) const FEW_COPIES: u64 = 16;

/// Returns half of the angle about the y axis, measured from +x, that a box covers.
pub fn half_angle_about_y(content: Aabb) -> f32 {
    if !content.is_finite() || content.min.x <= 0.0 {
        return std::f32::consts::PI;
    }
    content
        .corners()
        .map(|c| c.z.atan2(c.x).abs())
        .into_iter()
        .fold(0.0, f32::max)
}

/// Returns how many copies to evaluate along one axis or ring, so that the nearest is among them, if the solid
/// reaches to `extent` from its cell's center. It is 2 for a solid within its cell: the point's own copy and the
/// nearest neighbor.
///
/// Copy n can contain the nearest point only if, among the images of the point, n's is nearest. Then |n · spacing|
/// ≤ spacing / 2 + extent + spacing / 2.
pub(crate) fn neighbor_copies(extent: f32, spacing: f32) -> u32 {
    if extent <= 0.5 * spacing {
        2
    } else {
        2 * (1.0 + extent / spacing).min(1e6) as u32 + 1
    }
}
