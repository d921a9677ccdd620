//! Framing of the view, and views side by side.

use crate::node_transform::NodeTransform;
use crate::pipeline::Pipeline;
use crate::session::Session;
use crate::view::ViewState;
use argil::glam::Vec3;
use argil::scene::{Brush, Shape};

impl ViewState {
    /// Resets the state for another document.
    pub(crate) fn forget(&mut self) {
        self.pictures.forget();
        self.drag = None;
        self.hovered = None;
    }

    /// Starts or stops comparing two pipelines.
    pub(crate) fn split(&mut self, session: &mut Session) {
        self.pictures.split = match self.pictures.split {
            Some(_) => None,
            None if session.preferences.pipeline == Pipeline::field() => Some(Pipeline::default()),
            None => Some(Pipeline::field()),
        };
        self.pictures.divider = 0.5;
        self.pictures.shows_difference = false;
    }

    /// Moves the selection by one snap step, along the axis nearest to a direction on screen.
    pub(crate) fn nudge(&self, session: &mut Session, seen: Vec3) {
        session.attempt(|s| self.try_to_nudge(s, seen));
    }

    fn try_to_nudge(&self, session: &mut Session, seen: Vec3) -> anyhow::Result<()> {
        let nodes = session.document.unlocked()?;
        let Some((_, axes)) = self.frame_of(session, &nodes) else {
            return Ok(());
        };
        let [right, up] = self.eye.axes();
        let along = seen.x * right + seen.y * up + seen.z * self.eye.backward();
        let steepest = |a: &Vec3, b: &Vec3| a.dot(along).abs().total_cmp(&b.dot(along).abs());
        let Some(axis) = axes.into_iter().max_by(steepest) else {
            return Ok(());
        };
        let by = axis * session.preferences.snap_length.copysign(axis.dot(along));
        session.document.begin_stroke("Nudge");
        for node in nodes {
            let scene = session.document.scene();
            let mut entry = scene.node(node).desc().clone();
            let outer = NodeTransform::around(scene, node);
            let mut pose = NodeTransform::of(&entry).and(&outer);
            pose.shift += by.as_dvec3();
            pose.within(&outer).write(&mut entry);
            session.document.replace("Nudge", node, entry)?;
        }
        session.document.end_stroke();
        Ok(())
    }

    pub(crate) fn frame_selection(&mut self, session: &mut Session) {
        let scene = session.document.scene();
        let boxes = session.document.selection.clone().into_iter();
        let boxes = boxes.filter_map(|node| session.picker.box_of(scene, node));
        if let Some(all) = boxes.reduce(|a, b| a.union(b)) {
            self.eye.frame(all);
        }
    }

    pub(crate) fn frame_all(&mut self, session: &mut Session) {
        let scene = session.document.scene();
        if let Some(world) = session.picker.world(scene, session.version) {
            self.eye.frame(world.view_bounds());
        }
    }

    /// Adds a shape at the camera's target.
    pub(crate) fn add_shape(&self, session: &mut Session, shape: Shape, at: Vec3) {
        // Its size is a fifth of the visible height.
        let size = (0.4 * self.eye.half_height()).clamp(1e-3, 1e3);
        let size = (size * 100.0).round() / 100.0;
        let brush = Brush::new(shape).scaled(size.max(0.01)).at(at.to_array());
        session.attempt(|s| s.document.add_entry("Add shape", brush.into()));
    }

    /// Frames the selection if little of it would be visible, for example because it was modeled in another unit.
    pub(crate) fn frame_what_is_off(&mut self, session: &mut Session) {
        let Some(node) = session.document.active() else {
            return;
        };
        let Some(bounds) = session.picker.box_of(session.document.scene(), node) else {
            return;
        };
        let in_view = self.eye.half_height();
        let is_near = bounds.center().distance(self.eye.target) < in_view;
        if !is_near || !(0.05..=1.0).contains(&(bounds.half_diagonal() / in_view)) {
            self.eye.frame(bounds);
        }
    }
}
