//! Edits, their undo steps, and their dirty boxes.

use crate::bounds::Extents;
use crate::change::SceneChange;
use crate::history::{HistoryStep, is_covered};
use crate::influence::influence;
use crate::node::pose_of;
use crate::transform::push_transform;
use crate::{
    Material, Modifier, NodeDesc, NodeId, NodeKind, NodeTree, Scene, ValidationError, View,
};
use argil_math::Aabb;

/// A change of a scene that can be undone.
///
/// ```
/// use argil_scene::{Edit, Modifier, Scene, Shape};
/// let mut scene = Scene::new();
/// let node = scene.push(Shape::sphere(1.0))?.node;
/// let by = Modifier::Translate { by: [2.0, 0.0, 0.0] };
/// let outcome = scene.apply(Edit::Transform { node, by })?;
/// assert!(outcome.dirty_box.contains([3.0, 0.0, 0.0].into()));
/// # Ok::<(), argil_scene::EditError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Edit {
    /// Inserts a brush or an empty group into a group, before the node at `index`.
    Insert {
        /// The group to insert into.
        parent: NodeId,
        /// Index in the group, from 0 to its length.
        index: usize,
        /// The brush or group to insert.
        desc: NodeDesc,
    },
    /// Removes a brush, or a group with its contents.
    Remove {
        /// The node to remove.
        node: NodeId,
    },
    /// Replaces a node's description. A group stays a group and keeps its contents.
    Replace {
        /// The node to replace.
        node: NodeId,
        /// The new description.
        desc: NodeDesc,
    },
    /// Moves a node to another place in its group, or to another group.
    Move {
        /// The node to move.
        node: NodeId,
        /// The group to move it to.
        parent: NodeId,
        /// The new index there, not counting the node itself.
        index: usize,
    },
    /// Shows or hides a node.
    SetVisible {
        /// The node to show or hide.
        node: NodeId,
        /// Whether the node takes part in the solid.
        visible: bool,
    },
    /// Appends a translation, rotation or scale to a node. Consecutive translations add up, and so do rotations
    /// about one axis. More than six transforms in a row become one scale, one rotation and one translation.
    Transform {
        /// The node to transform.
        node: NodeId,
        /// A translate, rotate or scale modifier.
        by: Modifier,
    },
    /// Adds or changes a material, or removes one that no node uses.
    SetMaterial {
        /// The material's name.
        name: String,
        /// The new material, or `None` to remove it.
        material: Option<Material>,
    },
    /// Replaces the view: camera, lights, and how pictures are developed.
    SetView {
        /// The new view.
        view: Box<View>,
    },
}

/// The group of a node, its boxes for both margins, and those margins.
type Boxes = (Option<NodeId>, [Aabb; 2], [f32; 2]);

/// What an edit changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EditOutcome {
    /// The node that was created or changed.
    pub node: NodeId,
    /// Outside this box, no distance below the first [margin](Scene::margins) changed, and no material.
    pub dirty_box: Aabb,
}

/// The reason why an edit was refused. The scene stays unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The node is not in the scene, or belongs to another scene.
    #[error("node {0:?} is not in the scene")]
    NoSuchNode(NodeId),
    /// The target is a brush, which cannot contain nodes.
    #[error("{0} is a brush: only groups have children")]
    NotAGroup(String),
    /// The index is beyond the end of the group.
    #[error("index {index} is past the end of the group, which has {len} children")]
    BadIndex {
        /// The requested index.
        index: usize,
        /// The length of the group.
        len: usize,
    },
    /// The root group cannot be removed, moved or replaced.
    #[error("the root group cannot be removed, moved or replaced")]
    Root,
    /// A group cannot move into itself.
    #[error("{0} cannot be moved into itself")]
    IntoItself(String),
    /// A brush cannot become a group, or a group a brush.
    #[error("{0} cannot change between brush and group: remove it and insert a new one")]
    OtherKind(String),
    /// The modifier is not a translation, rotation or scale.
    #[error(
        "only translate, rotate and scale can be set this way: replace the node to change other modifiers"
    )]
    NotATransform,
    /// The description names a material that the scene does not have.
    #[error("material: the scene has no material \"{0}\"")]
    NoSuchMaterial(String),
    /// The material to remove is in use.
    #[error("material: {user} uses \"{name}\": assign another material to it first")]
    MaterialInUse {
        /// The material's name.
        name: String,
        /// The node that uses it.
        user: String,
    },
    /// The tree to insert is a brush with children.
    #[error("a brush has a \"shape\" and a group has \"brushes\": this has both")]
    BrushWithChildren,
    /// A value is out of range.
    #[error(transparent)]
    Fault(#[from] ValidationError),
}

