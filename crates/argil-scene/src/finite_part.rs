//! The part of an infinite solid that a box can contain.

use crate::modified_region::region_after;
use crate::{Extents, NodeId, NodeKind, OperatorKind, Scene};
use argil_math::Aabb;
use rustc_hash::FxHashMap;

impl Extents<'_> {
    /// Returns a box around everything finite in a node, in the frame of the group around it. It contains the finite
    /// brushes, and the finite sides of infinite ones.
    ///
    /// A finite node's box is [`Extents::node_bounds`]. Along an axis where nothing is finite, the minimum of the
    /// result exceeds its maximum. An infinite side that a rotation moved off the axes has no finite part.
    ///
    /// ```
    /// use argil_scene::{Brush, Extents, Scene, Shape};
    /// let mut scene = Scene::new();
    /// scene.push(Shape::Plane { normal: [0.0, 1.0, 0.0], offset: -1.0 })?;
    /// scene.push(Shape::sphere(1.0).at([5.0, 0.0, 0.0]))?;
    /// let mut extents = Extents::of(&scene);
    /// assert!(!extents.node_bounds(Scene::ROOT).aabb.is_finite());
    /// let part = extents.finite_part(Scene::ROOT);
    /// assert!((part.min.x - 4.0).abs() < 1e-3 && (part.max.x - 6.0).abs() < 1e-3);
    /// assert!((part.min.y + 1.0).abs() < 1e-3);
    /// # Ok::<(), argil_scene::EditError>(())
    /// ```
    pub fn finite_part(&mut self, id: NodeId) -> Aabb {
        let whole = self.node_bounds(id).aabb;
        if whole.is_finite() {
            return whole;
        }
        let scene = self.scene();
        let mut parts = FxHashMap::default();
        let parents_first: Vec<NodeId> = scene.descendants(id).collect();
        for &node in parents_first.iter().rev() {
            let part = self.part_of(scene, node, &parts);
            parts.insert(node, part);
        }
        parts.get(&id).copied().unwrap_or(Aabb::EMPTY)
    }

    /// Returns the finite part of a node, given its children's.
    fn part_of(&mut self, scene: &Scene, id: NodeId, parts: &FxHashMap<NodeId, Aabb>) -> Aabb {
        let whole = self.node_bounds(id).aabb;
        let node = scene.node(id);
        let entry = node.at_current_time();
        if whole.is_finite() || matches!(entry.kind, NodeKind::Shape(_)) {
            return finite_sides(whole);
        }
        let (mut all, mut any) = (Aabb::EMPTY, false);
        for &child in node.children() {
            let operand = scene.node(child).at_current_time();
            // The first operand has nothing to act on unless it adds.
            if operand.visible && (any || operand.operator.kind == OperatorKind::Union) {
                any = true;
                all = all.union(parts.get(&child).copied().unwrap_or(Aabb::EMPTY));
            }
        }
        if entry.modifiers.is_empty() {
            return all;
        }
        if !all.is_finite() {
            return finite_sides(whole);
        }
        let stages = self.modifier_stages(id);
        let moved = entry.modifiers.iter().zip(&stages);
        finite_sides(moved.fold(all, |part, (m, content)| region_after(m, part, content)))
    }
}

/// Returns a box whose infinite sides are replaced by the opposite ones. An axis that has no finite side is empty.
fn finite_sides(whole: Aabb) -> Aabb {
    if whole.is_empty() {
        return Aabb::EMPTY;
    }
    let mut part = Aabb::EMPTY;
    for axis in 0..3 {
        for side in [whole.min[axis], whole.max[axis]] {
            if side.is_finite() {
                part.min[axis] = part.min[axis].min(side);
                part.max[axis] = part.max[axis].max(side);
            }
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use crate::{Brush, Extents, Modifier, Scene, Shape};
    use argil_math::Aabb;
    use glam::Vec3;

    fn floor() -> Brush {
        Brush::new(Shape::Plane {
            normal: [0.0, 1.0, 0.0],
            offset: -1.0,
        })
    }

    fn part_of(scene: &Scene) -> Aabb {
        Extents::of(scene).finite_part(Scene::ROOT)
    }

    #[test]
    fn the_finite_part_of_a_plane_is_its_height() {
        let mut scene = Scene::new();
        assert_eq!(part_of(&scene), Aabb::EMPTY);
        scene.push(floor()).expect("a plane");
        let part = part_of(&scene);
        assert_eq!((part.min.y, part.max.y), (-1.0, -1.0));
        assert!(part.min.x > part.max.x && part.min.z > part.max.z);
    }

    #[test]
    fn moved_groups_move_the_finite_part_and_repetitions_lose_an_axis() {
        let mut scene = Scene::new();
        let inner = floor() | Shape::sphere(0.5).at([2.0, 0.0, 0.0]);
        scene.push(inner.at([0.0, 10.0, 0.0])).expect("a group");
        let part = part_of(&scene);
        assert!(part.grown(1e-4).contains(Vec3::new(2.5, 10.5, 0.5)));
        assert!(part.grown(1e-4).contains(Vec3::new(1.5, 9.0, -0.5)));
        assert!((part.size() - Vec3::new(1.0, 1.5, 1.0)).abs().max_element() < 1e-3);

        let mut scene = Scene::new();
        let row = (Shape::sphere(0.5) | Shape::sphere(0.4)).with_modifier(Modifier::Repeat {
            spacing: [3.0, 0.0, 0.0],
            count: None,
        });
        scene.push(row).expect("a row");
        let part = part_of(&scene);
        assert!(part.min.x > part.max.x);
        assert_eq!((part.min.y, part.max.y), (-0.5, 0.5));
    }

    #[test]
    fn what_is_hidden_or_acts_on_nothing_does_not_count() {
        let mut scene = Scene::new();
        let far = Shape::sphere(0.5).at([99.0, 0.0, 0.0]);
        scene.push(far.clone().subtract()).expect("a cut");
        scene.push(floor()).expect("a plane");
        scene.push(far.clone().hidden()).expect("hidden");
        assert!(part_of(&scene).min.x > part_of(&scene).max.x);
        scene.push(far.subtract()).expect("a crater");
        assert!((part_of(&scene).max.x - 99.5).abs() < 1e-3);
    }
}
