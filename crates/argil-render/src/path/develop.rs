//! Turns light into colors.

use crate::srgb::{Place, SRGB};
use crate::tones::{agx, tone_mapped};
use argil_abi as abi;
use argil_scene::{ToneCurve, View};
use glam::Vec3;

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

    /// Returns the factor of light, and a `TONE_…`.
    pub(crate) fn words(&self) -> (f32, u32) {
        let tone = match self.tone {
            ToneCurve::Aces => abi::TONE_ACES,
            ToneCurve::Agx => abi::TONE_AGX,
            ToneCurve::None => abi::TONE_NONE,
        };
        (self.exposure.exp2(), tone)
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

/// Converts light to 8-bit sRGB, three bytes a pixel, in rows of `width` pixels. It is dithered, so that slow gradients have no bands.
pub fn developed(radiance: &[[f32; 3]], width: u32, development: &Development) -> Vec<u8> {
    let toned: Vec<[f32; 4]> = radiance
        .iter()
        .map(|&light| development.color(light).extend(0.0).to_array())
        .collect();
    let mut rgb = vec![0; 3 * radiance.len()];
    let place = Place {
        first_x: 0,
        first_row: 0,
        width,
    };
    SRGB.show(place, &toned, &mut rgb);
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Curves keep order and grays, end at white, and each stop doubles light.
    #[test]
    fn curves_rise_from_black_to_white() {
        for tone in [ToneCurve::Aces, ToneCurve::Agx, ToneCurve::None] {
            let development = Development {
                exposure: 0.0,
                tone,
            };
            let mut last = -1.0;
            for index in 0..60 {
                let light = 0.001 * 1.2f32.powi(index);
                let color = development.color([light; 3]);
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
            let [a, b] = [development.color([0.4; 3]), twice.color([0.2; 3])];
            assert!(a.abs_diff_eq(b, 1e-6));
        }
    }
}
