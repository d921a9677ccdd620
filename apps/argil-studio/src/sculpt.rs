//! Sculpting strokes.
//!
//! *Practice.* A stroke is a group of capsules between dabs. The group's operator decides whether it adds, carves
//! or paints. A smoothing stroke adds no shape: it widens the blends of the brushes it passes over.

use crate::materials::material_choice;
use crate::sculpting::{SculptKind, SculptStroke};
use crate::session::{Request, Session};
use crate::view::{Tool, ViewState};
use argil::glam::Vec3;
use argil::scene::{Brush, Edit, NodeDesc, NodeId, NodeKind, Scene, Shape};
use eframe::egui;

impl ViewState {
    /// Handles the pointer over the surface. `pressure` is from 0 to 1.
    pub(crate) fn sculpt(
        &mut self,
        session: &mut Session,
        point: Vec3,
        normal: Vec3,
        pressure: f32,
    ) -> anyhow::Result<()> {
        if self.sculpting.stroke.is_none() {
            let name = format!("{} stroke", self.sculpting.kind.label());
            session.document.begin_stroke(&name);
            self.sculpting.stroke = Some(SculptStroke {
                group: None,
                last: None,
            });
        }
        // A mirror keeps the positive side.
        let [mut point, mut normal] = [point, normal];
        for (axis, &is_mirrored) in self.sculpting.mirror.iter().enumerate() {
            if is_mirrored && point[axis] < 0.0 {
                point[axis] = -point[axis];
                normal[axis] = -normal[axis];
            }
        }
        let radius = self.sculpting.radius * pressure.clamp(0.05, 1.0);
        let strength = self.sculpting.strength;
        let last = self.sculpting.stroke.as_ref().and_then(|s| s.last);
        if last.is_some_and(|last| last.distance(point) < 0.35 * radius) {
            return Ok(());
        }
        if self.sculpting.kind == SculptKind::Smooth {
            self.smooth(session, point, radius, strength)?;
        } else {
            // The strength moves the ball out of the surface, from touching it on the inside.
            let lift = match self.sculpting.kind {
                SculptKind::Add => (strength - 0.9) * radius,
                SculptKind::Carve => (0.9 - strength) * radius,
                _ => 0.0,
            };
            let at = point + lift * normal;
            self.dab(session, last.unwrap_or(at), at, radius)?;
            if let Some(stroke) = &mut self.sculpting.stroke {
                stroke.last = Some(at);
            }
            return Ok(());
        }
        if let Some(stroke) = &mut self.sculpting.stroke {
            stroke.last = Some(point);
        }
        Ok(())
    }

    pub(crate) fn dab(
        &mut self,
        session: &mut Session,
        from: Vec3,
        to: Vec3,
        radius: f32,
    ) -> anyhow::Result<()> {
        let known = self.sculpting.stroke.as_ref().and_then(|s| s.group);
        let group = match known {
            Some(group) => group,
            None => {
                let index = session.document.scene().node(Scene::ROOT).children().len();
                let made = session.document.edit(
                    "Stroke",
                    Edit::Insert {
                        parent: Scene::ROOT,
                        index,
                        desc: self.sculpting.group(),
                    },
                )?;
                if let Some(stroke) = &mut self.sculpting.stroke {
                    stroke.group = Some(made.node);
                }
                session.requests.push(Request::Fold(made.node));
                made.node
            }
        };
        let entry = if from.distance(to) < 1e-6 {
            Brush::new(Shape::sphere(radius)).at(to.to_array())
        } else {
            Brush::new(Shape::capsule(from.to_array(), to.to_array(), radius))
        };
        self.put(session, group, entry.into())
    }

    pub(crate) fn put(
        &mut self,
        session: &mut Session,
        group: NodeId,
        mut entry: NodeDesc,
    ) -> anyhow::Result<()> {
        entry.material = self.sculpting.material.clone();
        let index = session.document.scene().node(group).children().len();
        let edit = Edit::Insert {
            parent: group,
            index,
            desc: entry,
        };
        session.document.edit("Stroke", edit).map(drop)
    }

    /// Widens the blend of each brush whose own surface is within a radius of a point.
    pub(crate) fn smooth(
        &mut self,
        session: &mut Session,
        point: Vec3,
        radius: f32,
        strength: f32,
    ) -> anyhow::Result<()> {
        let brushes: Vec<NodeId> = session.document.scene().iter().collect();
        for node in brushes {
            let entry = session.document.scene().node(node).desc();
            let is_first = node == Scene::ROOT || !matches!(entry.kind, NodeKind::Shape(_));
            if is_first || !entry.visible || session.document.is_locked(node) {
                continue;
            }
            let scene = session.document.scene();
            let off = session.picker.distance_to(scene, node, point.to_array());
            if off.is_none_or(|off| off.abs() > radius) {
                continue;
            }
            let mut entry = scene.node(node).desc().clone();
            let wider = entry.operator.blend + 0.2 * strength * radius;
            entry.operator.blend = wider.min(4.0 * radius).max(entry.operator.blend);
            if entry != *scene.node(node).desc() {
                session.document.replace("Smooth", node, entry)?;
            }
        }
        Ok(())
    }

    /// Resets the stroke's material if it no longer exists.
    pub(crate) fn forget_material(&mut self, session: &mut Session) {
        let known = session.document.scene().materials();
        self.sculpting
            .material
            .take_if(|name| !known.contains_key(name));
    }

    /// Cancels the current stroke, and ignores the pointer until it is released.
    pub(crate) fn cancel_sculpting(&mut self, session: &mut Session) {
        if self.sculpting.stroke.take().is_some() {
            self.sculpting.is_given_up = true;
            session.document.cancel_stroke();
        }
    }

    /// Ends the stroke when the pointer is released.
    pub(crate) fn end_sculpting(&mut self, session: &mut Session) {
        self.sculpting.is_given_up = false;
        if self.sculpting.stroke.take().is_some() {
            session.document.end_stroke();
        }
    }

    /// Shows the options of strokes.
    pub(crate) fn sculpt_options(&mut self, session: &mut Session, ui: &mut egui::Ui) {
        ui.strong("Sculpt");
        ui.horizontal(|ui| {
            for kind in SculptKind::ALL {
                ui.selectable_value(&mut self.sculpting.kind, kind, kind.label());
            }
        });
        ui.add(
            egui::Slider::new(&mut self.sculpting.radius, 0.005..=2.0)
                .logarithmic(true)
                .text("Radius"),
        );
        ui.add(egui::Slider::new(&mut self.sculpting.strength, 0.0..=1.0).text("Strength"));
        ui.horizontal(|ui| {
            ui.label("Mirror at");
            for (axis, on) in ["x", "y", "z"].iter().zip(&mut self.sculpting.mirror) {
                ui.toggle_value(on, *axis);
            }
        });
        ui.horizontal(|ui| {
            ui.label("With");
            let mut material = self.sculpting.material.take();
            material_choice(&session.document, ui, "Material of strokes", &mut material);
            self.sculpting.material = material;
        });
    }

    /// Selects a kind of stroke.
    pub(crate) fn pick_material(&mut self, session: &mut Session, kind: SculptKind) {
        self.tool = Tool::Sculpt;
        self.sculpting.kind = kind;
        if kind == SculptKind::Paint && self.sculpting.material.is_none() {
            self.sculpting.material = session.document.scene().materials().keys().next().cloned();
        }
    }
}
