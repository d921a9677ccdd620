use crate::ValidationError;
use crate::shape_checks as rules;
use argil_math::Aabb;
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Makes [`Modifier`] and what follows from each row: its parameters, with a check each, a rule that several have to keep together, and
/// an example. What else a modifier is stands by hand where it belongs: how boxes change ([`Extents`](crate::Extents)), how distances do
/// (`regular.rs` of argil-field), what instructions it takes (`lower/solid.rs`), and its definition for the oracle.
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
        /// A change of a solid or of the space around it. A list of modifiers acts in its order: the first on the solid
        /// itself, the next on what that made.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(JsonSchema))]
        #[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
        pub enum Modifier {$(
            $(#[$doc])*
            $modifier {$(
                $(#[$about])*
                $field: $type,
            )*},
        )*}

        impl Modifier {
            /// Whether every parameter can be used.
            ///
            /// # Errors
            /// The first that cannot.
            pub fn check(&self) -> Result<(), ValidationError> {
                match *self {$(
                    Self::$modifier { $($field),* } => {
                        $(rules::$check(stringify!($field), $field $($(, $limit)*)?)?;)*
                        $($rule?;)?
                        Ok(())
                    }
                )*}
            }

            /// What modifier it is: the variant's name.
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

            /// An example of each modifier, as it is added before anything of it is chosen, in the order of the rows.
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
    /// Move.
    Translate {
        /// By how much along each axis.
        by: [f32; 3] => coordinate,
    }
    example(Self::Translate { by: [0.0; 3] });

    /// Turn about an axis through the origin, counter-clockwise when the axis points at the viewer.
    Rotate {
        /// The axis; any length but 0.
        axis: [f32; 3] => direction,
        /// The angle.
        degrees: f32 => coordinate,
    }
    example(Self::Rotate { axis: [0.0, 1.0, 0.0], degrees: 0.0 });

    /// Scale about the origin, all axes alike.
    Scale {
        /// The factor, from 1e-4 to 1e4.
        by: f32 => within(1e-4, 1e4),
    }
    example(Self::Scale { by: 1.0 });

    /// Scale about the origin, each axis by a factor of its own. The distance is the solid's times the least factor: a bound, the more
    /// cautious the more the factors differ.
    Stretch {
        /// The factors, from 1e-3 to 1e3 each.
        by: [f32; 3] => within(1e-3, 1e3),
    }
    example(Self::Stretch { by: [1.0; 3] });

    /// Keep the part on the positive side of the origin and add its mirror image, for each axis chosen.
    Mirror {
        /// Which axes change sign.
        axes: [bool; 3] => any,
    }
    example(Self::Mirror { axes: [true, false, false] });

    /// Copies on a grid, centered on the origin. The solid should lie within its own cell; where it reaches beyond, up
    /// to 125 copies are looked at.
    Repeat {
        /// Distance between copies along each axis; 0 for an axis without copies.
        spacing: [f32; 3] => not_negative,
        /// How many along each axis; without it, endlessly.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        count: Option<[u32; 3]> => counts(1, 1_000_000),
    }
    rule(rules::steps(spacing, count))
    example(Self::Repeat { spacing: [1.5, 0.0, 0.0], count: Some([3, 1, 1]) });

    /// Copies turned about the y axis at equal angles. The solid belongs on the +x side.
    RadialRepeat {
        /// How many.
        count: u32 => count(1, 10_000),
    }
    example(Self::RadialRepeat { count: 6 });

    /// Cut the solid at the origin and pull the halves apart along each axis.
    Elongate {
        /// Half of the length put in, an axis.
        by: [f32; 3] => not_negative,
    }
    example(Self::Elongate { by: [0.2, 0.0, 0.0] });

    /// Move the surface outwards; edges become round.
    Round {
        /// By how much.
        radius: f32 => not_negative,
    }
    example(Self::Round { radius: 0.05 });

    /// Keep only a shell around the surface.
    Shell {
        /// Half of the shell's thickness.
        thickness: f32 => positive,
    }
    example(Self::Shell { thickness: 0.03 });

    /// Turn about the y axis by an angle that grows with y.
    Twist {
        /// Degrees for a length of 1.
        degrees_per_unit: f32 => within(-1e5, 1e5),
    }
    example(Self::Twist { degrees_per_unit: 45.0 });

    /// Turn in the x–y plane by an angle that grows with x.
    Bend {
        /// Degrees for a length of 1.
        degrees_per_unit: f32 => within(-1e5, 1e5),
    }
    example(Self::Bend { degrees_per_unit: 30.0 });

    /// Move the surface in and out by seeded value noise, octave upon octave of half the amplitude and twice the
    /// frequency.
    Displace {
        /// Greatest distance of the first octave.
        amplitude: f32 => not_negative,
        /// Cells of the first octave's lattice for a length of 1.
        frequency: f32 => within(1e-4, 1e4),
        /// Which noise.
        #[serde(default)]
        seed: u32 => any,
        /// How many octaves, from 1 to 8.
        #[serde(default = "one")]
        octaves: u32 => count(1, 8),
    }
    example(Self::Displace { amplitude: 0.05, frequency: 4.0, seed: 0, octaves: 3 });
}

fn one() -> u32 {
    1
}

/// The steepest slope of value noise in [−1, 1] on a unit lattice with the fade 6t⁵ − 15t⁴ + 10t³: along a lattice
/// edge between −1 and 1, twice the fade's slope of 15/8 in its middle.
pub(crate) const NOISE_LIPSCHITZ: f32 = 3.75;

impl Modifier {
    /// Whether it keeps angles: translate, rotate or scale.
    pub fn is_similarity(&self) -> bool {
        matches!(
            self,
            Self::Translate { .. } | Self::Rotate { .. } | Self::Scale { .. }
        )
    }

    /// The map from the modified solid's frame to the solid's own, for translate, rotate, scale and stretch.
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
            _ => None,
        }
    }

    /// The factor by which every length grows at least: that of a scale, the least of a stretch, else 1. Distances grow by it.
    pub fn scale(&self) -> f32 {
        match *self {
            Self::Scale { by } => by,
            Self::Stretch { by } => Vec3::from(by).min_element(),
            _ => 1.0,
        }
    }

    /// Where a twist or bend holds the points that it evaluates: a box around the deformed solid with a margin. `None`
    /// for other modifiers.
    pub fn clamp_box(&self, content: Aabb) -> Option<Aabb> {
        let farthest = |a: f32, b: f32| a.abs().max(b.abs());
        let (x, y, z) = (
            farthest(content.min.x, content.max.x),
            farthest(content.min.y, content.max.y),
            farthest(content.min.z, content.max.z),
        );
        let turned = match self {
            Self::Twist { .. } => {
                let r = Vec2::new(x, z).length();
                Aabb::new(
                    Vec3::new(-r, content.min.y, -r),
                    Vec3::new(r, content.max.y, r),
                )
            }
            Self::Bend { .. } => {
                let r = Vec2::new(x, y).length();
                Aabb::new(
                    Vec3::new(-r, -r, content.min.z),
                    Vec3::new(r, r, content.max.z),
                )
            }
            _ => return None,
        };
        // Without a margin the distance would be 0 on the box's own faces where the solid touches them.
        Some(turned.grown(0.05 * turned.half_diagonal()))
    }
}

