//! The measured scenes. They are part of the program, so that the study runs anywhere.

use anyhow::Context;
use argil::scene::{Brush, Modifier, Scene, Shape};

/// The scenes of the repository, by name.
const SHIPPED: [(&str, &str); 10] = [
    ("brick", include_str!("../../scenes/brick.json")),
    ("teapot", include_str!("../../scenes/teapot.json")),
    ("edgy-cube", include_str!("../../scenes/edgy-cube.json")),
    (
        "dense-spheres",
        include_str!("../../scenes/dense-spheres.json"),
    ),
    (
        "dense-edgy-cubes",
        include_str!("../../scenes/dense-edgy-cubes.json"),
    ),
    ("csg20", include_str!("../../scenes/csg20.json")),
    ("props", include_str!("../../scenes/props.json")),
    ("temple", include_str!("../../scenes/temple.json")),
    ("melting", include_str!("../../scenes/melting.json")),
    ("trees", include_str!("../../scenes/trees.json")),
];

/// The five scenes of the 2023 study.
pub(crate) const OF_THE_STUDY: [&str; 5] = [
    "brick",
    "teapot",
    "edgy-cube",
    "dense-spheres",
    "dense-edgy-cubes",
];

/// Bricks along a side of the study's volume.
const BRICKS: u32 = 8;

/// Returns a scene by name: a scene of the repository; `spheres-N`, N³ spheres in as many of the study's 8³ bricks;
/// `center`, a sphere around the centers of the middle bricks; `crowd-N`, N balls.
pub(crate) fn scene(name: &str) -> anyhow::Result<Scene> {
    if let Some((name, text)) = SHIPPED.iter().find(|(shipped, _)| *shipped == name) {
        return Ok(Scene::from_json(text, format!("scenes/{name}.json"))?);
    }
    let number = |text: &str| {
        text.parse()
            .with_context(|| format!("unknown scene {name}"))
    };
    if let Some(count) = name.strip_prefix("spheres-") {
        return spheres(number(count)?);
    }
    if let Some(count) = name.strip_prefix("crowd-") {
        return crowd(number(count)?);
    }
    anyhow::ensure!(name == "center", "unknown scene {name}");
    let mut scene = framed();
    scene.push(Brush::new(Shape::sphere(0.125)))?;
    Ok(scene)
}

/// Returns true if the name is that of a file.
pub(crate) fn is_shipped(name: &str) -> bool {
    SHIPPED.iter().any(|(shipped, _)| *shipped == name)
}

fn framed() -> Scene {
    let mut scene = Scene::new();
    scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    scene
}

/// Creates a sphere in the middle of each of `side`³ bricks, by repetition.
fn spheres(side: u32) -> anyhow::Result<Scene> {
    let edge = 2.0 / BRICKS as f32;
    let mut scene = framed();
    let repeat = Modifier::Repeat {
        spacing: [edge; 3],
        count: Some([side; 3]),
    };
    let mut brush = Brush::new(Shape::sphere(0.3 * edge)).with_modifier(repeat);
    if side % 2 == 1 {
        // The centers of bricks are off the origin.
        brush = brush.at([0.5 * edge; 3]);
    }
    scene.push(brush)?;
    Ok(scene)
}

/// A deterministic generator of numbers from 0 to 1.
pub(crate) struct SceneRng(u64);

impl SceneRng {
    /// Creates a generator from a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(2).wrapping_add(1))
    }

    /// Returns the next number.
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

/// Creates balls all over a box, smaller the more there are.
fn crowd(count: u32) -> anyhow::Result<Scene> {
    let mut scene = framed();
    let mut numbers = SceneRng::new(1);
    let radius = 0.5 / (count as f32).cbrt();
    for _ in 0..count {
        let at = [(); 3].map(|()| 1.8 * (numbers.next() - 0.5));
        let varied = radius * (0.5 + numbers.next());
        scene.push(Brush::new(Shape::sphere(varied)).at(at))?;
    }
    Ok(scene)
}
