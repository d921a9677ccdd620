//! The lights of a picture, and how a path chooses one.
//!
//! *Practice.* A path looks for one light at a time, the more often the more light it may bring to the point.

use super::emitters::{Cone, EmitterPoint, RectangleLight, SphereLight};
use super::environment::EnvironmentMap;
use super::sky::Sun;
use crate::light::reflect::sky;
use crate::toward_sun::toward_sun;
use argil_abi::{self as abi, FrameUniform, PathUniform};
use argil_scene::{Environment, Light, View};
use glam::Vec3;

/// What is behind everything.
#[derive(Clone, Debug)]
enum Background {
    /// The sky of the other integrator.
    Sky,
    /// The same light from everywhere.
    Even(Vec3),
    Image(EnvironmentMap),
}

#[derive(Clone, Debug)]
enum PathLight {
    Sun(Sun),
    Sphere(SphereLight),
    Rectangle(RectangleLight),
    /// The image behind everything.
    Environment,
}

/// The image of a scene's environment is not loaded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("view.environment: the image \"{0}\" is not loaded")]
pub struct EnvironmentNotLoaded(pub String);

/// Lights, prepared for paths.
#[derive(Clone, Debug)]
pub struct PathLights {
    background: Background,
    lights: Vec<PathLight>,
}

/// A point of a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightSample {
    pub direction: Vec3,
    /// How far away it is: infinity for the sky.
    pub distance: f32,
    /// What comes from there, divided by the density.
    pub light: Vec3,
    /// The density. Infinite for a point without size, which no other way finds.
    pub density: f32,
}

impl PathLights {
    /// Creates the lights of a view. A view without lights has the sun of the other integrator.
    ///
    /// # Errors
    /// If the environment is an image that is not loaded.
    pub fn of_view(view: &View, frame: &FrameUniform) -> Result<Self, EnvironmentNotLoaded> {
        let background = match &view.environment {
            Environment::Sky => Background::Sky,
            Environment::Color { radiance } => Background::Even((*radiance).into()),
            Environment::Image {
                path,
                turn_degrees,
                strength,
                image,
            } => {
                let image = image.0.clone();
                let image = image.ok_or_else(|| EnvironmentNotLoaded(path.clone()))?;
                Background::Image(EnvironmentMap::new(image, *turn_degrees, *strength))
            }
        };
        let mut lights: Vec<PathLight> = match &view.lights {
            Some(all) => all.iter().map(PathLight::of).collect(),
            None => vec![PathLight::Sun(sun_of(frame))],
        };
        lights.retain(PathLight::shines);
        if let Background::Image(image) = &background
            && image.importance() > 0.0
        {
            lights.push(PathLight::Environment);
        }
        Ok(Self { background, lights })
    }

    /// The same light from everywhere.
    pub fn even(radiance: [f32; 3]) -> Self {
        Self {
            background: Background::Even(radiance.into()),
            lights: Vec::new(),
        }
    }

    /// Returns what is behind everything, without the lights.
    pub(super) fn background(&self, frame: &FrameUniform, direction: Vec3) -> Vec3 {
        match &self.background {
            Background::Sky => sky(frame, direction),
            Background::Even(radiance) => *radiance,
            Background::Image(image) => image.radiance(direction),
        }
    }

    /// Returns an estimate of what a light brings to a point.
    fn importance(&self, light: &PathLight, at: Vec3) -> f32 {
        match light {
            PathLight::Sun(sun) => sun.irradiance().element_sum(),
            PathLight::Sphere(sphere) => sphere.importance(at),
            PathLight::Rectangle(rectangle) => rectangle.importance(at),
            PathLight::Environment => match &self.background {
                Background::Image(image) => image.importance(),
                Background::Sky | Background::Even(_) => 0.0,
            },
        }
    }

    /// Returns the rows of all lights for shaders.
    pub(super) fn rows(&self) -> Vec<[[f32; 4]; 4]> {
        let row = |light: &PathLight| match light {
            PathLight::Sun(sun) => sun.rows(),
            PathLight::Sphere(sphere) => sphere.rows(),
            PathLight::Rectangle(rectangle) => rectangle.rows(),
            PathLight::Environment => {
                let importance = self.importance(light, Vec3::ZERO);
                let kind = abi::LIGHT_ENVIRONMENT as f32;
                [[0.0, 0.0, 0.0, kind], [importance; 4], [0.0; 4], [0.0; 4]]
            }
        };
        self.lights.iter().map(row).collect()
    }

    /// Describes the background in a uniform, appends the sums of an image's rows, and returns its pixels.
    pub(super) fn write_background(
        &self,
        uniform: &mut PathUniform,
        rows: &mut Vec<[f32; 4]>,
    ) -> Vec<[f32; 4]> {
        [uniform.environment_width, uniform.environment_height] = [1, 1];
        match &self.background {
            Background::Sky => uniform.background = abi::BACKGROUND_SKY,
            Background::Even(radiance) => {
                uniform.background = abi::BACKGROUND_EVEN;
                uniform.even = radiance.to_array();
            }
            Background::Image(image) => {
                uniform.background = abi::BACKGROUND_IMAGE;
                return image.write(uniform, rows);
            }
        }
        vec![[0.0; 4]]
    }

    fn all_importance(&self, at: Vec3) -> f32 {
        let all = self.lights.iter();
        all.map(|light| self.importance(light, at)).sum()
    }

    /// Returns the chance with which a light is chosen.
    fn chance(&self, light: &PathLight, at: Vec3) -> f32 {
        if let [_] = self.lights[..] {
            return 1.0;
        }
        self.importance(light, at) / self.all_importance(at).max(1e-30)
    }

