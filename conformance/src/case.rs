//! Named scenes, and pseudorandom numbers.

use argil_scene::{Brush, NodeId, Scene};
use glam::Vec3;

/// A scene with a name for messages.
#[derive(Debug)]
pub struct SceneCase {
    /// What it tests.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

/// Pseudorandom numbers: a 64-bit linear congruential generator (Knuth's constants).
#[derive(Debug)]
pub struct CaseRng(u64);

impl CaseRng {
    /// Creates a generator from a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(2_654_435_761).wrapping_add(1))
    }

    /// Returns a number from 0 to 1.
    pub fn unit(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Returns a number from `low` to `high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Returns a point in a cube around the origin.
    pub fn point(&mut self, half: f32) -> Vec3 {
        Vec3::new(
            self.between(-half, half),
            self.between(-half, half),
            self.between(-half, half),
        )
    }
}

pub(crate) fn one(name: &str, brush: Brush) -> SceneCase {
    let mut scene = Scene::new();
    push(&mut scene, Scene::ROOT, brush);
    SceneCase {
        name: name.to_owned(),
        scene,
    }
}

pub(crate) fn push(
    scene: &mut Scene,
    group: NodeId,
    entry: impl Into<argil_scene::NodeTree>,
) -> NodeId {
    scene.push_into(group, entry).expect("a valid entry").node
}
