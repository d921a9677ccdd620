//! The gizmo: handles that move, rotate and scale the selection.

use crate::drag::*;
use crate::node_transform::NodeTransform;
use crate::overlay::label;
use crate::picking::off_segment;
use crate::session::Session;
use crate::stretch::stretched;
use crate::view::{Tool, ViewState};
use argil::glam::{Vec2, Vec3};
use argil::scene::{NodeId, NodeKind};
use eframe::egui::{self, Color32, Rect, Stroke};

impl ViewState {
    /// Returns the gizmo's position and axes.
    pub(crate) fn frame_of(
        &self,
        session: &mut Session,
        nodes: &[NodeId],
    ) -> Option<(Vec3, [Vec3; 3])> {
        let scene = session.document.scene();
        let poses: Vec<NodeTransform> = nodes
            .iter()
            .map(|&n| NodeTransform::of(scene.node(n).desc()).and(&NodeTransform::around(scene, n)))
            .collect();
        let last = poses.last()?;
        let pivot = poses.iter().map(|p| p.shift.as_vec3()).sum::<Vec3>() / poses.len() as f32;
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let axes = if self.is_local || self.tool == Tool::Scale {
            axes.map(|a| last.turn.as_quat() * a)
        } else {
            axes
        };
        Some((pivot, axes))
    }

    /// Returns true if each axis has a handle. A shape that cannot be scaled along one axis has none.
    pub(crate) fn has_handles(&self, session: &mut Session, nodes: &[NodeId]) -> [bool; 3] {
        if self.tool != Tool::Scale {
            return [true; 3];
        }
        let shape = session.document.plain_shape(nodes);
        let can = |axis| {
            shape
                .as_ref()
                .is_some_and(|s| stretched(s, axis, 1.5).is_some())
        };
        [0, 1, 2].map(can)
    }

    /// Draws the gizmo and handles drags. Returns true if it uses the pointer.
    pub(crate) fn gizmo(
        &mut self,
        session: &mut Session,
        ui: &egui::Ui,
        rect: Rect,
        response: &egui::Response,
    ) -> bool {
        if !matches!(self.tool, Tool::Move | Tool::Rotate | Tool::Scale) {
            self.drag = None;
            return false;
        }
        let nodes = session.document.movable();
        let Some((pivot, axes)) = self.frame_of(session, &nodes) else {
            self.drag = None;
            return false;
        };
        let eye = self.eye;
        let screen = Screen { eye: &eye, rect };
        let pointer = ui
            .input(|i| i.pointer.latest_pos())
            .map(|p| Vec2::new(p.x, p.y));
        let over = pointer.filter(|_| response.hovered() || self.drag.is_some());
        let handles = self.has_handles(session, &nodes);
        let frame = (pivot, axes, handles);
        let hovered = over.and_then(|at| self.handle_at(&screen, at, frame));
        let held = self.drag.as_ref().map(|d| d.handle);
        self.draw_gizmo(ui, &screen, frame, held.or(hovered));

        if response.drag_started_by(egui::PointerButton::Primary) {
            let start = ui.input(|i| i.pointer.press_origin());
            let start = start.map(|p| Vec2::new(p.x, p.y));
            let handle = start.and_then(|at| self.handle_at(&screen, at, frame));
            if let (Some(start), Some(handle)) = (start, handle) {
                let copies = ui.input(|i| i.modifiers.shift);
                self.begin_drag(session, handle, start, (pivot, axes), nodes, copies);
            }
        }
        if let Some(mut drag) = self.drag.take() {
            type_into(ui, &mut drag.typed);
            if !drag.is_cancelled && ui.input(|i| i.key_pressed(egui::Key::Escape)) {
                drag.is_cancelled = true;
                session.document.cancel_stroke();
                session.document.selection.clone_from(&drag.selection);
            }
            if let Some(at) = pointer.filter(|_| !drag.is_cancelled) {
                let snaps = session.preferences.snap != ui.input(|i| i.modifiers.command);
                let told = self.drag_to(session, &screen, &drag, at, snaps);
                let place = pos(at) + egui::vec2(16.0, -16.0);
                label(ui, place, &told);
            }
            if response.dragged_by(egui::PointerButton::Primary) {
                self.drag = Some(drag);
            } else if !drag.is_cancelled {
                session.document.end_stroke();
            }
            return true;
        }
        hovered.is_some()
    }