    /// Returns what a ray finds that meets nothing. `share` gives that of a density with which lights are sampled.
    pub(super) fn sky(
        &self,
        frame: &FrameUniform,
        (origin, direction): (Vec3, Vec3),
        share: impl Fn(f32) -> f32,
    ) -> Vec3 {
        let mut behind = self.background(frame, direction);
        let mut suns = Vec3::ZERO;
        for light in &self.lights {
            match light {
                PathLight::Sun(sun) => {
                    let density = sun.density(direction);
                    if density > 0.0 {
                        let density = density * self.chance(light, origin);
                        suns += sun.seen(direction) * share(density);
                    }
                }
                PathLight::Environment => {
                    if let Background::Image(image) = &self.background {
                        let density = image.density(direction) * self.chance(light, origin);
                        behind *= share(density);
                    }
                }
                PathLight::Sphere(_) | PathLight::Rectangle(_) => {}
            }
        }
        behind + suns
    }

    /// Returns the light of all lights with a place that a ray passes up to a distance.
    pub(super) fn passed(
        &self,
        (origin, direction): (Vec3, Vec3),
        distance: f32,
        share: impl Fn(f32) -> f32,
    ) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for light in &self.lights {
            let point = match light {
                PathLight::Sphere(sphere) => sphere.met(origin, direction),
                PathLight::Rectangle(rectangle) => rectangle.met(origin, direction),
                PathLight::Sun(_) | PathLight::Environment => None,
            };
            if let Some(point) = point.filter(|point| point.distance < distance) {
                let density = point.density * self.chance(light, origin);
                sum += point.radiance * share(density);
            }
        }
        sum
    }

    /// Chooses a light and a point of it.
    pub(super) fn sample(&self, at: Vec3, which: f32, point: [f32; 2]) -> Option<LightSample> {
        let light = self.choose(at, which)?;
        let chance = self.chance(light, at);
        let far = |direction, radiance, density| EmitterPoint {
            direction,
            distance: f32::INFINITY,
            radiance,
            density,
        };
        let found = match light {
            PathLight::Sun(sun) => {
                let (direction, radiance, density) = sun.sample(point);
                Some(far(direction, radiance, density))
            }
            PathLight::Sphere(sphere) => sphere.sample(at, point),
            PathLight::Rectangle(rectangle) => rectangle.sample(at, point),
            PathLight::Environment => match &self.background {
                Background::Image(image) => {
                    let (direction, density) = image.sample(point);
                    Some(far(direction, image.radiance(direction), density))
                }
                Background::Sky | Background::Even(_) => None,
            },
        }?;
        let divisor = if found.density.is_infinite() {
            1.0
        } else {
            found.density
        };
        (divisor > 0.0 && chance > 0.0).then(|| LightSample {
            direction: found.direction,
            distance: found.distance,
            light: found.radiance / (divisor * chance),
            density: found.density * chance,
        })
    }

    fn choose(&self, at: Vec3, which: f32) -> Option<&PathLight> {
        if let [only] = &self.lights[..] {
            return Some(only);
        }
        let mut left = which * self.all_importance(at);
        let mut last = None;
        for light in &self.lights {
            let importance = self.importance(light, at);
            if importance <= 0.0 {
                continue;
            }
            last = Some(light);
            left -= importance;
            if left < 0.0 {
                break;
            }
        }
        last
    }
}

/// The sun of the other integrator.
fn sun_of(frame: &FrameUniform) -> Sun {
    let irradiance = Vec3::from(argil_abi::SUN_LIGHT) * std::f32::consts::FRAC_PI_2;
    Sun::new(frame.sun.into(), irradiance, SUN_DEGREES)
}

/// Returns the rows of a light for shaders.
pub(crate) fn lamp_rows(light: &Light) -> [[f32; 4]; 4] {
    match PathLight::of(light) {
        PathLight::Sun(sun) => sun.rows(),
        PathLight::Sphere(sphere) => sphere.rows(),
        PathLight::Rectangle(rectangle) => rectangle.rows(),
        PathLight::Environment => [[0.0; 4]; 4],
    }
}

impl PathLight {
    fn of(light: &Light) -> Self {
        match *light {
            Light::Sun {
                direction_degrees,
                irradiance,
                angle_degrees,
            } => {
                let direction = toward_sun(direction_degrees);
                Self::Sun(Sun::new(direction.into(), irradiance.into(), angle_degrees))
            }
            Light::Point {
                at,
                intensity,
                radius,
            } => Self::Sphere(SphereLight {
                center: at.into(),
                radius,
                intensity: intensity.into(),
                cone: None,
            }),
            Light::Spot {
                at,
                target,
                intensity,
                angle_degrees,
                fade,
                radius,
            } => {
                let axis = (Vec3::from(target) - Vec3::from(at)).normalize_or_zero();
                Self::Sphere(SphereLight {
                    center: at.into(),
                    radius,
                    intensity: intensity.into(),
                    cone: Some(Cone::new(axis, angle_degrees, fade)),
                })
            }
            Light::Area {
                at,
                target,
                size,
                radiance,
            } => Self::Rectangle(RectangleLight::new(
                at.into(),
                target.into(),
                size,
                radiance.into(),
            )),
        }
    }

    fn shines(&self) -> bool {
        let light = match self {
            Self::Sun(sun) => sun.irradiance(),
            Self::Sphere(sphere) => sphere.intensity,
            Self::Rectangle(rectangle) => rectangle.radiance,
            Self::Environment => Vec3::ONE,
        };
        light.max_element() > 0.0
    }
}

/// The sun's angle, as seen from the earth.
const SUN_DEGREES: f32 = 0.53;
