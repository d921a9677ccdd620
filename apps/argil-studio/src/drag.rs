//! A drag of a handle, in screen space.

use crate::node_transform::NodeTransform;
use crate::viewport_camera::{on_line, on_plane};
use argil::glam::{Quat, Vec2, Vec3};
use argil::scene::{NodeId, Shape};
use eframe::egui::{Color32, Pos2, Rect};

/// A part of the gizmo that can be dragged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Handle {
    /// Along or about an axis. Scaling works along the brush's own axis.
    Axis(usize),
    /// In the image plane, or about its normal. Scaling is uniform.
    Free,
}

/// A drag in progress.
#[derive(Clone, Debug)]
pub(crate) struct Drag {
    pub(crate) handle: Handle,
    /// Position where it began.
    pub(crate) start: Vec2,
    pub(crate) pivot: Vec3,
    pub(crate) axes: [Vec3; 3],
    /// The shape of the only dragged brush, at the start.
    pub(crate) shape: Option<Shape>,
    /// The dragged nodes, each with its transform at the start and the transform of its groups.
    pub(crate) nodes: Vec<(NodeId, NodeTransform, NodeTransform)>,
    /// Text typed during the drag.
    pub(crate) typed: String,
    /// Selection before the drag.
    pub(crate) selection: Vec<NodeId>,
    /// Whether the drag was canceled while the pointer was held.
    pub(crate) is_cancelled: bool,
}

/// Length of handles in points.
pub(crate) const LENGTH: f32 = 80.0;
/// Distance in points within which the pointer hits a handle.
pub(crate) const NEAR: f32 = 7.0;
pub(crate) const COLORS: [Color32; 3] = [
    Color32::from_rgb(230, 70, 70),
    Color32::from_rgb(90, 190, 70),
    Color32::from_rgb(70, 120, 240),
];
pub(crate) const HELD: Color32 = Color32::from_rgb(255, 210, 60);
pub(crate) const RING: usize = 48;

/// The viewport's rectangle and camera.
pub(crate) struct Screen<'a> {
    pub(crate) eye: &'a crate::viewport_camera::ViewportCamera,
    pub(crate) rect: Rect,
}

impl Screen<'_> {
    pub(crate) fn size(&self) -> Vec2 {
        Vec2::new(self.rect.width(), self.rect.height())
    }

    pub(crate) fn at(&self, point: Vec3) -> Option<Vec2> {
        let at = self.eye.project(point, self.size())?;
        Some(at + Vec2::new(self.rect.left(), self.rect.top()))
    }

    pub(crate) fn ray(&self, at: Vec2) -> [Vec3; 2] {
        let in_view = at - Vec2::new(self.rect.left(), self.rect.top());
        self.eye.ray(in_view, self.size())
    }

    /// Converts a length in points at a position to world units.
    pub(crate) fn length(&self, points: f32, at: Vec3) -> f32 {
        points / self.eye.pixels_per_unit(at, self.size())
    }

    pub(crate) fn ring(&self, pivot: Vec3, axis: Vec3, radius: f32) -> Vec<Option<Vec2>> {
        let (u, v) = axis.any_orthonormal_pair();
        (0..=RING)
            .map(|i| {
                let a = std::f32::consts::TAU * i as f32 / RING as f32;
                self.at(pivot + radius * (a.cos() * u + a.sin() * v))
            })
            .collect()
    }
}

pub(crate) fn pos(v: Vec2) -> Pos2 {
    Pos2::new(v.x, v.y)
}

impl Drag {
    /// Returns the axis of rotation, and the angle in degrees.
    pub(crate) fn turned(
        &self,
        screen: &Screen<'_>,
        at: Vec2,
        backward: Vec3,
    ) -> Option<(Vec3, f32)> {
        let axis = match self.handle {
            Handle::Axis(i) => self.axes[i],
            Handle::Free => backward,
        };
        let middle = screen.at(self.pivot)?;
        let turn = (self.start - middle).angle_to(at - middle).to_degrees();
        // The y axis of the screen points down, and a rotation seen from behind appears reversed.
        let faces = if axis.dot(backward) < 0.0 { 1.0 } else { -1.0 };
        Some((axis, faces * turn))
    }

    /// Returns the scale factor.
    pub(crate) fn scaled(&self, screen: &Screen<'_>, at: Vec2) -> Option<f32> {
        let (pivot, start) = (self.pivot, self.start);
        let middle = screen.at(pivot)?;
        let along = match self.handle {
            Handle::Axis(i) => screen.at(pivot + screen.length(LENGTH, pivot) * self.axes[i]),
            Handle::Free => None,
        };
        Some(match along {
            // Along the handle, as it appears on screen.
            Some(end) => {
                let along = (end - middle).normalize_or_zero();
                (at - middle).dot(along).max(1.0) / (start - middle).dot(along).max(8.0)
            }
            None => at.distance(middle).max(1.0) / start.distance(middle).max(8.0),
        })
    }

    /// Returns the translation.
    pub(crate) fn shifted(&self, screen: &Screen<'_>, at: Vec2, backward: Vec3) -> Option<Vec3> {
        let [before, now] = [self.start, at].map(|p| screen.ray(p));
        match self.handle {
            Handle::Axis(i) => {
                let along = |ray| on_line(ray, self.pivot, self.axes[i]);
                Some(self.axes[i] * (along(now)? - along(before)?))
            }
            Handle::Free => {
                let plane = |ray| on_plane(ray, self.pivot, backward);
                Some(plane(now)? - plane(before)?)
            }
        }
    }
}

/// The effect of a drag.
pub(crate) enum DragChange {
    /// Rotates about an axis, by degrees.
    Turn(Vec3, f32),
    /// Scales by a factor.
    Scale(f32),
    /// Translates by a vector.
    Shift(Vec3),
}

impl DragChange {
    /// Formats the change for display.
    pub(crate) fn readout(&self) -> String {
        match self {
            Self::Turn(_, degrees) => format!("{degrees:.1}°"),
            Self::Scale(factor) => format!("× {factor:.3}"),
            Self::Shift(by) => format!("{:.3}, {:.3}, {:.3}", by.x, by.y, by.z),
        }
    }

    /// Applies the change to a transform.
    pub(crate) fn of(&self, pose: &NodeTransform, pivot: Vec3) -> NodeTransform {
        let pivot = pivot.as_dvec3();
        let from = pose.shift - pivot;
        match *self {
            Self::Turn(axis, degrees) => {
                let turn = Quat::from_axis_angle(axis, degrees.to_radians()).as_dquat();
                NodeTransform {
                    turn: (turn * pose.turn).normalize(),
                    shift: pivot + turn * from,
                    ..*pose
                }
            }
            Self::Scale(factor) => NodeTransform {
                scale: pose.scale * f64::from(factor),
                shift: pivot + f64::from(factor) * from,
                ..*pose
            },
            Self::Shift(by) => NodeTransform {
                shift: pose.shift + by.as_dvec3(),
                ..*pose
            },
        }
    }
}
