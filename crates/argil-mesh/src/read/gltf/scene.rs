//! Walks through a glTF file's nodes, and places their meshes.

use super::super::budget::{Budget, Purpose, place};
use super::super::error::ReadFault;
use super::super::file::MeshFile;
use super::super::strips::{fan, strip};
use super::data::{Accessor, Data};
use super::extensions::draco;
use super::json::{InstanceAttributes, MeshJson, Node, Primitive, Root, Scene, element};
use crate::Mesh;
use glam::{Mat4, Quat, Vec3};
use std::collections::BTreeMap;
use std::rc::Rc;

/// Maximum indices of a primitive.
const MAX_INDICES: usize = 3 * super::super::error::MAX_TRIANGLES;

/// What is left out, counted.
#[derive(Default)]
struct LeftOut {
    points_and_lines: u64,
    skinned: u64,
    morphed: u64,
    hidden: u64,
    elsewhere: u64,
}

impl LeftOut {
    fn warnings(&self) -> Vec<String> {
        let describe = |count: u64, what: &str, result: &str| {
            (count > 0).then(|| format!("{what}: {count}; they are {result}"))
        };
        let out = "left out";
        [
            describe(self.points_and_lines, "parts that are points or lines", out),
            describe(
                self.skinned,
                "meshes with a skeleton",
                "read as they are stored, without its pose",
            ),
            describe(
                self.morphed,
                "meshes with morph targets",
                "read without them",
            ),
            describe(self.hidden, "nodes that are hidden", out),
            describe(
                self.elsewhere,
                "nodes with meshes outside the default scene",
                out,
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// Where a mesh is.
#[derive(Default)]
struct Places {
    scene_from_mesh: Vec<Mat4>,
    nodes: u64,
    /// Nodes with weights of morph targets.
    morphed: u64,
}

struct Reader<'a> {
    data: Data<'a>,
    root: &'a Root<'a>,
    /// The places of each mesh. Each is read once.
    places: BTreeMap<usize, Places>,
    copies: Budget,
    mesh: Mesh,
    left_out: LeftOut,
}

/// Returns the nodes without a parent in the default scene, or in all if there is none.
fn first_nodes(root: &Root<'_>) -> Result<Vec<usize>, ReadFault> {
    let scene = |index| element::<Scene>(&root.scenes, index, "scene");
    if let Some(index) = root.scene {
        return Ok(scene(index)?.nodes);
    }
    let mut all = Vec::new();
    for index in 0..root.scenes.len() {
        all.extend(scene(index)?.nodes);
    }
    if root.scenes.is_empty() {
        let mut is_child = vec![false; root.nodes.len()];
        for index in 0..root.nodes.len() {
            for child in element::<Node>(&root.nodes, index, "node")?.children {
                if let Some(is_child) = is_child.get_mut(child) {
                    *is_child = true;
                }
            }
        }
        all.extend((0..root.nodes.len()).filter(|&i| !is_child[i]));
    }
    all.sort_unstable();
    all.dedup();
    Ok(all)
}

pub(super) fn read(
    root: &Root<'_>,
    data: Data<'_>,
    file_bytes: usize,
) -> Result<MeshFile, ReadFault> {
    let mut reader = Reader {
        data,
        root,
        places: BTreeMap::new(),
        copies: Budget::new(Purpose::Copies, file_bytes),
        mesh: Mesh::default(),
        left_out: LeftOut::default(),
    };
    let mut is_seen = vec![false; root.nodes.len()];
    let first = first_nodes(root)?;
    let mut open: Vec<(usize, Mat4, bool)> = first
        .iter()
        .rev()
        .map(|&i| (i, Mat4::IDENTITY, true))
        .collect();
    while let Some((index, parent, is_visible)) = open.pop() {
        let node: Node = element(&root.nodes, index, "node")?;
        if std::mem::replace(&mut is_seen[index], true) {
            return Err(format!("node {index} has two parents").into());
        }
        let scene_from_node = parent * node.parent_from_node();
        let is_visible = is_visible && node.is_visible();
        open.extend(
            node.children
                .iter()
                .rev()
                .map(|&i| (i, scene_from_node, is_visible)),
        );
        if node.mesh.is_some() && !is_visible {
            reader.left_out.hidden += 1;
        } else if node.mesh.is_some() {
            reader
                .node(&node, scene_from_node)
                .map_err(|fault| fault.within(&format!("node {index}")))?;
        }
    }
    for (index, places) in std::mem::take(&mut reader.places) {
        reader
            .mesh(index, &places)
            .map_err(|fault| fault.within(&format!("mesh {index}")))?;
    }
    for index in (0..root.nodes.len()).filter(|&i| !is_seen[i]) {
        let has_mesh =
            element::<Node>(&root.nodes, index, "node").is_ok_and(|node| node.mesh.is_some());
        reader.left_out.elsewhere += u64::from(has_mesh);
    }
    Ok(MeshFile {
        warnings: reader.left_out.warnings(),
        mesh: reader.mesh,
    })
}

impl Reader<'_> {
    /// Notes the places of a node's mesh, one for each instance.
    fn node(&mut self, node: &Node, scene_from_node: Mat4) -> Result<(), ReadFault> {
        let all = match &node.extensions.instancing {
            Some(instancing) => self.instances(&instancing.attributes)?,
            None => vec![Mat4::IDENTITY],
        };
        self.left_out.skinned += u64::from(node.skin.is_some());
        let index = node.mesh.unwrap_or_default();
        let places = self.places.entry(index).or_default();
        places.nodes += 1;
        places.morphed += u64::from(node.is_morphed());
        let placed = all.into_iter().map(|instance| scene_from_node * instance);
        places.scene_from_mesh.extend(placed);
        Ok(())
    }

    /// Adds a mesh in its places.
    fn mesh(&mut self, index: usize, places: &Places) -> Result<(), ReadFault> {
        let mesh: MeshJson<'_> = element(&self.root.meshes, index, "mesh")?;
        self.left_out.morphed += match mesh.is_morphed() {
            true => places.nodes,
            false => places.morphed,
        };
        for number in 0..mesh.primitives.len() {
            let primitive: Primitive<'_> = element(&mesh.primitives, number, "primitive")?;
            if primitive.mode() < 4 {
                self.left_out.points_and_lines += places.nodes;
                continue;
            }
            let part = self.primitive(&primitive)?;
            if part.triangles.is_empty() {
                continue;
            }
            self.copies.take_copies(
                places.scene_from_mesh.len(),
                part.positions.len(),
                part.triangles.len(),
            )?;
            for scene_from_mesh in &places.scene_from_mesh {
                place(
                    &part.positions,
                    &part.triangles,
                    *scene_from_mesh,
                    &mut self.mesh,
                );
            }
        }
        Ok(())
    }

    /// Returns the transforms of a node's instances.
    fn instances(&mut self, attributes: &InstanceAttributes) -> Result<Vec<Mat4>, ReadFault> {
        let mut open = |index: Option<usize>, shape| {
            index
                .map(|index| self.data.accessor(index, shape))
                .transpose()
        };
        let translation = open(attributes.translation, "VEC3")?;
        let rotation = open(attributes.rotation, "VEC4")?;
        let scale = open(attributes.scale, "VEC3")?;
        let all = [&translation, &rotation, &scale];
        let counts = all.into_iter().flatten().map(|accessor| accessor.count);
        let count = counts.min().unwrap_or(1);
        self.copies
            .take((count as u64).saturating_mul(size_of::<Mat4>() as u64))?;
        let vec3 = |accessors: &Option<Rc<Accessor<'_>>>, i: usize, default: Vec3| {
            accessors.as_ref().map_or(default, |vectors| {
                let [x, y, z, _] = vectors.vector(i);
                Vec3::new(x, y, z)
            })
        };
        let place = |i: usize| {
            let rotation = rotation
                .as_ref()
                .map(|quaternions| Quat::from_array(quaternions.vector(i)));
            let rotation = rotation.filter(|q| q.length_squared() > 0.0);
            Mat4::from_scale_rotation_translation(
                vec3(&scale, i, Vec3::ONE),
                rotation.unwrap_or_default().normalize(),
                vec3(&translation, i, Vec3::ZERO),
            )
        };
        Ok((0..count).map(place).collect())
    }

    /// Returns a primitive's triangles, with the vertices that they use.
    fn primitive(&mut self, json: &Primitive<'_>) -> Result<Mesh, ReadFault> {
        let position = json.attributes.position.ok_or("a part has no positions")?;
        let positions = self.data.accessor(position, "VEC3");
        let positions = positions.map_err(|fault| {
            if json.extensions.draco.is_some() {
                draco()
            } else {
                fault
            }
        })?;
        let mut corners: Vec<u32> = match json.indices {
            Some(index) => {
                let indices = self.data.accessor(index, "SCALAR")?;
                if !indices.has_indices() {
                    return Err(
                        format!("accessor {index}: unsupported component type of indices").into(),
                    );
                }
                check_count(indices.count)?;
                (0..indices.count).map(|i| indices.index(i)).collect()
            }
            None => {
                check_count(positions.count)?;
                (0..positions.count as u32).collect()
            }
        };
        let mut used = corners.clone();
        used.sort_unstable();
        used.dedup();
        if used
            .last()
            .is_some_and(|&last| last as usize >= positions.count)
        {
            return Err("a triangle refers to a missing vertex".into());
        }
        // Without gaps, each vertex stays where it is.
        if used.len() < positions.count {
            for corner in &mut corners {
                *corner = used.partition_point(|i| i < corner) as u32;
            }
        }
        let point = |&i: &u32| {
            let [x, y, z, _] = positions.vector(i as usize);
            Vec3::new(x, y, z)
        };
        Ok(Mesh {
            positions: used.iter().map(point).collect(),
            triangles: match json.mode() {
                4 => corners.as_chunks::<3>().0.to_vec(),
                5 => strip(&corners).collect(),
                6 => fan(&corners).collect(),
                mode => return Err(format!("a part has the unknown mode {mode}").into()),
            },
            ..Mesh::default()
        })
    }
}

/// Refuses absurd numbers of corners, before there is memory for them.
fn check_count(count: usize) -> Result<(), ReadFault> {
    if count <= MAX_INDICES {
        return Ok(());
    }
    Err(ReadFault::TooLarge(format!(
        "a part has {count} corners, and {MAX_INDICES} can be read"
    )))
}
