//! Picking: finds the surface point under the cursor, and the brush that forms it.

use crate::ready::ready;
use argil::glam::{Vec2, Vec3};
use argil::scene::{Group, NodeDesc, NodeId, NodeKind, Operator, Scene};
use argil::{EditBudget, Engine, MeshMethod, MeshNormals, MeshOptions, RayHit, World};
use std::collections::HashMap;

/// A field of the scene on the CPU, and one of each brush alone.
pub(crate) struct Picker {
    world: Option<World>,
    version: u64,
    /// Fields of single brushes, with the descriptions they were built from.
    alone: HashMap<NodeId, (Vec<NodeDesc>, Option<SingleBrushWorld>)>,
}

struct SingleBrushWorld {
    world: World,
    outline: Option<Silhouette>,
}

/// A coarse mesh of a brush's surface, which gives its outline.
pub(crate) struct Silhouette {
    corners: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Silhouette {
    /// Returns the silhouette: per triangle, the zeros of the angle between normal and view direction, interpolated
    /// between vertices (Hertzmann and Zorin 2000).
    pub(crate) fn seen_from(&self, eye: Vec3) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        let place = move |i: u32| {
            let (corner, normal) = (self.corners[i as usize], self.normals[i as usize]);
            (corner, normal.dot(corner - eye))
        };
        self.triangles.iter().filter_map(move |triangle| {
            let corners = triangle.map(place);
            let mut ends = [0, 1, 2].into_iter().filter_map(|k| {
                let [(p, s), (q, t)] = [corners[k], corners[(k + 1) % 3]];
                ((s > 0.0) != (t > 0.0)).then(|| p.lerp(q, s / (s - t)))
            });
            Some([ends.next()?, ends.next()?])
        })
    }
}

/// A picked point of the surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Picked {
    /// The hit.
    pub hit: RayHit,
    /// The brush that forms the surface there.
    pub node: NodeId,
}

const FAR: f32 = 1e6;
/// How long the window waits for the field after an edit, in milliseconds.
const EDIT_MS: f64 = 4.0;
const OUTLINE_CELLS: u32 = 32;

impl Picker {
    /// Creates an empty picker.
    pub(crate) fn new() -> Self {
        Self {
            world: None,
            version: u64::MAX,
            alone: HashMap::new(),
        }
    }

    /// Returns the field of the current scene, or `None` if it cannot be built. After an edit of a large scene, it is the field
    /// before the edit for a moment, so that the window does not wait.
    pub(crate) fn world(&mut self, scene: &Scene, version: u64) -> Option<&World> {
        if self.version != version {
            let applied = self.world.as_mut().map(|world| {
                let budget = EditBudget::new(EDIT_MS);
                ready(world.apply_within_async(scene, budget))
            });
            match applied {
                Some(Ok(report)) if report.remaining_blocks > 0 => {}
                Some(Ok(_)) => self.version = version,
                _ => {
                    self.world = Engine::cpu().build(scene).ok().map(argil::Build::field);
                    self.version = version;
                }
            }
        }
        self.world.as_ref()
    }

    /// Discards everything, for another scene.
    pub(crate) fn forget(&mut self) {
        *self = Self::new();
    }

    /// Casts a ray.
    pub(crate) fn cast(
        &mut self,
        (scene, version): (&Scene, u64),
        ray: [Vec3; 2],
    ) -> Option<RayHit> {
        let [origin, direction] = ray.map(|v| v.to_array());
        self.world(scene, version)?
            .query()
            .cast_ray(origin, direction, FAR)
    }

    /// Casts a ray, and returns the visible brush that forms the surface there, whatever its operator.
    pub(crate) fn pick(
        &mut self,
        (scene, version): (&Scene, u64),
        ray: [Vec3; 2],
        may: impl Fn(NodeId) -> bool,
    ) -> Option<Picked> {
        let hit = self.cast((scene, version), ray)?;
        let point = hit.point;
        let mut best: Option<(f32, NodeId)> = None;
        let brushes: Vec<NodeId> = scene.iter().collect();
        for node in brushes {
            let is_brush = matches!(scene.node(node).desc().kind, NodeKind::Shape(_));
            if !is_brush || !may(node) || !is_visible(scene, node) {
                continue;
            }
            let Some(alone) = self.alone(scene, node) else {
                continue;
            };
            let off = alone.world.distance(point).abs();
            // Of equally near brushes the last one wins, because it is evaluated last.
            if best.is_none_or(|(least, _)| off <= least + 1e-6) {
                best = Some((off, node));
            }
        }
        best.map(|(_, node)| Picked { hit, node })
    }

    /// Returns the distance to a brush alone.
    pub(crate) fn distance_to(
        &mut self,
        scene: &Scene,
        node: NodeId,
        point: [f32; 3],
    ) -> Option<f32> {
        Some(self.alone(scene, node)?.world.distance(point))
    }