impl Scene {
    /// Appends a brush, a group or a tree to the scene.
    ///
    /// # Errors
    /// If a value is out of range, a brush has children, or a material is missing. The scene stays unchanged.
    pub fn push(&mut self, entry: impl Into<NodeTree>) -> Result<EditOutcome, EditError> {
        self.push_into(Self::ROOT, entry)
    }

    /// Appends a brush, a group or a tree to a group.
    ///
    /// # Errors
    /// If `parent` is not a group of the scene, a value is out of range, a brush has children, or a material is
    /// missing. The scene stays unchanged.
    pub fn push_into(
        &mut self,
        parent: NodeId,
        entry: impl Into<NodeTree>,
    ) -> Result<EditOutcome, EditError> {
        let index = self
            .get(parent)
            .ok_or(EditError::NoSuchNode(parent))?
            .children
            .len();
        self.insert_tree(parent, index, &entry.into())
    }

    /// Applies an edit. What was undone before can no longer be redone.
    ///
    /// # Errors
    /// If the edit is refused: see [`EditError`]. The scene stays unchanged.
    pub fn apply(&mut self, edit: Edit) -> Result<EditOutcome, EditError> {
        let step = self.step(edit)?;
        Ok(self.apply_step(step))
    }

    /// Takes a checked step, as a new one.
    pub(crate) fn apply_step(&mut self, step: HistoryStep) -> EditOutcome {
        let (edited, inverse) = self.take(step);
        let history = &mut self.history;
        history.redo.clear();
        let added = inverse.bytes();
        match history.undo.last_mut().filter(|_| history.is_stroke) {
            // A stroke that changes a node repeatedly keeps only the node's first state.
            Some(stroke) if is_covered(stroke.last(), &inverse) => return edited,
            Some(stroke) => stroke.push(inverse),
            None => history.undo.push(vec![inverse]),
        }
        self.keep_to_limit(added);
        edited
    }

    /// Drops the oldest steps if the history exceeds its limit, after a step of a number of bytes was added.
    pub(crate) fn keep_to_limit(&mut self, added: u64) {
        if self.history.is_over_limit(added) {
            let steps = self.history.steps_within_limit();
            self.drop_history(steps);
        }
    }

    /// Checks an edit and turns it into a step.
    fn step(&mut self, edit: Edit) -> Result<HistoryStep, EditError> {
        Ok(match edit {
            Edit::Insert {
                parent,
                index,
                desc: mut entry,
            } => {
                self.check_entry(&entry)?;
                self.load(&mut entry);
                self.check_place(parent, index)?;
                let node = self.add_node(entry, None);
                HistoryStep::Attach {
                    node,
                    parent,
                    index,
                }
            }
            Edit::Remove { node } => {
                self.check_inner(node)?;
                HistoryStep::Detach { node }
            }
            Edit::Replace {
                node,
                desc: mut entry,
            } => {
                self.check_inner(node)?;
                self.check_entry(&entry)?;
                self.load(&mut entry);
                let same = matches!(self.node(node).desc.kind, NodeKind::Group)
                    == matches!(entry.kind, NodeKind::Group);
                if !same {
                    return Err(EditError::OtherKind(self.path(node)));
                }
                HistoryStep::Set { node, entry }
            }
            Edit::Move {
                node,
                parent,
                index,
            } => {
                self.check_inner(node)?;
                self.check_outside(parent, node)?;
                let own_place = usize::from(self.node(node).parent == Some(parent));
                self.check_place(parent, index.saturating_add(own_place))?;
                HistoryStep::Move {
                    node,
                    parent,
                    index,
                }
            }
            Edit::SetVisible { node, visible } => {
                self.check_inner(node)?;
                HistoryStep::Set {
                    node,
                    entry: NodeDesc {
                        visible,
                        ..self.node(node).desc.clone()
                    },
                }
            }
            Edit::Transform { node, by } => {
                self.check_inner(node)?;
                if !by.is_similarity() {
                    return Err(EditError::NotATransform);
                }
                let mut entry = self.node(node).desc.clone();
                let position = entry.modifiers.len();
                by.check()
                    .map_err(|fault| fault.within(&format!("modifiers[{position}]")))?;
                push_transform(&mut entry.modifiers, by);
                self.check_entry(&entry)?;
                HistoryStep::Set { node, entry }
            }
            Edit::SetMaterial { name, material } => self.material_step(name, material)?,
            Edit::SetView { view } => {
                view.check()?;
                HistoryStep::SetView { view }
            }
        })
    }

