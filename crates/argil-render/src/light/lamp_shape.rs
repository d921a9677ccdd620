//! Lamps, as the rays of their shadows see them. `lamp_shadows.wgsl` is the twin.

use argil_abi::{self as abi, FrameUniform};
use glam::Vec3;
use std::f32::consts::TAU;

/// A lamp, as its shadows see it.
pub(super) struct LampShape {
    pub center: Vec3,
    /// Half of a rectangle's sides, and the direction in which it shines. Zero for others.
    pub axes: [Vec3; 2],
    pub out: Vec3,
    /// Of the sphere, or around the rectangle.
    pub radius: f32,
    /// The longest distance from the middle along an axis.
    pub extent: f32,
    pub is_sun: bool,
}

/// A lamp from one place: a rectangle, or a disc.
pub(super) struct SeenLamp {
    pub middle: Vec3,
    pub axes: [Vec3; 2],
    pub is_disc: bool,
    pub radius: f32,
    pub extent: f32,
}

impl LampShape {
    pub(super) fn of(rows: &[[f32; 4]], frame: &FrameUniform) -> Self {
        let xyz = |row: usize| Vec3::from_slice(&rows[row]);
        let round = |center, radius, is_sun| Self {
            center,
            axes: [Vec3::ZERO; 2],
            out: Vec3::ZERO,
            radius,
            extent: radius,
            is_sun,
        };
        let kind = rows[0][3] as u32;
        if kind == abi::LIGHT_SUN {
            let rim = rows[2][0];
            let tangent = (1.0 - rim * rim).max(0.0).sqrt() / rim.max(1e-6);
            return round(xyz(0), tangent * frame.far, true);
        }
        if kind == abi::LIGHT_SPHERE {
            return round(xyz(0), rows[1][3], false);
        }
        let axes = [xyz(2) * rows[2][3], xyz(3) * rows[3][3]];
        Self {
            center: xyz(0),
            axes,
            out: xyz(2).cross(xyz(3)),
            radius: rows[2][3].hypot(rows[3][3]),
            extent: rows[2][3].max(rows[3][3]),
            is_sun: false,
        }
    }

    pub(super) fn seen_from(&self, p: Vec3, frame: &FrameUniform) -> SeenLamp {
        if self.axes[0] != Vec3::ZERO {
            // A cone around the middle holds the near corners, too.
            let square = (self.center - p).length_squared().max(1e-20);
            let narrow = (1.0 - self.radius * self.radius / square).max(0.01);
            return SeenLamp {
                middle: self.center,
                axes: self.axes,
                is_disc: false,
                radius: self.radius / narrow.sqrt(),
                extent: self.extent,
            };
        }
        let (mut middle, mut radius) = (self.center, self.radius);
        let toward = if self.is_sun {
            middle = p + self.center * frame.far;
            self.center
        } else {
            // The disc that the outline is around.
            let to = self.center - p;
            let size = (radius * radius / to.length_squared().max(1e-20)).min(1.0);
            middle -= to * size;
            radius *= (1.0 - size).sqrt();
            to.normalize_or(Vec3::Y)
        };
        let (x, y) = toward.any_orthonormal_pair();
        SeenLamp {
            middle,
            axes: [x * radius, y * radius],
            is_disc: true,
            radius,
            extent: radius,
        }
    }
}

impl SeenLamp {
    /// Returns one of the points that rays lead to. `shift` differs from sample to sample.
    pub(super) fn point(&self, index: u32, shift: [f32; 2]) -> Vec3 {
        // A lattice of 16 points, which has 16 columns and 16 rows.
        let u = ((index as f32 + 0.5) / 16.0 + shift[0]).fract();
        let v = ((5 * index % 16) as f32 / 16.0 + 0.031_25 + shift[1]).fract();
        let [x, y] = if self.is_disc {
            let (radius, turn) = (u.sqrt(), TAU * v);
            [radius * turn.cos(), radius * turn.sin()]
        } else {
            [2.0 * u - 1.0, 2.0 * v - 1.0]
        };
        self.middle + x * self.axes[0] + y * self.axes[1]
    }
}

/// Returns what a point of a lamp brings to a surface, but for a factor that all points have.
pub(super) fn weight(lamp: &LampShape, to: Vec3, n: Vec3) -> f32 {
    let square = to.length_squared().max(1e-20);
    let facing = n.dot(to).max(0.0);
    if lamp.out == Vec3::ZERO {
        return facing / square.sqrt();
    }
    facing * (-lamp.out.dot(to)).max(0.0) / (square * square)
}
