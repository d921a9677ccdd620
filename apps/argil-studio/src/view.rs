//! What is seen: from where, with which tool, and the pictures of it.

use crate::drag::Drag;
use crate::sculpting::Sculpting;
use crate::viewport_camera::ViewportCamera;
use crate::viewport_images::ViewportImages;
use argil::render::RenderMode;
use argil::scene::NodeId;

/// What the pointer does in the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tool {
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
pub(crate) struct View {
    /// From where it is looked at.
    pub eye: ViewportCamera,
    /// What the pointer does.
    pub tool: Tool,
    /// Whether handles are along the axes of what is selected.
    pub is_local: bool,
    /// What of the scene is shown.
    pub show: RenderMode,
    /// How strokes are made, and the one that is.
    pub sculpting: Sculpting,
    /// What is drawn.
    pub pictures: ViewportImages,
    /// A gizmo's drag.
    pub drag: Option<Drag>,
    /// What the pointer is over.
    pub hovered: Option<NodeId>,
}
