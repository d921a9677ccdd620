//! Textures of materials.

use crate::docs::Docs;
use crate::segmented_control::choice;
use crate::values::edit_fields;
use argil::scene::{
    ColorTexture, LoadedImage, Mapping, Material, Pattern, TextureSpace, ValueTexture,
};
use eframe::egui;

/// Shows the textures of a material, to add, change and remove.
pub(crate) fn textures(docs: &Docs, ui: &mut egui::Ui, material: &mut Material) {
    let mut edited = material.textures.take().unwrap_or_default();
    egui::CollapsingHeader::new("Textures").show(ui, |ui| {
        color(docs, ui, &mut edited.base_color);
        for (name, texture, high) in [
            ("Roughness texture", &mut edited.roughness, 1.0),
            ("Metallic texture", &mut edited.metallic, 1.0),
            ("Bump texture", &mut edited.bump, 0.02),
        ] {
            value(docs, ui, name, texture, high);
        }
    });
    material.textures = (!edited.is_empty()).then_some(edited);
}

fn color(docs: &Docs, ui: &mut egui::Ui, texture: &mut Option<ColorTexture>) {
    let mut is_there = texture.is_some();
    if ui.checkbox(&mut is_there, "Color texture").changed() {
        *texture = is_there.then(ColorTexture::default);
    }
    let Some(texture) = texture else { return };
    ui.push_id("color", |ui| {
        pattern(
            docs,
            ui,
            "Color texture",
            &mut texture.pattern,
            &mut texture.space,
        );
        ui.horizontal(|ui| {
            ui.label("From");
            ui.color_edit_button_rgb(&mut texture.low);
            ui.label("to");
            ui.color_edit_button_rgb(&mut texture.high);
        });
        size(ui, &mut texture.size);
    });
}

fn value(
    docs: &Docs,
    ui: &mut egui::Ui,
    name: &str,
    texture: &mut Option<ValueTexture>,
    high: f32,
) {
    let mut is_there = texture.is_some();
    if ui.checkbox(&mut is_there, name).changed() {
        *texture = is_there.then(|| ValueTexture {
            high,
            ..ValueTexture::default()
        });
    }
    let Some(texture) = texture else { return };
    ui.push_id(name, |ui| {
        pattern(docs, ui, name, &mut texture.pattern, &mut texture.space);
        ui.horizontal(|ui| {
            ui.label("From");
            crate::values::number(ui, &format!("{name} from"), "low", &mut texture.low);
            ui.label("to");
            crate::values::number(ui, &format!("{name} to"), "high", &mut texture.high);
        });
        size(ui, &mut texture.size);
    });
}

fn size(ui: &mut egui::Ui, size: &mut f32) {
    ui.horizontal(|ui| {
        ui.label("Size");
        crate::values::number(ui, "Texture size", "size", size);
        *size = size.max(1e-3);
    });
}

const PATTERNS: [&str; 7] = [
    "Checker", "Stripes", "Noise", "Wood", "Marble", "Brick", "Image",
];

fn pattern_index(pattern: &Pattern) -> usize {
    match pattern {
        Pattern::Checker => 0,
        Pattern::Stripes => 1,
        Pattern::Noise { .. } => 2,
        Pattern::Wood => 3,
        Pattern::Marble => 4,
        Pattern::Brick => 5,
        Pattern::Image { .. } => 6,
    }
}

fn pattern(
    docs: &Docs,
    ui: &mut egui::Ui,
    name: &str,
    edited: &mut Pattern,
    space: &mut TextureSpace,
) {
    let mut index = pattern_index(edited);
    ui.horizontal(|ui| {
        let all = 0..PATTERNS.len();
        choice(ui, name, &mut index, all, |&index| PATTERNS[index].into());
        let spaces = [TextureSpace::Brush, TextureSpace::World];
        choice(ui, &format!("{name} moves with"), space, spaces, |space| {
            let word = match space {
                TextureSpace::Brush => "with the brush",
                TextureSpace::World => "in the scene",
            };
            word.into()
        });
    });
    if index != pattern_index(edited) {
        *edited = match index {
            0 => Pattern::Checker,
            1 => Pattern::Stripes,
            2 => Pattern::Noise { octaves: 4 },
            3 => Pattern::Wood,
            4 => Pattern::Marble,
            5 => Pattern::Brick,
            _ => Pattern::Image {
                path: "texture.png".into(),
                mapping: Mapping::Biplanar,
                image: LoadedImage::default(),
            },
        };
    }
    if let Pattern::Image { mapping, .. } = edited {
        let all = [Mapping::Biplanar, Mapping::Triplanar];
        choice(ui, &format!("{name} mapping"), mapping, all, |mapping| {
            format!("{mapping:?}")
        });
    }
    let kind = PATTERNS[index].to_lowercase();
    edit_fields(ui, name, edited, |key| docs.of("Pattern", &kind, key));
}
