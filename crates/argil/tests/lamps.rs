//! Lamps of images without paths against stills with one bounce: every kind of lamp at distances from a ceiling, a wall and a floor.

use argil::prelude::*;
use argil::render::StillOptions;
use argil::scene::{Environment, Light, ToneCurve};

type Outcome = Result<(), Box<dyn std::error::Error>>;

const SIZE: [u32; 2] = [56, 42];
/// Paths of a pixel of a still, and samples of an image.
const PATHS: u32 = 64;
const SAMPLES: u32 = 36;

/// A surface that a lamp is near, by the lamp's place and where it shines to, in units of the room.
#[derive(Clone, Copy, Debug)]
enum Near {
    Ceiling,
    Wall,
    Floor,
}

const KINDS: [&str; 4] = ["point", "sphere", "spot", "area"];

fn lamp(kind: &str, near: Near, distance: f32, unit: f32) -> Light {
    let (at, target) = match near {
        Near::Ceiling => (
            [0.1 * unit, 2.5 * unit - distance, 0.0],
            [0.1 * unit, 0.0, 0.0],
        ),
        Near::Wall => (
            [-2.0 * unit + distance, 1.4 * unit, 0.2 * unit],
            [2.0 * unit, 1.4 * unit, 0.2 * unit],
        ),
        Near::Floor => (
            [-0.8 * unit, distance, 0.6 * unit],
            [0.4 * unit, distance, 0.0],
        ),
    };
    let intensity = [4.0 * unit * unit; 3];
    match kind {
        "point" => Light::Point {
            at,
            intensity,
            radius: 0.0,
        },
        "sphere" => Light::Point {
            at,
            intensity,
            radius: (0.8 * distance).min(0.15 * unit),
        },
        "spot" => Light::Spot {
            at,
            target,
            intensity,
            angle_degrees: 100.0,
            fade: 0.3,
            radius: 0.02 * distance.min(unit),
        },
        _ => {
            // It hangs above the floor.
            let height = if matches!(near, Near::Floor) {
                (1.6 * distance).min(0.5 * unit)
            } else {
                0.5 * unit
            };
            Light::Area {
                at,
                target,
                size: [0.8 * unit, height],
                radiance: [8.0; 3],
            }
        }
    }
}

fn room(kind: &str, near: Near, distance: f32) -> Result<Scene, Box<dyn std::error::Error>> {
    let unit = distance.max(1.0);
    let mut scene = Scene::new();
    let slab = |size: [f32; 3], at: [f32; 3]| {
        Brush::new(Shape::cuboid(size.map(|s| 0.5 * s * unit))).at(at.map(|p| p * unit))
    };
    scene.push(slab([4.4, 0.4, 4.4], [0.0, -0.2, 0.0]))?;
    scene.push(slab([4.4, 0.4, 4.4], [0.0, 2.7, 0.0]))?;
    scene.push(slab([0.4, 2.8, 4.4], [-2.2, 1.25, 0.0]))?;
    scene.push(Brush::new(Shape::sphere(0.35 * unit)).at([0.4, 0.35, 0.0].map(|p| p * unit)))?;
    scene.push(slab([0.15, 0.8, 0.5], [-0.4, 0.4, -0.7]))?;
    let mut view = scene.view.clone();
    view.lights = Some(vec![lamp(kind, near, distance, unit)]);
    view.environment = Environment::Color { radiance: [0.0; 3] };
    view.tone = ToneCurve::None;
    view.camera = CameraPose::LookAt {
        eye: [1.9, 1.6, 2.9].map(|p| p * unit),
        target: [-0.3, 0.7, -0.2].map(|p| p * unit),
    };
    view.field_of_view_degrees = 60.0;
    scene.apply(Edit::SetView {
        view: Box::new(view),
    })?;
    Ok(scene)
}

/// Returns the light of 8-bit sRGB.
fn linear(code: u8) -> f32 {
    let c = f32::from(code) / 255.0;
    if c <= 0.040_45 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

/// An image and the still, in light that is 1 where it is white.
struct Pair {
    codes: Vec<u8>,
    still: Vec<f32>,
}

impl Pair {
    fn draw(mut scene: Scene) -> Result<Self, Box<dyn std::error::Error>> {
        let engine = Engine::cpu();
        let settings = |world: &World| RenderSettings {
            samples: SAMPLES,
            ground: false,
            ..world.render_settings(SIZE, RenderMode::Shaded)
        };
        let world = engine.build(&scene)?.field();
        let options = StillOptions {
            samples: PATHS,
            max_bounces: 1,
            ..StillOptions::default()
        };
        let still = world.still(&world.camera(), &settings(&world), &options)?;
        let mut light: Vec<f32> = still.radiance().iter().map(|c| c[1]).collect();
        // Half of the pixels that receive light are brighter than a third.
        let mut lit: Vec<f32> = light.iter().copied().filter(|c| *c > 0.0).collect();
        lit.sort_by(f32::total_cmp);
        let mut view = scene.view.clone();
        view.exposure = (0.33 / lit[lit.len() / 2]).log2().clamp(-20.0, 20.0);
        let gain = view.exposure.exp2();
        light.iter_mut().for_each(|c| *c *= gain);
        scene.apply(Edit::SetView {
            view: Box::new(view),
        })?;
        let world = engine.build(&scene)?.field();
        let image = world.render(&world.camera(), &settings(&world))?;
        Ok(Self {
            codes: image.rgb.chunks(3).map(|rgb| rgb[1]).collect(),
            still: light,
        })
    }

    /// Returns the share of pixels that are within 5 % of the still, or as near to it as noise and bytes can tell.
    fn right(&self) -> f64 {
        let is_right = |(&code, &still): (&u8, &f32)| {
            let noise = 0.25 * still.clamp(0.0, 1.0).sqrt() / (PATHS as f32).sqrt();
            let low = 0.95 * linear(code.saturating_sub(1)) - noise;
            let high = 1.05 * linear(code.saturating_add(1)) + noise;
            (low..=high).contains(&still) || code == 255 && still > 0.95
        };
        let all = self.codes.iter().zip(&self.still);
        all.filter(|pair| is_right(*pair)).count() as f64 / self.still.len() as f64
    }

    /// Returns the largest step between neighbors on the floor, in the image and in the still.
    fn steps(&self) -> [f32; 2] {
        let [width, height] = SIZE.map(|side| side as usize);
        let image: Vec<f32> = self.codes.iter().map(|&code| linear(code)).collect();
        [&image, &self.still].map(|light| {
            let rows = (height * 4 / 5..height).flat_map(|y| {
                let row = &light[y * width + width / 4..(y + 1) * width];
                row.windows(2)
                    .map(|pair| (pair[0].min(1.0) - pair[1].min(1.0)).abs())
            });
            rows.fold(0.0, f32::max)
        })
    }
}

#[test]
fn lamps_are_those_of_stills() -> Outcome {
    for near in [Near::Ceiling, Near::Wall, Near::Floor] {
        for distance in [0.01, 0.1, 1.0] {
            for kind in KINDS {
                // Between the nearest and the farthest, areas vary most.
                if kind != "area" && ![0.01, 1.0].contains(&distance) {
                    continue;
                }
                let pair = Pair::draw(room(kind, near, distance)?)?;
                let (right, [image, still]) = (pair.right(), pair.steps());
                assert!(right > 0.94, "{kind} {near:?} {distance}: {right}");
                assert!(
                    image < 2.0 * still + 0.02,
                    "{kind} {near:?} {distance}: {image} {still}"
                );
            }
        }
    }
    Ok(())
}
