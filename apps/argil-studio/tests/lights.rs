//! Tests what a user does with lights and textures.

use crate::common::{Begin, Desk};
use argil::scene::{Light, Pattern};
use eframe::egui::{Key, Modifiers};

fn desk() -> Desk {
    let mut desk = Desk::new(Begin::default());
    desk.step();
    desk.choose("File", "New");
    desk.click("Add Sphere");
    desk
}

#[test]
fn lights_are_added_and_taken_back() {
    let mut desk = desk();
    desk.click("Light");
    desk.click("Only the sun of the view");
    let kinds = |desk: &Desk| desk.scene().view.lights.clone().map(|all| all.len());
    assert_eq!(kinds(&desk), Some(1));
    desk.click("Add area");
    let last = |desk: &Desk| desk.scene().view.lights.iter().flatten().last().cloned();
    assert!(matches!(last(&desk), Some(Light::Area { .. })));
    desk.click("Fog");
    assert!(desk.scene().view.fog.is_some());
    desk.press(Modifiers::COMMAND, Key::Z);
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(kinds(&desk), Some(1));
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(kinds(&desk), None);
    assert!(desk.studio().fault().is_none());
}

#[test]
fn a_material_gets_a_texture() {
    let mut desk = desk();
    desk.click("New material");
    desk.click("material 1");
    desk.click("Textures");
    desk.click("Color texture");
    let textures = |desk: &Desk| {
        let material = desk.scene().materials().get("material 1").cloned();
        material.and_then(|material| material.textures)
    };
    let edited = textures(&desk).expect("textures");
    let color = edited.base_color.expect("a color texture");
    assert_eq!(color.pattern, Pattern::Checker);
    desk.settle();
    desk.press(Modifiers::COMMAND, Key::Z);
    assert!(textures(&desk).is_none());
}