    pub(crate) fn handle_at(
        &self,
        screen: &Screen<'_>,
        at: Vec2,
        (pivot, axes, handles): (Vec3, [Vec3; 3], [bool; 3]),
    ) -> Option<Handle> {
        let length = screen.length(LENGTH, pivot);
        let middle = screen.at(pivot)?;
        let mut best: Option<(f32, Handle)> = None;
        let mut try_one = |off: f32, handle: Handle| {
            if off < NEAR && best.is_none_or(|(least, _)| off < least) {
                best = Some((off, handle));
            }
        };
        for (i, axis) in axes.into_iter().enumerate().filter(|&(i, _)| handles[i]) {
            if self.tool == Tool::Rotate {
                let ring = screen.ring(pivot, axis, length);
                for pair in ring.windows(2) {
                    if let [Some(a), Some(b)] = *pair {
                        try_one(off_segment(at, [a, b]), Handle::Axis(i));
                    }
                }
            } else if let Some(end) = screen.at(pivot + length * axis) {
                // The center belongs to another handle.
                let from = middle + 0.2 * (end - middle);
                try_one(off_segment(at, [from, end]), Handle::Axis(i));
            }
        }
        if self.tool == Tool::Rotate {
            let off = (at.distance(middle) - 1.2 * LENGTH).abs();
            try_one(off, Handle::Free);
        } else {
            try_one(at.distance(middle) - 4.0, Handle::Free);
        }
        best.map(|(_, handle)| handle)
    }

    pub(crate) fn draw_gizmo(
        &self,
        ui: &egui::Ui,
        screen: &Screen<'_>,
        (pivot, axes, handles): (Vec3, [Vec3; 3], [bool; 3]),
        lit: Option<Handle>,
    ) {
        let painter = ui.painter_at(screen.rect);
        let Some(middle) = screen.at(pivot) else {
            return;
        };
        let length = screen.length(LENGTH, pivot);
        for (i, axis) in axes.into_iter().enumerate().filter(|&(i, _)| handles[i]) {
            let is_lit = lit == Some(Handle::Axis(i));
            let stroke = Stroke::new(2.5, if is_lit { HELD } else { COLORS[i] });
            if self.tool == Tool::Rotate {
                for pair in screen.ring(pivot, axis, length).windows(2) {
                    if let [Some(a), Some(b)] = *pair {
                        painter.line_segment([pos(a), pos(b)], stroke);
                    }
                }
                continue;
            }
            let Some(end) = screen.at(pivot + length * axis) else {
                continue;
            };
            painter.line_segment([pos(middle), pos(end)], stroke);
            if self.tool == Tool::Scale {
                let square = Rect::from_center_size(pos(end), egui::Vec2::splat(8.0));
                painter.rect_filled(square, 1.0, stroke.color);
            } else {
                let along = (end - middle).normalize_or_zero() * 10.0;
                let across = along.perp() * 0.45;
                let tip = vec![pos(end + along), pos(end + across), pos(end - across)];
                painter.add(egui::Shape::convex_polygon(tip, stroke.color, Stroke::NONE));
            }
        }
        let color = if lit == Some(Handle::Free) {
            HELD
        } else {
            Color32::from_gray(230)
        };
        if self.tool == Tool::Rotate {
            painter.circle_stroke(pos(middle), 1.2 * LENGTH, Stroke::new(1.5, color));
        } else {
            painter.circle(
                pos(middle),
                6.0,
                color.gamma_multiply(0.6),
                Stroke::new(1.5, color),
            );
        }
    }

