//! Solids as Python composes them: immutable trees that share their parts.
//!
//! *Practice.* An operator costs one node. A solid becomes a scene when something is asked of it.

use crate::part::{Part, is_plain_group};
use argil::scene::{
    Brush, Group, Material, Modifier, NodeTree, Operator, OperatorKind, Ramp, Scene, Shape,
};
use std::sync::Arc;

/// Maximum nodes of a scene, counting parts as often as they are used.
const MAX_NODES: usize = 4_000_000;

/// A solid.
#[derive(Debug)]
pub enum Tree {
    Shape(Shape),
    Join {
        operator: Operator,
        ramp: Option<Ramp>,
        left: Arc<Tree>,
        right: Arc<Tree>,
    },
    Modified {
        modifier: Modifier,
        inner: Arc<Tree>,
    },
    Painted {
        material: Material,
        inner: Arc<Tree>,
    },
    Named {
        name: String,
        inner: Arc<Tree>,
    },
    /// Nodes of a scene file.
    Nodes {
        nodes: Vec<NodeTree>,
        materials: Vec<(String, Material)>,
    },
}

/// Chains are as long as programs that build them, so dropping one must not recurse.
impl Drop for Tree {
    fn drop(&mut self) {
        let mut open = Vec::new();
        take_parts(self, &mut open);
        while let Some(part) = open.pop() {
            if let Ok(mut tree) = Arc::try_unwrap(part) {
                take_parts(&mut tree, &mut open);
            }
        }
    }
}

fn take_parts(tree: &mut Tree, open: &mut Vec<Arc<Tree>>) {
    let empty = || Arc::new(Tree::Shape(Shape::sphere(1.0)));
    let is_leaf = |part: &Arc<Tree>| matches!(**part, Tree::Shape(_) | Tree::Nodes { .. });
    let mut take = |part: &mut Arc<Tree>| {
        if !is_leaf(part) {
            open.push(std::mem::replace(part, empty()));
        }
    };
    match tree {
        Tree::Shape(_) | Tree::Nodes { .. } => {}
        Tree::Join { left, right, .. } => {
            take(left);
            take(right);
        }
        Tree::Modified { inner, .. } | Tree::Painted { inner, .. } | Tree::Named { inner, .. } => {
            take(inner);
        }
    }
}

