//! The light of images without paths.

use crate::path::{Development, lamp_rows};
use crate::toward_sun::toward_sun;
use argil_abi::{self as abi, FrameUniform, LAMP_ROWS};
use argil_scene::{AmbientOcclusion, Environment, Fog, Light, SceneImage, View};
use glam::Vec3;
use std::f32::consts::FRAC_2_PI;

/// The light of an image: a sun, a sky of three colors, lamps and fog.
///
/// ```
/// use argil_render::{RenderSettings, ViewLight};
/// use argil_scene::{Fog, View};
/// let view = View { fog: Some(Fog::default()), ..View::default() };
/// let settings = RenderSettings { light: ViewLight::of_view(&view), ..RenderSettings::default() };
/// assert_eq!(settings.light.fog.map(|fog| fog.density), Some(0.1));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewLight {
    /// What a surface receives that faces the sun, linear RGB.
    pub sun_irradiance: [f32; 3],
    /// The sky's light from above, from the horizon and from below.
    pub sky: [[f32; 3]; 3],
    /// How much the sky shines around the sun.
    pub glow: f32,
    /// Fog around everything.
    pub fog: Option<Fog>,
    /// How light becomes colors.
    pub development: Development,
    /// How the sky's light is reduced where surfaces are near.
    pub ambient_occlusion: AmbientOcclusion,
    lamps: [[f32; 4]; LAMP_ROWS],
    lamp_count: u32,
}

impl Default for ViewLight {
    fn default() -> Self {
        Self {
            sun_irradiance: abi::SUN_LIGHT.map(|c| c / FRAC_2_PI),
            sky: [abi::ZENITH, abi::HORIZON, abi::NADIR],
            glow: 1.0,
            fog: None,
            development: Development::default(),
            ambient_occlusion: AmbientOcclusion::Normal,
            lamps: [[0.0; 4]; LAMP_ROWS],
            lamp_count: 0,
        }
    }
}

impl ViewLight {
    /// Returns the light of a view: its first sun, up to eight other lights, and its fog. An environment that is an image becomes
    /// three colors, and one that is not loaded the sky.
    pub fn of_view(view: &View) -> Self {
        let mut lit = Self {
            fog: view.fog.filter(|fog| fog.density > 0.0),
            development: Development::of_view(view),
            ambient_occlusion: view.ambient_occlusion,
            ..Self::default()
        };
        match &view.environment {
            Environment::Sky => {}
            Environment::Color { radiance } => (lit.sky, lit.glow) = ([*radiance; 3], 0.0),
            Environment::Image {
                strength, image, ..
            } => {
                if let Some(image) = &image.0 {
                    (lit.sky, lit.glow) = (bands(image, *strength), 0.0);
                }
            }
        }
        let Some(lights) = &view.lights else {
            return lit;
        };
        lit.sun_irradiance = [0.0; 3];
        let mut has_sun = false;
        for light in lights {
            match light {
                Light::Sun { irradiance, .. } if !has_sun => {
                    (lit.sun_irradiance, has_sun) = (*irradiance, true);
                }
                _ if lit.lamp_count < abi::MAX_LAMPS => {
                    let first = 4 * lit.lamp_count as usize;
                    lit.lamps[first..first + 4].copy_from_slice(&lamp_rows(light));
                    lit.lamp_count += 1;
                }
                _ => {}
            }
        }
        lit
    }

    /// Returns how many lights of a view an image leaves out, because it has one sun and eight others.
    pub fn left_out(view: &View) -> usize {
        let lights = view.lights.as_deref().unwrap_or_default();
        let has_sun = lights
            .iter()
            .any(|light| matches!(light, Light::Sun { .. }));
        let shown = abi::MAX_LAMPS as usize + usize::from(has_sun);
        lights.len().saturating_sub(shown)
    }

    /// Returns the direction of a view's sun, as azimuth and elevation in degrees.
    pub fn sun_degrees(view: &View) -> [f32; 2] {
        let mut lights = view.lights.iter().flatten();
        let sun = lights.find_map(|light| match light {
            Light::Sun {
                direction_degrees, ..
            } => Some(*direction_degrees),
            _ => None,
        });
        sun.unwrap_or(view.sun_degrees)
    }

    /// Writes the light into a frame.
    pub(crate) fn write(&self, sun_degrees: [f32; 2], frame: &mut FrameUniform) {
        frame.sun = toward_sun(sun_degrees);
        frame.sun_light = self.sun_irradiance.map(|c| c * FRAC_2_PI);
        [frame.zenith, frame.horizon, frame.nadir] = self.sky;
        frame.glow = self.glow;
        (frame.exposure, frame.tone) = self.development.words();
        (frame.lamps, frame.lamp_count) = (self.lamps, self.lamp_count);
        frame.has_bent_normals = u32::from(self.ambient_occlusion == AmbientOcclusion::BentNormal);
        if let Some(fog) = self.fog {
            frame.fog_albedo = fog.albedo;
            frame.fog_density = fog.density;
            frame.fog_falloff = fog.falloff;
            frame.fog_height = fog.height;
            frame.fog_anisotropy = fog.anisotropy;
        }
    }
}

/// Whether a frame has light besides a sun and a sky.
pub(crate) fn has_more(frame: &FrameUniform) -> bool {
    frame.lamp_count > 0 || frame.fog_density > 0.0 || frame.has_bent_normals != 0
}

/// Returns the mean light of an image from above, from around the horizon, and from below.
fn bands(image: &SceneImage, strength: f32) -> [[f32; 3]; 3] {
    let [width, height] = image.size.map(|side| side as usize);
    let mut sums = [Vec3::ZERO; 3];
    let mut angles = [0.0f32; 3];
    for (y, row) in image.pixels.chunks(width.max(1)).enumerate() {
        let elevation = 90.0 - 180.0 * (y as f32 + 0.5) / height as f32;
        let band = match elevation {
            30.0.. => 0,
            -15.0.. => 1,
            _ => 2,
        };
        let angle = elevation.to_radians().cos();
        sums[band] += angle * row.iter().map(|&pixel| Vec3::from(pixel)).sum::<Vec3>();
        angles[band] += angle * row.len() as f32;
    }
    let means = [0, 1, 2].map(|band| sums[band] / angles[band].max(1e-6));
    means.map(|mean| (strength * mean).to_array())
}