    /// Takes a checked step. Returns the step that reverses it.
    pub(crate) fn take(&mut self, step: HistoryStep) -> (EditOutcome, HistoryStep) {
        let node = match step {
            HistoryStep::Attach { node, .. }
            | HistoryStep::Detach { node }
            | HistoryStep::Set { node, .. }
            | HistoryStep::Move { node, .. } => node,
            HistoryStep::SetMaterial { .. } | HistoryStep::SetView { .. } => Self::ROOT,
        };
        let before = self.boxes(node);
        let inverse = match step {
            HistoryStep::Attach {
                node,
                parent,
                index,
            } => {
                self.attach(node, parent, index);
                HistoryStep::Detach { node }
            }
            HistoryStep::Detach { node } => {
                let (parent, index) = self.detach(node);
                HistoryStep::Attach {
                    node,
                    parent,
                    index,
                }
            }
            HistoryStep::Set { node, mut entry } => {
                // The description may be older than its mesh.
                self.load(&mut entry);
                self.count(node, false);
                let stored = &mut self.nodes[node.index()];
                std::mem::swap(&mut stored.desc, &mut entry);
                stored.evaluated = pose_of(&stored.desc, self.time);
                self.count(node, true);
                HistoryStep::Set { node, entry }
            }
            HistoryStep::Move {
                node,
                parent,
                index,
            } => {
                let (old_parent, old_index) = self.detach(node);
                self.attach(node, parent, index);
                HistoryStep::Move {
                    node,
                    parent: old_parent,
                    index: old_index,
                }
            }
            HistoryStep::SetMaterial {
                name,
                material,
                place,
            } => {
                return self.take_material(name, material, place);
            }
            HistoryStep::SetView { view } => return self.take_view(*view),
        };
        let dirty_box = self.note(node, before);
        (EditOutcome { node, dirty_box }, inverse)
    }

    /// Sets the current state of a node with keyframes.
    pub(crate) fn pose(&mut self, node: NodeId, posed: NodeDesc) {
        let before = self.boxes(node);
        self.count(node, false);
        self.nodes[node.index()].evaluated = Some(Box::new(posed));
        self.count(node, true);
        self.note(node, before);
    }

    /// Records a change, given the node's boxes before it. Returns the dirty box.
    fn note(&mut self, node: NodeId, before: Boxes) -> Aabb {
        let after = self.boxes(node);
        let [dirty_box, far_box] = [0, 1].map(|i| before.1[i].union(after.1[i]));
        self.history.note(SceneChange {
            node: Some(node),
            parents: [before.0, after.0],
            dirty_box,
            influence_box: far_box,
            // The margins that both boxes have.
            margins: [0, 1].map(|i| before.2[i].min(after.2[i])),
            is_unused_material: false,
            apart: [before.1, after.1],
        });
        dirty_box
    }

    /// Returns a node's group, and its boxes for each margin.
    fn boxes(&mut self, node: NodeId) -> Boxes {
        self.summarize_groups(node);
        let mut extents = Extents::of(self);
        let bands = self.margins();
        let boxes = bands.map(|band| influence(self, &mut extents, node, band));
        (self.node(node).parent, boxes, bands)
    }

    fn attach(&mut self, node: NodeId, parent: NodeId, index: usize) {
        self.nodes[parent.index()].children.insert(index, node);
        self.nodes[node.index()].parent = Some(parent);
        // The scene's time may have changed while the node was removed.
        let time = self.time;
        let moving: Vec<NodeId> = self
            .descendants(node)
            .filter(|&id| !self.node(id).desc.keyframes.is_empty())
            .collect();
        for id in moving {
            let stored = &mut self.nodes[id.index()];
            stored.evaluated = pose_of(&stored.desc, time);
        }
        self.count(node, true);
    }

    fn detach(&mut self, node: NodeId) -> (NodeId, usize) {
        self.count(node, false);
        let parent = self.nodes[node.index()].parent.take().unwrap_or(Self::ROOT);
        let siblings = &mut self.nodes[parent.index()].children;
        let index = siblings
            .iter()
            .rposition(|&c| c == node)
            .expect("a node is among its parent's children");
        siblings.remove(index);
        (parent, index)
    }
}