/// How much a twist or bend inside `clamp_box` can stretch space: the largest singular value of its Jacobian.
///
/// A twist shears a point at radius r by a = rate · r, and a shear's largest singular value is (a + √(a² + 4)) / 2; a
/// bend's Jacobian is a rotation plus one column of length rate · r.
pub fn twist_stretch(modifier: &Modifier, clamp_box: Aabb) -> f32 {
    let far = clamp_box.min.abs().max(clamp_box.max.abs());
    match *modifier {
        Modifier::Twist { degrees_per_unit } => {
            let a = degrees_per_unit.to_radians().abs() * Vec2::new(far.x, far.z).length();
            0.5 * (a + (a * a + 4.0).sqrt())
        }
        Modifier::Bend { degrees_per_unit } => {
            1.0 + degrees_per_unit.to_radians().abs() * far.truncate().length()
        }
        _ => 1.0,
    }
}

/// Most copies that are all looked at where they overlap and their distances are bounds: then nothing jumps.
pub(crate) const FEW_COPIES: u64 = 16;

/// Half of the angle about the y axis, measured from +x, that a box covers.
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

/// How many copies to look at along one axis (or ring) so that the nearest is among them, when the solid reaches to
/// `extent` from its cell's center: 2 where it stays within its cell, the own one and the nearest neighbor.
///
/// The nearest point of all copies lies in copy n only if, of the same point's images, n's is nearest; then
/// |n · spacing| ≤ spacing / 2 + extent + spacing / 2.
pub(crate) fn neighbor_copies(extent: f32, spacing: f32) -> u32 {
    if extent <= 0.5 * spacing {
        2
    } else {
        2 * (1.0 + extent / spacing).min(1e6) as u32 + 1
    }
}
