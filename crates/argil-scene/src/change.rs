//! What edits tell those who follow a scene.

use crate::NodeId;
use argil_math::Aabb;

/// What changed in a scene, for those that keep something made of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneChange {
    /// The node that was made, taken out, moved or changed; `None` where everything may have.
    pub node: Option<NodeId>,
    /// The groups that held it, before and after; `None` where it was not in the scene.
    pub parents: [Option<NodeId>; 2],
    /// Outside this box no distance below the first of the scene's [bands](crate::Scene::margins) changed, nor did a material.
    pub dirty_box: Aabb,
    /// Outside this box no distance below the second of them changed.
    pub influence_box: Aabb,
    /// What the scene's [bands](crate::Scene::margins) were.
    pub margins: [f32; 2],
    /// The two boxes by themselves, around where it was and where it is.
    pub(crate) apart: [[Aabb; 2]; 2],
}

impl SceneChange {
    /// Of what everything can depend on.
    pub(crate) fn of_everything() -> Self {
        Self {
            node: None,
            parents: [None; 2],
            dirty_box: Aabb::ALL,
            influence_box: Aabb::ALL,
            margins: [f32::INFINITY; 2],
            apart: [[Aabb::ALL; 2]; 2],
        }
    }

    /// The dirty and the far box; of what was moved far away, those of where it was and those of where it is.
    pub fn boxes(&self) -> impl Iterator<Item = [Aabb; 2]> + use<> {
        let volume = |b: Aabb| {
            if b.is_empty() {
                0.0
            } else {
                b.size().element_product()
            }
        };
        let [before, after] = self.apart;
        let are_apart = volume(self.influence_box) > 1.5 * (volume(before[1]) + volume(after[1]));
        let (first, second) = if are_apart {
            (before, Some(after))
        } else {
            ([self.dirty_box, self.influence_box], None)
        };
        std::iter::once(first).chain(second)
    }
}
