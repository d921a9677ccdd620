//! Images of steps.

use crate::common::{argil, json, scene};

/// The scale is the image's own, in each representation: colors of all thirds are there, and a legend is drawn.
#[test]
fn images_of_steps_have_a_scale_of_their_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let png = folder.path().join("heat.png").display().to_string();
    for via in ["field", "bricks"] {
        let arguments = [
            "render",
            &scene("csg20"),
            "-o",
            &png,
            "--via",
            via,
            "--device",
            "cpu",
        ];
        let look = ["--show", "heat", "--size", "320x240", "--json"];
        let report = json(&argil(&[&arguments[..], &look].concat()));
        let most = report["heat_steps"].as_f64().expect("a number");
        let p95 = report["steps"]["p95"].as_f64().expect("a number");
        assert!(
            most >= 8.0 && most <= 1.6 * p95 + 8.0,
            "{via}: {most} {p95}"
        );
        let picture = image::open(&png).expect("a PNG").to_rgb8();
        let above_legend = picture.enumerate_pixels().filter(|(_, y, _)| *y < 220);
        let greens = above_legend.filter(|(_, _, pixel)| pixel[1] > 128 || pixel[0] > 128);
        let share = greens.count() as f64 / f64::from(320 * 220);
        assert!(share > 0.04, "{via}: {share}");
        let is_white = |x: u32| (220..240).any(|y| picture.get_pixel(x, y).0 == [255; 3]);
        assert!(
            is_white(4) && is_white(4 + 32),
            "{via}: a legend with marks"
        );
    }
}