    /// Returns the box of a brush or group alone.
    pub(crate) fn box_of(&mut self, scene: &Scene, node: NodeId) -> Option<argil::math::Aabb> {
        let found = self.alone(scene, node)?.world.program().aabb();
        found.is_finite().then_some(found)
    }

    /// Returns the surface of a brush or group, whatever its operator. `None` if it is infinite.
    pub(crate) fn outline(&mut self, scene: &Scene, node: NodeId) -> Option<&Silhouette> {
        let alone = self.alone(scene, node)?;
        if alone.outline.is_none() {
            alone.outline = Some(outline(&alone.world)?);
        }
        alone.outline.as_ref()
    }

    fn alone(&mut self, scene: &Scene, node: NodeId) -> Option<&mut SingleBrushWorld> {
        let chain = chain(scene, node);
        let is_current = self
            .alone
            .get(&node)
            .is_some_and(|(made, _)| *made == chain);
        if !is_current {
            let made = alone(scene, node, &chain);
            self.alone.insert(node, (chain, made));
        }
        self.alone.get_mut(&node)?.1.as_mut()
    }
}

impl Default for Picker {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns true if a node and all its groups are visible.
pub(crate) fn is_visible(scene: &Scene, node: NodeId) -> bool {
    let mut at = Some(node);
    while let Some(n) = at {
        if !scene.node(n).desc().visible {
            return false;
        }
        at = scene.node(n).parent();
    }
    true
}

/// Returns the descriptions of a node and its groups, and of a group's children, as far as they affect its
/// position.
fn chain(scene: &Scene, node: NodeId) -> Vec<NodeDesc> {
    let mut all = Vec::new();
    let mut at = Some(node);
    while let Some(n) = at {
        all.push(plain(scene.node(n).at_current_time()));
        at = scene.node(n).parent();
    }
    all.reverse();
    if scene.node(node).children().is_empty() {
        return all;
    }
    for inner in scene.descendants(node).filter(|&inner| inner != node) {
        all.push(scene.node(inner).at_current_time().clone());
    }
    all
}

/// Returns a visible union without name, material and keyframes.
fn plain(entry: &NodeDesc) -> NodeDesc {
    NodeDesc {
        name: String::new(),
        visible: true,
        locked: false,
        operator: Operator::default(),
        material: None,
        keyframes: Vec::new(),
        ..entry.clone()
    }
}

fn alone(scene: &Scene, node: NodeId, chain: &[NodeDesc]) -> Option<SingleBrushWorld> {
    let mut reduced = Scene::new();
    let mut parent = Scene::ROOT;
    let mut depth = 0;
    let mut at = scene.node(node).parent();
    while let Some(n) = at {
        depth += 1;
        at = scene.node(n).parent();
    }
    // The first is the root, which every scene has.
    for entry in &chain[1..=depth] {
        parent = reduced.push_into(parent, entry.clone()).ok()?.node;
    }
    copy(scene, node, &mut reduced, parent);
    let world = Engine::cpu().build(&reduced).ok()?.field();
    Some(SingleBrushWorld {
        world,
        outline: None,
    })
}

/// Copies a group's children with their subtrees.
fn copy(scene: &Scene, from: NodeId, reduced: &mut Scene, to: NodeId) {
    for &child in scene.node(from).children() {
        let entry = NodeDesc {
            material: None,
            keyframes: Vec::new(),
            ..scene.node(child).at_current_time().clone()
        };
        let is_group = matches!(entry.kind, NodeKind::Group);
        let entry = if is_group {
            entry_of_group(entry)
        } else {
            entry
        };
        if let Ok(made) = reduced.push_into(to, entry) {
            copy(scene, child, reduced, made.node);
        }
    }
}

/// A group is inserted without children.
fn entry_of_group(entry: NodeDesc) -> NodeDesc {
    let blank: NodeDesc = Group::new().into();
    NodeDesc {
        kind: blank.kind,
        ..entry
    }
}

fn outline(world: &World) -> Option<Silhouette> {
    if !world.program().aabb().is_finite() {
        return None;
    }
    let options = MeshOptions {
        method: MeshMethod::MarchingCubes,
        resolution: OUTLINE_CELLS,
        normals: MeshNormals::Field,
        materials: false,
        ..MeshOptions::default()
    };
    let mesh = ready(world.mesh_async(&options)).ok()?.mesh;
    Some(Silhouette {
        corners: mesh.positions,
        normals: mesh.normals,
        triangles: mesh.triangles,
    })
}

/// Returns the distance of a point from a segment.
pub(crate) fn off_segment(at: Vec2, [a, b]: [Vec2; 2]) -> f32 {
    let along = b - a;
    let t = (at - a).dot(along) / along.length_squared().max(1e-12);
    at.distance(a + along * t.clamp(0.0, 1.0))
}
