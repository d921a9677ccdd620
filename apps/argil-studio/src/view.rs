//! The view: camera, tool and images.

use crate::drag::Drag;
use crate::sculpting::Sculpting;
use crate::viewport_camera::ViewportCamera;
use crate::viewport_images::ViewportImages;
use argil::render::RenderMode;
use argil::scene::NodeId;

/// The tool of the pointer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tool {
    /// Select.
    #[default]
    Select,
    /// Select and move.
    Move,
    /// Select and rotate.
    Rotate,
    /// Select and scale.
    Scale,
    /// Sculpt.
    Sculpt,
}

/// The view.
#[derive(Default)]
pub(crate) struct ViewState {
    /// The camera.
    pub eye: ViewportCamera,
    /// The tool.
    pub tool: Tool,
    /// Whether handles follow the selection's own axes.
    pub is_local: bool,
    /// The render mode.
    pub show: RenderMode,
    /// Sculpting options, and the current stroke.
    pub sculpting: Sculpting,
    /// Whether images are path traced while nothing moves.
    pub traces_paths: bool,
    /// The images.
    pub pictures: ViewportImages,
    /// The gizmo's drag.
    pub drag: Option<Drag>,
    /// The node under the pointer.
    pub hovered: Option<NodeId>,
}
