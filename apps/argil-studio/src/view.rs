//! What is seen: from where, with which tool, and the pictures of it.

use crate::drag::Drag;
use crate::eye::Eye;
use crate::pictures::Pictures;
use crate::sculpting::Sculpting;
use argil::{NodeId, Show};

/// What the pointer does in the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Pick.
    #[default]
    Select,
    /// Pick and move.
    Move,
    /// Pick and rotate.
    Rotate,
    /// Pick and scale.
    Scale,
    /// Sculpt.
    Sculpt,
}

/// See the module's page.
#[derive(Default)]
pub struct View {
    /// From where it is looked at.
    pub eye: Eye,
    /// What the pointer does.
    pub tool: Tool,
    /// Whether handles are along the axes of what is selected.
    pub is_local: bool,
    /// What of the scene is shown.
    pub show: Show,
    /// How strokes are made, and the one that is.
    pub sculpting: Sculpting,
    /// What is drawn.
    pub pictures: Pictures,
    /// A gizmo's drag.
    pub drag: Option<Drag>,
    /// What the pointer is over.
    pub hovered: Option<NodeId>,
}
