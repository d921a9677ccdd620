//! Edits, their undoing, and the boxes they make dirty.

use crate::bounds::Extents;
use crate::change::SceneChange;
use crate::history::{HistoryStep, is_covered};
use crate::influence::influence;
use crate::node::pose_of;
use crate::transform::push_transform;
use crate::{Material, Modifier, NodeDesc, NodeId, NodeKind, NodeTree, Scene, ValidationError};
use argil_math::Aabb;

/// A change of a scene that can be undone.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Edit {
    /// Put a brush or an empty group into a group, before what is at `index` now.
    Insert {
        /// The group.
        parent: NodeId,
        /// Where in the group, from 0 to its length.
        index: usize,
        /// What to put there.
        entry: NodeDesc,
    },
    /// Take a brush, or a group with all that it holds, out of the scene.
    Remove {
        /// Which.
        node: NodeId,
    },
    /// Give a node another entry. A group stays a group and keeps what it holds.
    Replace {
        /// Which.
        node: NodeId,
        /// What it becomes.
        entry: NodeDesc,
    },
    /// Put a node elsewhere in the order, or into another group.
    Move {
        /// Which.
        node: NodeId,
        /// The group it goes to.
        parent: NodeId,
        /// Its index there, counted without the node itself.
        index: usize,
    },
    /// Show or hide a node.
    SetVisible {
        /// Which.
        node: NodeId,
        /// Whether it takes part.
        visible: bool,
    },
    /// Translate, rotate or scale a node once more. Translations in a row add up, and so do rotations about one axis; more than six
    /// transforms in a row become a scale, a rotation and a translation that do the same.
    Transform {
        /// Which.
        node: NodeId,
        /// A translate, rotate or scale modifier.
        by: Modifier,
    },
    /// Add or change a material, or take one away that no brush uses.
    SetMaterial {
        /// Its name.
        name: String,
        /// What it becomes; nothing to take it away.
        material: Option<Material>,
    },
}

/// The group that a node is in, where it matters within each of two bands, and those.
type Boxes = (Option<NodeId>, [Aabb; 2], [f32; 2]);

/// What an edit did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EditOutcome {
    /// The node that was made or changed.
    pub node: NodeId,
    /// Outside this box no distance below the first of the scene's [bands](Scene::margins) changed, nor did a material.
    pub dirty_box: Aabb,
}

/// Why an edit was refused. The scene is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The node is not in the scene now, or is of another scene.
    #[error("node {0:?} is not in the scene")]
    NoSuchNode(NodeId),
    /// Something was to be put into a brush.
    #[error("{0} is a brush: only a group can hold others")]
    NotAGroup(String),
    /// The index lies beyond the group's end.
    #[error("index {index} lies beyond the end of the group, {len}")]
    BadIndex {
        /// The index asked for.
        index: usize,
        /// The group's length.
        len: usize,
    },
    /// The group of everything was to be removed, moved or changed.
    #[error("the root group cannot be removed, moved or replaced")]
    Root,
    /// A group was to be put into itself.
    #[error("{0} cannot be moved into itself")]
    IntoItself(String),
    /// A brush was to become a group or the other way round.
    #[error("{0} cannot change between brush and group: remove it and insert another")]
    OtherKind(String),
    /// A modifier that is not a translation, rotation or scale.
    #[error(
        "only translate, rotate and scale transform a node: replace its entry to change other modifiers"
    )]
    NotATransform,
    /// The entry names a material that the scene does not have.
    #[error("material: the scene has no material \"{0}\"")]
    NoSuchMaterial(String),
    /// A material that is used was to be taken away.
    #[error("material: {user} uses \"{name}\": give it another first")]
    MaterialInUse {
        /// The material.
        name: String,
        /// Who uses it.
        user: String,
    },
    /// A tree to be inserted is a brush that has children.
    #[error("a brush has a \"shape\" and a group has \"brushes\": this has both")]
    BrushWithChildren,
    /// A value in the entry cannot be used.
    #[error(transparent)]
    Fault(#[from] ValidationError),
}

impl Scene {
    /// Put a brush or an empty group at the end of the scene.
    ///
    /// # Errors
    /// If a value is invalid, a brush has children, or a material is missing. The scene stays unchanged.
    pub fn push(&mut self, entry: impl Into<NodeTree>) -> Result<EditOutcome, EditError> {
        self.push_into(Self::ROOT, entry)
    }

    /// Put a brush or an empty group at the end of a group.
    ///
    /// # Errors
    /// If `parent` is not a group of the scene, a value is invalid, a brush has children, or a material is missing. The scene stays unchanged.
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

