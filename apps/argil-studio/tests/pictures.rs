//! Compares the window with stored images. `UPDATE_PICTURES=1` replaces them by the current ones.

use crate::common::{Begin, Desk};
use argil_metrics::Rgb8Image;
use argil_metrics::flip::{PIXELS_PER_DEGREE, flip};
use eframe::egui::{Key, Modifiers, Vec2};
use image::RgbImage;
use std::path::PathBuf;

fn begin(is_on_gpu: bool) -> Begin {
    Begin {
        is_drawn: true,
        is_on_gpu,
        ..Begin::default()
    }
}

fn desk() -> Desk {
    let mut desk = Desk::new(begin(false));
    // Times are not the same twice.
    desk.press(Modifiers::NONE, Key::I);
    desk
}

fn picture(desk: &mut Desk) -> RgbImage {
    desk.settle();
    let picture = desk.window.render().expect("a device to draw windows with");
    image::DynamicImage::from(picture).to_rgb8()
}

fn looks_as_before(desk: &mut Desk, name: &str) {
    let shown = picture(desk);
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/pictures")
        .join(format!("{name}.png"));
    if std::env::var_os("UPDATE_PICTURES").is_some() {
        shown.save(&file).expect("a file");
    }
    let before = image::open(&file).expect("a picture").to_rgb8();
    let seen = flip(&measured(&before), &measured(&shown), PIXELS_PER_DEGREE)
        .expect("one size")
        .mean();
    if seen > 0.01 {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
        let found = folder.join(format!("{name}.png"));
        shown.save(&found).expect("a file");
        panic!("{name}: FLIP {seen:.4}, see {}", found.display());
    }
}

fn is_other(desk: &mut Desk, name: &str) {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/pictures")
        .join(format!("{name}.png"));
    let shown = picture(desk);
    let before = image::open(&file).expect("a picture").to_rgb8();
    let seen = flip(&measured(&before), &measured(&shown), PIXELS_PER_DEGREE)
        .expect("one size")
        .mean();
    assert!(seen > 0.01, "{seen}");
}

#[test]
fn a_brush_is_selected_and_inspected() {
    let mut desk = desk();
    desk.click("belly");
    desk.click("Move");
    looks_as_before(&mut desk, "selected");
    // The other way round: what has changed is seen.
    desk.press(Modifiers::NONE, Key::Delete);
    is_other(&mut desk, "selected");
}

#[test]
fn two_pipelines_are_compared() {
    let mut desk = desk();
    desk.press(Modifiers::NONE, Key::V);
    desk.settle();
    let middle = desk.place_of("Divider");
    desk.drag(middle, middle + Vec2::new(-120.0, 0.0), Modifiers::NONE);
    desk.click("Heat");
    looks_as_before(&mut desk, "split");
}

/// Images that stay on the window's GPU look like those from the CPU, two beside each other and their difference, too.
#[test]
fn the_gpu_of_the_window_draws_the_same() {
    let seen = [false, true].map(|is_on_gpu| {
        let mut desk = Desk::new(Begin {
            is_small: true,
            ..begin(is_on_gpu)
        });
        desk.press(Modifiers::NONE, Key::I);
        desk.click("Bricks");
        desk.click("Normal");
        let mut views = vec![picture(&mut desk)];
        desk.press(Modifiers::NONE, Key::V);
        views.push(picture(&mut desk));
        desk.press(Modifiers::SHIFT, Key::V);
        views.push(picture(&mut desk));
        assert_eq!(desk.fault(), None);
        views
    });
    let [on_cpu, on_gpu] = &seen;
    let apart = |a, b| {
        let map = flip(&measured(a), &measured(b), PIXELS_PER_DEGREE);
        map.expect("one size").mean()
    };
    for (a, b) in on_cpu.iter().zip(on_gpu) {
        assert!(apart(a, b) < 0.01, "{}", apart(a, b));
    }
    assert!(apart(&on_gpu[0], &on_gpu[2]) > 0.03);
}

#[test]
fn bricks_are_seen_from_above() {
    let mut desk = desk();
    desk.click("Brick colors");
    desk.press(Modifiers::NONE, Key::F7);
    looks_as_before(&mut desk, "top");
}

fn measured(picture: &RgbImage) -> Rgb8Image {
    Rgb8Image::new(picture.dimensions().into(), picture.as_raw().clone()).expect("a picture")
}
