//! State of sculpting strokes.

use argil::glam::Vec3;
use argil::scene::{Group, Modifier, NodeDesc, NodeId, Operator, OperatorKind};

/// The effect of a stroke.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum SculptKind {
    /// Adds material.
    #[default]
    Add,
    /// Removes material.
    Carve,
    /// Widens blends.
    Smooth,
    /// Paints a material.
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

/// Options of strokes, and the current stroke.
#[derive(Debug)]
pub(crate) struct Sculpting {
    /// The effect.
    pub kind: SculptKind,
    /// Radius in scene units.
    pub radius: f32,
    /// From 0 to 1: height of the stroke, or speed of smoothing.
    pub strength: f32,
    /// Planes through the origin at which strokes are mirrored.
    pub mirror: [bool; 3],
    /// The material to paint.
    pub material: Option<String>,
    pub(crate) stroke: Option<SculptStroke>,
    /// Whether the stroke was canceled while the pointer is held.
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
    /// Returns true during a stroke, and after its cancellation until the pointer is released.
    pub(crate) fn is_going(&self) -> bool {
        self.stroke.is_some() || self.is_given_up
    }

    /// Follows the new name of a material.
    pub(crate) fn rename(&mut self, from: &str, to: String) {
        if self.material.as_deref() == Some(from) {
            self.material = Some(to);
        }
    }

    /// Returns true if the pointer is ignored until it is released.
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