    /// Do an edit. What was undone before can then not be redone.
    ///
    /// # Errors
    /// If the edit cannot be applied: see [`EditError`]. The scene stays unchanged.
    pub fn apply(&mut self, edit: Edit) -> Result<EditOutcome, EditError> {
        let step = self.step(edit)?;
        let (edited, inverse) = self.take(step);
        let history = &mut self.history;
        history.redo.clear();
        let added = inverse.bytes();
        match history.undo.last_mut().filter(|_| history.is_stroke) {
            // Of what a stroke changes again and again, what there was at first is enough.
            Some(stroke) if is_covered(stroke.last(), &inverse) => return Ok(edited),
            Some(stroke) => stroke.push(inverse),
            None => history.undo.push(vec![inverse]),
        }
        self.keep_to_limit(added);
        Ok(edited)
    }

    /// Drops the oldest steps if there are more than the limit allows, now that one of so many bytes was added.
    pub(crate) fn keep_to_limit(&mut self, added: u64) {
        if self.history.is_over_limit(added) {
            let steps = self.history.steps_within_limit();
            self.drop_history(steps);
        }
    }

    /// Check an edit and turn it into a step.
    fn step(&mut self, edit: Edit) -> Result<HistoryStep, EditError> {
        Ok(match edit {
            Edit::Insert {
                parent,
                index,
                mut entry,
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
            Edit::Replace { node, mut entry } => {
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
                let nth = entry.modifiers.len();
                by.check()
                    .map_err(|fault| fault.within(&format!("modifiers[{nth}]")))?;
                push_transform(&mut entry.modifiers, by);
                self.check_entry(&entry)?;
                HistoryStep::Set { node, entry }
            }
            Edit::SetMaterial { name, material } => {
                match &material {
                    Some(material) => material.check()?,
                    None => self.check_unused(&name)?,
                }
                HistoryStep::SetMaterial { name, material }
            }
        })
    }

    /// Take a checked step; the step back.
    pub(crate) fn take(&mut self, step: HistoryStep) -> (EditOutcome, HistoryStep) {
        let node = match step {
            HistoryStep::Attach { node, .. }
            | HistoryStep::Detach { node }
            | HistoryStep::Set { node, .. }
            | HistoryStep::Move { node, .. } => node,
            HistoryStep::SetMaterial { .. } => Self::ROOT,
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
                // It may be from before its mesh was there.
                self.load(&mut entry);
                self.count(node, false);
                let own = &mut self.nodes[node.index()];
                std::mem::swap(&mut own.desc, &mut entry);
                own.evaluated = pose_of(&own.desc, self.time);
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
            HistoryStep::SetMaterial { name, material } => {
                return self.take_material(name, material);
            }
        };
        let dirty_box = self.note(node, before);
        (EditOutcome { node, dirty_box }, inverse)
    }

    fn take_material(
        &mut self,
        name: String,
        material: Option<Material>,
    ) -> (EditOutcome, HistoryStep) {
        let before = match material {
            Some(material) => self.materials.insert(name.clone(), material),
            None => self.materials.remove(&name),
        };
        self.history.note(SceneChange::of_everything());
        let edited = EditOutcome {
            node: Self::ROOT,
            dirty_box: Aabb::ALL,
        };
        let inverse = HistoryStep::SetMaterial {
            name,
            material: before,
        };
        (edited, inverse)
    }

    /// Let a node with keyframes act otherwise.
    pub(crate) fn pose(&mut self, node: NodeId, posed: NodeDesc) {
        let before = self.boxes(node);
        self.count(node, false);
        self.nodes[node.index()].evaluated = Some(Box::new(posed));
        self.count(node, true);
        self.note(node, before);
    }

    /// Take note of a change, by what a node was before; the box that it makes dirty.
    fn note(&mut self, node: NodeId, before: Boxes) -> Aabb {
        let after = self.boxes(node);
        let [dirty_box, far_box] = [0, 1].map(|i| before.1[i].union(after.1[i]));
        self.history.note(SceneChange {
            node: Some(node),
            parents: [before.0, after.0],
            dirty_box,
            influence_box: far_box,
            // What both hold.
            margins: [0, 1].map(|i| before.2[i].min(after.2[i])),
            apart: [before.1, after.1],
        });
        dirty_box
    }

    /// The group that a node is in, and where it matters, within each of the bands.
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
        // Time may have gone on while it was away.
        let time = self.time;
        let moving: Vec<NodeId> = self
            .descendants(node)
            .filter(|&id| !self.node(id).desc.keyframes.is_empty())
            .collect();
        for id in moving {
            let own = &mut self.nodes[id.index()];
            own.evaluated = pose_of(&own.desc, time);
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