    pub(crate) fn begin_drag(
        &mut self,
        session: &mut Session,
        handle: Handle,
        start: Vec2,
        (pivot, axes): (Vec3, [Vec3; 3]),
        nodes: Vec<NodeId>,
        copies: bool,
    ) {
        let name = match self.tool {
            Tool::Rotate => "Rotate",
            Tool::Scale => "Scale",
            _ => "Move",
        };
        let selection = session.document.selection.clone();
        session
            .document
            .begin_stroke(if copies { "Duplicate" } else { name });
        let nodes = if copies {
            match session.document.duplicate_within_stroke() {
                Ok(made) => made,
                Err(error) => {
                    session.fail(&error);
                    nodes
                }
            }
        } else {
            nodes
        };
        let scene = session.document.scene();
        let pose = |&n: &NodeId| {
            let outer = NodeTransform::around(scene, n);
            (
                n,
                NodeTransform::of(scene.node(n).desc()).and(&outer),
                outer,
            )
        };
        let shape = session.document.plain_shape(&nodes);
        let nodes = nodes.iter().map(pose).collect();
        self.drag = Some(Drag {
            handle,
            start,
            pivot,
            axes,
            shape,
            nodes,
            typed: String::new(),
            selection,
            is_cancelled: false,
        });
    }

    /// Applies a drag to the pointer's position, and returns the readout.
    pub(crate) fn drag_to(
        &mut self,
        session: &mut Session,
        screen: &Screen<'_>,
        drag: &Drag,
        at: Vec2,
        snaps: bool,
    ) -> String {
        let typed: Option<f32> = drag.typed.parse().ok().filter(|v: &f32| v.is_finite());
        let step = |value: f32, by: f32| {
            if snaps {
                (value / by).round() * by
            } else {
                value
            }
        };
        let preferences = &session.preferences;
        let backward = self.eye.backward();
        let change = match self.tool {
            Tool::Rotate => drag.turned(screen, at, backward).map(|(axis, degrees)| {
                let snapped = || step(degrees, preferences.snap_degrees);
                DragChange::Turn(axis, typed.unwrap_or_else(snapped))
            }),
            Tool::Scale => drag.scaled(screen, at).map(|factor| {
                let snapped = || step(factor, 0.1);
                DragChange::Scale(typed.unwrap_or_else(snapped).clamp(1e-3, 1e3))
            }),
            _ => drag.shifted(screen, at, backward).map(|by| {
                let snapped = |by: f32| step(by, preferences.snap_length);
                DragChange::Shift(match drag.handle {
                    Handle::Axis(i) => {
                        let along = by.dot(drag.axes[i]);
                        drag.axes[i] * typed.unwrap_or_else(|| snapped(along))
                    }
                    Handle::Free => Vec3::from(by.to_array().map(snapped)),
                })
            }),
        };
        let Some(change) = change else {
            return String::new();
        };
        if let (DragChange::Scale(factor), Handle::Axis(axis)) = (&change, drag.handle) {
            self.stretch(session, drag, axis, *factor);
            return change.readout();
        }
        for (node, pose, outer) in &drag.nodes {
            let mut entry = session.document.scene().node(*node).desc().clone();
            change.of(pose, drag.pivot).within(outer).write(&mut entry);
            if entry != *session.document.scene().node(*node).desc() {
                session.attempt(|s| s.document.replace("Move", *node, entry));
            }
        }
        change.readout()
    }

    /// Scales the only dragged brush along one of its own axes.
    pub(crate) fn stretch(&mut self, session: &mut Session, drag: &Drag, axis: usize, factor: f32) {
        let ([(node, ..)], Some(shape)) = (&drag.nodes[..], &drag.shape) else {
            return;
        };
        let mut entry = session.document.scene().node(*node).desc().clone();
        let Some(shape) = stretched(shape, axis, factor) else {
            return;
        };
        entry.kind = NodeKind::Shape(shape);
        if entry != *session.document.scene().node(*node).desc() {
            session.attempt(|s| s.document.replace("Scale", *node, entry));
        }
    }
}

/// Handles numbers typed during a drag.
fn type_into(ui: &egui::Ui, typed: &mut String) {
    ui.input(|i| {
        for event in &i.events {
            match event {
                egui::Event::Text(text) => {
                    typed.extend(text.chars().filter(|c| "0123456789.-".contains(*c)));
                }
                egui::Event::Key {
                    key: egui::Key::Backspace,
                    pressed: true,
                    ..
                } => drop(typed.pop()),
                _ => {}
            }
        }
    });
}
