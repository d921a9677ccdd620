//! The record of a change, for worlds that follow a scene.

use crate::NodeId;
use argil_math::Aabb;

/// A change of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneChange {
    /// The node that was inserted, removed, moved or changed. `None` if everything may have changed.
    pub node: Option<NodeId>,
    /// The groups that contained the node before and after. `None` where it was not in the scene.
    pub parents: [Option<NodeId>; 2],
    /// Outside this box, no distance below the first [margin](crate::Scene::margins) changed, and no material.
    pub dirty_box: Aabb,
    /// Outside this box, no distance below the second margin changed.
    pub influence_box: Aabb,
    /// The scene's [margins](crate::Scene::margins) at the time of the change, in its unit.
    pub margins: [f32; 2],
    /// Whether a material, which no node uses yet, came to the end of the list or left it.
    pub is_unused_material: bool,
    /// Both boxes, separately around the old and the new position.
    pub(crate) apart: [[Aabb; 2]; 2],
}

impl SceneChange {
    /// Creates a change that may affect everything.
    pub(crate) fn of_everything() -> Self {
        Self {
            node: None,
            parents: [None; 2],
            dirty_box: Aabb::ALL,
            influence_box: Aabb::ALL,
            margins: [f32::INFINITY; 2],
            is_unused_material: false,
            apart: [[Aabb::ALL; 2]; 2],
        }
    }

    /// Creates a change of a list of materials: one that no node uses came to its end, or left it.
    pub(crate) fn of_unused_material() -> Self {
        Self {
            dirty_box: Aabb::EMPTY,
            influence_box: Aabb::EMPTY,
            is_unused_material: true,
            apart: [[Aabb::EMPTY; 2]; 2],
            ..Self::of_everything()
        }
    }

    /// Iterates over pairs of dirty box and influence box. A node that moved far has separate pairs for its old and
    /// its new position.
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
