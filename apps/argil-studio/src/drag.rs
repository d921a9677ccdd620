//! A drag of a handle, and the screen that it is on.

use crate::pose::Pose;
use argil::glam::{Vec2, Vec3};
use argil::{NodeId, Shape};
use eframe::egui::{Color32, Pos2, Rect};

/// A part of the gizmo that can be dragged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// Along or about an axis; of a scale, along an axis of the brush itself.
    Axis(usize),
    /// In the picture's plane, or about its normal; of a scale, all of it.
    Free,
}

/// A drag that is going on.
#[derive(Clone, Debug)]
pub struct Drag {
    pub(crate) handle: Handle,
    /// Where it began.
    pub(crate) start: Vec2,
    pub(crate) pivot: Vec3,
    pub(crate) axes: [Vec3; 3],
    /// The shape of the one brush that is dragged, as it was when it began.
    pub(crate) shape: Option<Shape>,
    /// What is dragged: its place in the world when it began, and that of the groups around it.
    pub(crate) nodes: Vec<(NodeId, Pose, Pose)>,
    /// What is typed for it.
    pub(crate) typed: String,
    /// What was selected before.
    pub(crate) selection: Vec<NodeId>,
    /// Whether it was taken back while it was held.
    pub(crate) is_given_up: bool,
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
    pub(crate) eye: &'a crate::eye::Eye,
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
        points / self.eye.pixels_a_unit(at, self.size())
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
