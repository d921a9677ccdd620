//! The keyframes of the selection.

use crate::icon::{self, Icon};
use crate::segmented_control::choice;
use crate::values::number;
use argil::scene::{AxisAngle, Ease, Keyframe, NodeDesc};
use eframe::egui::{self, RichText};

/// Shows a node's keyframes for editing.
pub(crate) fn keyframes(ui: &mut egui::Ui, entry: &mut NodeDesc, done: &mut Option<String>) {
    let before = entry.keyframes.clone();
    ui.horizontal(|ui| {
        ui.label("Keyframes");
        if ui.button("Add keyframe").clicked() {
            entry.keyframes.push(following(before.last()));
        }
    });
    let mut gone = None;
    for (i, keyframe) in entry.keyframes.iter_mut().enumerate() {
        ui.push_id(("keyframe", i), |ui| {
            ui.horizontal(|ui| {
                ui.label(RichText::new(format!("{}", i + 1)).strong());
                number(
                    ui,
                    &format!("Keyframe {} time", i + 1),
                    "time",
                    &mut keyframe.time,
                );
                let all = [Ease::Linear, Ease::Smooth, Ease::Hold];
                choice(ui, "Ease", &mut keyframe.ease, all, |ease| {
                    word(*ease).into()
                });
                let words = format!("Remove keyframe {}", i + 1);
                if icon::button(ui, Icon::Cross, true, &words).clicked() {
                    gone = Some(i);
                }
            });
            values(ui, keyframe);
        });
    }
    if let Some(i) = gone {
        entry.keyframes.remove(i);
    }
    if entry.keyframes != before {
        *done = Some("Change keyframes".into());
    }
}

/// Returns a copy of the last keyframe, one second later.
fn following(last: Option<&Keyframe>) -> Keyframe {
    match last {
        Some(last) => Keyframe {
            time: last.time + 1.0,
            ..last.clone()
        },
        None => Keyframe {
            translate: Some([0.0; 3]),
            ..Keyframe::default()
        },
    }
}

fn word(ease: Ease) -> &'static str {
    match ease {
        Ease::Linear => "linear",
        Ease::Smooth => "smooth",
        Ease::Hold => "hold",
    }
}

fn values(ui: &mut egui::Ui, keyframe: &mut Keyframe) {
    stated(
        ui,
        "Translate",
        &mut keyframe.translate,
        [0.0; 3],
        |ui, by| {
            for (axis, value) in ["x", "y", "z"].iter().zip(by) {
                number(
                    ui,
                    &format!("Keyframe translate {axis}"),
                    "translate",
                    value,
                );
            }
        },
    );
    let still = AxisAngle {
        axis: [0.0, 1.0, 0.0],
        degrees: 0.0,
    };
    stated(ui, "Rotate", &mut keyframe.rotate, still, |ui, turn| {
        for (axis, value) in ["x", "y", "z"].iter().zip(&mut turn.axis) {
            number(ui, &format!("Keyframe axis {axis}"), "axis", value);
        }
        number(ui, "Keyframe degrees", "degrees", &mut turn.degrees);
    });
    stated(ui, "Scale", &mut keyframe.scale, 1.0, |ui, by| {
        number(ui, "Scale of the keyframe", "scale", by);
    });
    stated(
        ui,
        "Amount of the morph",
        &mut keyframe.amount,
        0.0,
        |ui, amount| {
            ui.add(egui::Slider::new(amount, 0.0..=1.0));
        },
    );
    stated(ui, "Blend radius", &mut keyframe.blend, 0.0, |ui, blend| {
        number(ui, "Keyframe blend radius", "blend", blend);
        *blend = blend.max(0.0);
    });
}

/// Shows a value that a keyframe may set or leave unset.
fn stated<T>(
    ui: &mut egui::Ui,
    name: &str,
    value: &mut Option<T>,
    first: T,
    show: impl FnOnce(&mut egui::Ui, &mut T),
) {
    ui.horizontal_wrapped(|ui| {
        let mut is_stated = value.is_some();
        if ui.checkbox(&mut is_stated, name).changed() {
            *value = is_stated.then_some(first);
        }
        if let Some(value) = value {
            show(ui, value);
        }
    });
}
