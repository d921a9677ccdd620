//! How strokes are made.

use argil::glam::Vec3;
use argil::scene::{Group, Modifier, NodeDesc, NodeId, Operator, OperatorKind};

/// What a stroke does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum SculptKind {
    /// Add.
    #[default]
    Add,
    /// Take away.
    Carve,
    /// Widen blends.
    Smooth,
    /// Give a material.
    Paint,
}

impl SculptKind {
    pub(crate) const ALL: [Self; 4] = [Self::Add, Self::Carve, Self::Smooth, Self::Paint];

    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Add => "Add",
            Self::Carve => "Carve",
            Self::Smooth => "Smooth",
            Self::Paint => "Paint",
        }
    }
}

/// How strokes are made, and the one that is.
#[derive(Debug)]
pub(crate) struct Sculpting {
    /// What it does.
    pub kind: SculptKind,
    /// In the scene's unit.
    pub radius: f32,
    /// From 0 to 1: how far it stands out, or how fast it smooths.
    pub strength: f32,
    /// Planes through the origin at which strokes are mirrored.
    pub mirror: [bool; 3],
    /// What is painted with.
    pub material: Option<String>,
    pub(crate) stroke: Option<SculptStroke>,
    /// Whether the last stroke was taken back and the pointer is held still.
    pub(crate) is_given_up: bool,
}

#[derive(Debug)]
pub(crate) struct SculptStroke {
    pub(crate) group: Option<NodeId>,
    pub(crate) last: Option<Vec3>,
}

impl Default for Sculpting {
    fn default() -> Self {
        Self {
            kind: SculptKind::default(),
            radius: 0.1,
            strength: 0.5,
            mirror: [false; 3],
            material: None,
            stroke: None,
            is_given_up: false,
        }
    }
}

impl Sculpting {
    /// Whether a stroke is being made, or was until it was taken back and the pointer is still held.
    pub(crate) fn is_going(&self) -> bool {
        self.stroke.is_some() || self.is_given_up
    }

    /// A material has another name.
    pub(crate) fn rename(&mut self, from: &str, to: String) {
        if self.material.as_deref() == Some(from) {
            self.material = Some(to);
        }
    }

    /// Whether nothing is done until the pointer is let go.
    pub(crate) fn is_given_up(&self) -> bool {
        self.is_given_up
    }

    pub(crate) fn group(&self) -> NodeDesc {
        let word = self.kind.label();
        let mut group = Group::new().with_name(format!("{word} stroke"));
        if self.mirror.contains(&true) {
            group = group.with_modifier(Modifier::Mirror { axes: self.mirror });
        }
        let mut entry: NodeDesc = group.into();
        let (kind, blend) = match self.kind {
            SculptKind::Carve => (OperatorKind::Subtract, 0.5 * self.radius),
            SculptKind::Paint => (OperatorKind::Paint, 0.0),
            SculptKind::Add | SculptKind::Smooth => (OperatorKind::Union, self.radius),
        };
        entry.operator = Operator {
            kind,
            blend,
            ..Operator::default()
        };
        entry.material = self.material.clone();
        entry
    }
}