/// What is still to be done while a tree becomes nodes.
enum Step<'a> {
    Visit(&'a Tree),
    Modify(&'a Modifier),
    Paint(&'a Material),
    Name(&'a str),
    Join(&'a Operator, Option<&'a Ramp>),
}

/// The materials of a scene to be.
#[derive(Default)]
struct Materials(Vec<(String, Material)>);

impl Materials {
    fn name_of(&mut self, material: &Material) -> String {
        if let Some((name, _)) = self.0.iter().find(|(_, known)| known == material) {
            return name.clone();
        }
        let name = format!("material {}", self.0.len() + 1);
        self.0.push((name.clone(), material.clone()));
        name
    }

    /// Adds a named material. Returns the name under which it is known, if that differs.
    fn take(&mut self, name: &str, material: Material) -> Option<String> {
        match self.0.iter().find(|(known, _)| known == name) {
            None => {
                self.0.push((name.to_owned(), material));
                None
            }
            Some((_, known_material)) if *known_material == material => None,
            Some(_) => Some(self.name_of(&material)),
        }
    }
}

impl Tree {
    /// Describes what the solid consists of.
    pub fn description(&self) -> String {
        let (mut shapes, mut sampled, mut last, mut open) = (0u64, 0u64, "", vec![self]);
        while let Some(tree) = open.pop() {
            match tree {
                Tree::Shape(shape) => {
                    (shapes, last) = (shapes + 1, shape.kind());
                    let is_sampled = shape
                        .file()
                        .is_some_and(|(name, ..)| name.starts_with("samples-"));
                    sampled += u64::from(is_sampled);
                }
                Tree::Nodes { nodes, .. } => {
                    shapes += nodes
                        .iter()
                        .map(|tree| tree.entries().count() as u64)
                        .sum::<u64>();
                }
                Tree::Join { left, right, .. } => open.extend([&**left, &**right]),
                Tree::Modified { inner, .. }
                | Tree::Painted { inner, .. }
                | Tree::Named { inner, .. } => {
                    open.push(inner);
                }
            }
            if shapes + open.len() as u64 > 1000 {
                return "over 1000 shapes".to_owned();
            }
        }
        match (shapes, sampled) {
            (1, 1) => "one shape of samples".to_owned(),
            (1, _) if !last.is_empty() => format!("one shape, {last}"),
            (count, 0) => format!("{count} shapes"),
            (count, sampled) => format!("{count} shapes, {sampled} of samples"),
        }
    }

    /// Returns the solid as a scene.
    ///
    /// # Errors
    /// If there would be too many nodes, or a node is refused.
    pub fn to_scene(&self) -> Result<Scene, String> {
        let (tree, materials) = self.to_nodes()?;
        let mut scene = Scene::new();
        for (name, material) in materials {
            let set = scene.set_material(name, material);
            set.map_err(|error| error.to_string())?;
        }
        let operands = if is_plain_group(&tree) {
            take_children(tree)
        } else {
            vec![tree]
        };
        for operand in operands {
            scene.push(operand).map_err(|error| error.to_string())?;
        }
        scene.forget_history(0);
        Ok(scene)
    }

    /// Returns the solid as one node, with its materials.
    pub fn to_nodes(&self) -> Result<(NodeTree, Vec<(String, Material)>), String> {
        let mut steps = vec![Step::Visit(self)];
        let mut done: Vec<Part> = Vec::new();
        let mut materials = Materials::default();
        let mut count = 0;
        while let Some(step) = steps.pop() {
            match step {
                Step::Visit(tree) => {
                    count += 1;
                    if count > MAX_NODES {
                        return Err(format!(
                            "the solid has more than {MAX_NODES} parts, counted as often as they are used"
                        ));
                    }
                    visit(tree, &mut steps, &mut done, &mut materials)?;
                }
                Step::Modify(modifier) => {
                    if let Some(top) = done.last_mut() {
                        top.modify(modifier)?;
                    }
                }
                Step::Paint(material) => {
                    let name = materials.name_of(material);
                    if let Some(top) = done.last_mut() {
                        top.tree_mut().desc.material.get_or_insert(name);
                    }
                }
                Step::Name(name) => {
                    if let Some(top) = done.last_mut() {
                        name.clone_into(&mut top.tree_mut().desc.name);
                    }
                }
                Step::Join(operator, ramp) => {
                    let right = done.pop();
                    if let (Some(left), Some(right)) = (done.last_mut(), right) {
                        left.join(right, operator, ramp)?;
                    }
                }
            }
        }
        let tree = done.pop().map(Part::into_tree);
        Ok((tree.unwrap_or_else(|| Group::new().into()), materials.0))
    }
}

fn visit<'a>(
    tree: &'a Tree,
    steps: &mut Vec<Step<'a>>,
    done: &mut Vec<Part>,
    materials: &mut Materials,
) -> Result<(), String> {
    match tree {
        Tree::Shape(shape) => done.push(Part::new(Brush::new(shape.clone()).into())),
        Tree::Join {
            operator,
            ramp,
            left,
            right,
        } => {
            steps.push(Step::Join(operator, ramp.as_ref()));
            steps.push(Step::Visit(right));
            steps.push(Step::Visit(left));
        }
        Tree::Modified { modifier, inner } => {
            steps.push(Step::Modify(modifier));
            steps.push(Step::Visit(inner));
        }
        Tree::Painted { material, inner } => {
            steps.push(Step::Paint(material));
            steps.push(Step::Visit(inner));
        }
        Tree::Named { name, inner } => {
            steps.push(Step::Name(name));
            steps.push(Step::Visit(inner));
        }
        Tree::Nodes {
            nodes,
            materials: materials_of_nodes,
        } => {
            let mut group: NodeTree = Group::new().into();
            group.children = nodes.clone();
            let renamed: Vec<(String, String)> = materials_of_nodes
                .iter()
                .filter_map(|(name, material)| {
                    Some((name.clone(), materials.take(name, material.clone())?))
                })
                .collect();
            rename(&mut group, &renamed);
            done.push(Part::of_nodes(group)?);
        }
    }
    Ok(())
}

fn rename(tree: &mut NodeTree, names: &[(String, String)]) {
    let mut open = vec![tree];
    while let Some(tree) = open.pop() {
        if let Some(name) = &mut tree.desc.material
            && let Some((_, to)) = names.iter().find(|(from, _)| from == name)
        {
            name.clone_from(to);
        }
        open.extend(&mut tree.children);
    }
}

fn take_children(mut tree: NodeTree) -> Vec<NodeTree> {
    std::mem::take(&mut tree.children)
}

/// Returns the nodes of a scene as a solid, in the order of its list.
pub fn of_scene(scene: &Scene) -> Tree {
    let root = scene.node(Scene::ROOT).children();
    Tree::Nodes {
        nodes: root
            .iter()
            .map(|&id| scene.subtree_at_current_time(id))
            .collect(),
        materials: scene
            .materials()
            .iter()
            .map(|(name, material)| (name.clone(), material.clone()))
            .collect(),
    }
}

/// Returns the part of a solid in a box of a scene's axes.
pub fn within(inner: Arc<Tree>, limits: argil::math::Aabb) -> Tree {
    let limit = Tree::Modified {
        modifier: Modifier::Translate {
            by: limits.center().to_array(),
        },
        inner: Arc::new(Tree::Shape(Shape::cuboid((0.5 * limits.size()).to_array()))),
    };
    Tree::Join {
        operator: Operator {
            kind: OperatorKind::Intersect,
            ..Operator::default()
        },
        ramp: None,
        left: inner,
        right: Arc::new(limit),
    }
}

/// Returns a solid of everything but another one.
pub fn complement(inner: Arc<Tree>) -> Tree {
    let everything = Shape::cuboid([argil::scene::MAX_LENGTH; 3]);
    Tree::Join {
        operator: Operator {
            kind: OperatorKind::Subtract,
            ..Operator::default()
        },
        ramp: None,
        left: Arc::new(Tree::Shape(everything)),
        right: inner,
    }
}
