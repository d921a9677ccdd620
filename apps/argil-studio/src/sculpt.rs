//! Strokes on the surface.
//!
//! *Practice.* A stroke is a group of capsules, from dab to dab; what the group's operator is makes it add, carve or paint.
//! A stroke that smooths changes no shape: it widens the blends of the brushes that it passes over.

use crate::app::{Studio, Tool};
use argil::glam::Vec3;
use argil::{
    Body, Brush, Edit, Entry, Group, Modifier, NodeId, Operator, OperatorKind, Scene, Shape,
};
use eframe::egui;

/// What a stroke does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Add.
    #[default]
    Add,
    /// Take away.
    Carve,
    /// Widen blends.
    Smooth,
    /// Give a material.
    Paint,
}

impl Kind {
    const ALL: [Self; 4] = [Self::Add, Self::Carve, Self::Smooth, Self::Paint];

    fn word(self) -> &'static str {
        match self {
            Self::Add => "Add",
            Self::Carve => "Carve",
            Self::Smooth => "Smooth",
            Self::Paint => "Paint",
        }
    }
}

/// How strokes are made, and the one that is.
#[derive(Debug)]
pub struct Sculpting {
    /// What it does.
    pub kind: Kind,
    /// In the scene's unit.
    pub radius: f32,
    /// From 0 to 1: how far it stands out, or how fast it smooths.
    pub strength: f32,
    /// Planes through the origin at which strokes are mirrored.
    pub mirror: [bool; 3],
    /// What is painted with.
    pub material: Option<String>,
    stroke: Option<Stroke>,
    /// Whether the last stroke was taken back and the pointer is held still.
    is_given_up: bool,
}

#[derive(Debug)]
struct Stroke {
    group: Option<NodeId>,
    last: Option<Vec3>,
}

impl Default for Sculpting {
    fn default() -> Self {
        Self {
            kind: Kind::default(),
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
    /// Whether a stroke is being made, or was until it was taken back and the pointer is still held.
    pub fn is_going(&self) -> bool {
        self.stroke.is_some() || self.is_given_up
    }

    /// Whether nothing is done until the pointer is let go.
    pub fn is_given_up(&self) -> bool {
        self.is_given_up
    }

    fn group(&self) -> Entry {
        let word = self.kind.word();
        let mut group = Group::new().named(format!("{word} stroke"));
        if self.mirror.contains(&true) {
            group = group.modify(Modifier::Mirror { axes: self.mirror });
        }
        let mut entry: Entry = group.into();
        let (kind, blend) = match self.kind {
            Kind::Carve => (OperatorKind::Subtract, 0.5 * self.radius),
            Kind::Paint => (OperatorKind::Paint, 0.0),
            Kind::Add | Kind::Smooth => (OperatorKind::Union, self.radius),
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

impl Studio {
    /// The pointer is pressed over the surface, or moves on while it is; `pressure` is from 0 to 1.
    pub(crate) fn sculpt(
        &mut self,
        point: Vec3,
        normal: Vec3,
        pressure: f32,
    ) -> anyhow::Result<()> {
        if self.sculpting.stroke.is_none() {
            let name = format!("{} stroke", self.sculpting.kind.word());
            self.document.begin_stroke(&name);
            self.sculpting.stroke = Some(Stroke {
                group: None,
                last: None,
            });
        }
        // A mirror keeps what is on the positive side.
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
        if self.sculpting.kind == Kind::Smooth {
            self.smooth(point, radius, strength)?;
        } else {
            // By its strength the ball is pushed out of the surface, from where it only touches it from within.
            let lift = match self.sculpting.kind {
                Kind::Add => (strength - 0.9) * radius,
                Kind::Carve => (0.9 - strength) * radius,
                _ => 0.0,
            };
            let at = point + lift * normal;
            self.dab(last.unwrap_or(at), at, radius)?;
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

    fn dab(&mut self, from: Vec3, to: Vec3, radius: f32) -> anyhow::Result<()> {
        let known = self.sculpting.stroke.as_ref().and_then(|s| s.group);
        let group = match known {
            Some(group) => group,
            None => {
                let index = self.document.scene().node(Scene::ROOT).children().len();
                let made = self.document.edit(
                    "Stroke",
                    &Edit::Insert {
                        parent: Scene::ROOT,
                        index,
                        entry: self.sculpting.group(),
                    },
                )?;
                if let Some(stroke) = &mut self.sculpting.stroke {
                    stroke.group = Some(made.node);
                }
                self.collapsed.insert(made.node);
                made.node
            }
        };
        let entry = if from.distance(to) < 1e-6 {
            Brush::new(Shape::sphere(radius)).at(to.to_array())
        } else {
            Brush::new(Shape::capsule(from.to_array(), to.to_array(), radius))
        };
        self.put(group, entry.into())
    }

    fn put(&mut self, group: NodeId, mut entry: Entry) -> anyhow::Result<()> {
        entry.material = self.sculpting.material.clone();
        let index = self.document.scene().node(group).children().len();
        let edit = Edit::Insert {
            parent: group,
            index,
            entry,
        };
        self.document.edit("Stroke", &edit).map(drop)
    }

    /// Widen the blend of each brush whose own surface is within a radius of a point.
    fn smooth(&mut self, point: Vec3, radius: f32, strength: f32) -> anyhow::Result<()> {
        let brushes: Vec<NodeId> = self.document.scene().walk().collect();
        for node in brushes {
            let entry = self.document.scene().node(node).entry();
            let is_first = node == Scene::ROOT || !matches!(entry.body, Body::Shape(_));
            if is_first || !entry.visible || self.document.is_locked(node) {
                continue;
            }
            let scene = self.document.scene();
            let off = self.picker.distance_to(scene, node, point.to_array());
            if off.is_none_or(|off| off.abs() > radius) {
                continue;
            }
            let mut entry = scene.node(node).entry().clone();
            let wider = entry.operator.blend + 0.2 * strength * radius;
            entry.operator.blend = wider.min(4.0 * radius).max(entry.operator.blend);
            if entry != *scene.node(node).entry() {
                self.document.replace("Smooth", node, entry)?;
            }
        }
        Ok(())
    }

    /// Strokes have no material that is not there any more.
    pub(crate) fn forget_material(&mut self) {
        let known = self.document.scene().materials();
        self.sculpting
            .material
            .take_if(|own| !known.contains_key(own));
    }

    /// Take the stroke back that is being made; nothing is done until the pointer is let go.
    pub(crate) fn give_up_sculpting(&mut self) {
        if self.sculpting.stroke.take().is_some() {
            self.sculpting.is_given_up = true;
            self.document.give_up_stroke();
        }
    }

    /// The pointer is let go.
    pub(crate) fn end_sculpting(&mut self) {
        self.sculpting.is_given_up = false;
        if self.sculpting.stroke.take().is_some() {
            self.document.end_stroke();
        }
    }

    /// How strokes are made.
    pub(crate) fn sculpt_options(&mut self, ui: &mut egui::Ui) {
        ui.strong("Sculpt");
        ui.horizontal(|ui| {
            for kind in Kind::ALL {
                ui.selectable_value(&mut self.sculpting.kind, kind, kind.word());
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
            self.material_choice(ui, "Material of strokes", &mut material);
            self.sculpting.material = material;
        });
    }

    /// Sculpt in a way from now on.
    pub(crate) fn take_up(&mut self, kind: Kind) {
        self.tool = Tool::Sculpt;
        self.sculpting.kind = kind;
        if kind == Kind::Paint && self.sculpting.material.is_none() {
            self.sculpting.material = self.document.scene().materials().keys().next().cloned();
        }
    }
}
