//! A drag of a handle, and the screen that it is on.

use crate::node_transform::NodeTransform;
use crate::viewport_camera::{on_line, on_plane};
use argil::glam::{Quat, Vec2, Vec3};
use argil::scene::{NodeId, Shape};
use eframe::egui::{Color32, Pos2, Rect};

/// A part of the gizmo that can be dragged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Handle {
    /// Along or about an axis; of a scale, along an axis of the brush itself.
    Axis(usize),
    /// In the picture's plane, or about its normal; of a scale, all of it.
    Free,
}

/// A drag that is going on.
#[derive(Clone, Debug)]
pub(crate) struct Drag {
    pub(crate) handle: Handle,
    /// Where it began.
    pub(crate) start: Vec2,
    pub(crate) pivot: Vec3,
    pub(crate) axes: [Vec3; 3],
    /// The shape of the one brush that is dragged, as it was when it began.
    pub(crate) shape: Option<Shape>,
    /// What is dragged: its place in the world when it began, and that of the groups around it.
    pub(crate) nodes: Vec<(NodeId, NodeTransform, NodeTransform)>,
    /// What is typed for it.
    pub(crate) typed: String,
    /// What was selected before.
    pub(crate) selection: Vec<NodeId>,
    /// Whether it was taken back while it was held.
    pub(crate) is_cancelled: bool,
}

/// Handles are as long as this, in points.
pub(crate) const LENGTH: f32 = 80.0;
/// So near is on a handle.
pub(crate) const NEAR: f32 = 7.0;
pub(crate) const COLORS: [Color32; 3] = [
    Color32::from_rgb(230, 70, 70),
    Color32::from_rgb(90, 190, 70),
    Color32::from_rgb(70, 120, 240),
];
pub(crate) const HELD: Color32 = Color32::from_rgb(255, 210, 60);
pub(crate) const RING: usize = 48;

/// The viewport's rectangle, with the eye, as the gizmo needs them.
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
        let own = at - Vec2::new(self.rect.left(), self.rect.top());
        self.eye.ray(own, self.size())
    }

    /// A length in points at a place, in the world.
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
    /// The axis that it turns about, and by how many degrees.
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
        // On the screen y goes down; what is seen from behind turns the other way.
        let faces = if axis.dot(backward) < 0.0 { 1.0 } else { -1.0 };
        Some((axis, faces * turn))
    }

    /// How many times as large it makes things.
    pub(crate) fn scaled(&self, screen: &Screen<'_>, at: Vec2) -> Option<f32> {
        let (pivot, start) = (self.pivot, self.start);
        let middle = screen.at(pivot)?;
        let along = match self.handle {
            Handle::Axis(i) => screen.at(pivot + screen.length(LENGTH, pivot) * self.axes[i]),
            Handle::Free => None,
        };
        Some(match along {
            // Along the handle, as it is seen.
            Some(end) => {
                let along = (end - middle).normalize_or_zero();
                (at - middle).dot(along).max(1.0) / (start - middle).dot(along).max(8.0)
            }
            None => at.distance(middle).max(1.0) / start.distance(middle).max(8.0),
        })
    }

    /// By how much it shifts things.
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

/// What a drag does to what is dragged.
pub(crate) enum DragChange {
    /// About an axis, by degrees.
    Turn(Vec3, f32),
    /// So many times as large.
    Scale(f32),
    /// By a way.
    Shift(Vec3),
}

impl DragChange {
    /// In words.
    pub(crate) fn readout(&self) -> String {
        match self {
            Self::Turn(_, degrees) => format!("{degrees:.1}°"),
            Self::Scale(factor) => format!("× {factor:.3}"),
            Self::Shift(by) => format!("{:.3}, {:.3}, {:.3}", by.x, by.y, by.z),
        }
    }

    /// What a pose becomes.
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
