//! Turns light into colors.

use crate::light::reflect::tone_mapped;
use crate::srgb::SRGB;
use argil_scene::{ToneCurve, View};
use glam::{Mat3, Vec3, vec3};

/// How light becomes colors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Development {
    /// Exposure in stops: each doubles the light.
    pub exposure: f32,
    /// The tone curve.
    pub tone: ToneCurve,
}

impl Development {
    /// Returns what a view says.
    pub fn of_view(view: &View) -> Self {
        Self {
            exposure: view.exposure,
            tone: view.tone,
        }
    }

    /// Returns the linear color of light, from 0 to 1.
    fn color(&self, light: [f32; 3]) -> Vec3 {
        let light = Vec3::from(light) * self.exposure.exp2();
        match self.tone {
            ToneCurve::Aces => light.map(tone_mapped),
            ToneCurve::Agx => agx(light),
            ToneCurve::None => light.clamp(Vec3::ZERO, Vec3::ONE),
        }
    }
}

/// Converts light to 8-bit sRGB, three bytes a pixel.
pub fn developed(radiance: &[[f32; 3]], development: &Development) -> Vec<u8> {
    let toned: Vec<[f32; 4]> = radiance
        .iter()
        .map(|&light| development.color(light).extend(0.0).to_array())
        .collect();
    let mut rgb = vec![0; 3 * radiance.len()];
    SRGB.show(&toned, &mut rgb);
    rgb
}

/// Primaries between which AgX has its curve: colors turn toward white as they grow bright.
const INSET: Mat3 = Mat3::from_cols(
    vec3(0.842_479_1, 0.042_328_24, 0.042_375_66),
    vec3(0.078_433_6, 0.878_468_6, 0.078_433_6),
    vec3(0.079_223_75, 0.079_166_13, 0.879_143),
);
const OUTSET: Mat3 = Mat3::from_cols(
    vec3(1.196_879, -0.052_896_85, -0.052_971_64),
    vec3(-0.098_020_88, 1.151_903_1, -0.098_043_45),
    vec3(-0.099_029_74, -0.098_961_18, 1.151_073_7),
);
/// The least and the most light of its curve, as powers of two.
const STOPS: [f32; 2] = [-12.473_93, 4.026_069];

/// The AgX curve by Sobotka, as fitted by Wrensch ("Minimal AgX implementation", 2023).
fn agx(light: Vec3) -> Vec3 {
    let [least, most] = STOPS;
    let bright = (INSET * light).max(Vec3::splat(1e-10));
    let x = (bright
        .map(f32::log2)
        .clamp(Vec3::splat(least), Vec3::splat(most))
        - least)
        / (most - least);
    let curve = |x: f32| {
        let mut sum = 0.0;
        for factor in [15.5, -40.14, 31.96, -6.868, 0.429_8, 0.119_1, -0.002_32] {
            sum = sum * x + factor;
        }
        sum
    };
    let shown = OUTSET * x.map(curve);
    shown.max(Vec3::ZERO).map(|c| c.powf(2.2)).min(Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Curves keep order and grays, end at white, and each stop doubles light.
    #[test]
    fn curves_rise_from_black_to_white() {
        for tone in [ToneCurve::Aces, ToneCurve::Agx, ToneCurve::None] {
            let own = Development {
                exposure: 0.0,
                tone,
            };
            let mut last = -1.0;
            for nth in 0..60 {
                let light = 0.001 * 1.2f32.powi(nth);
                let color = own.color([light; 3]);
                assert!(
                    color.max_element() - color.min_element() < 2e-3,
                    "{tone:?} {color}"
                );
                assert!(color.x >= last - 1e-4, "{tone:?} {light} {color} {last}");
                last = color.x;
            }
            assert!(last > 0.9, "{tone:?}: {last}");
            let twice = Development {
                exposure: 1.0,
                tone,
            };
            let [a, b] = [own.color([0.4; 3]), twice.color([0.2; 3])];
            assert!(a.abs_diff_eq(b, 1e-6));
        }
    }
}
