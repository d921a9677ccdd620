//! Tests `argil compare`.

use crate::common::{argil, fails, json, scene};
use std::path::Path;

fn data(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/argil-metrics/tests/data");
    root.join(name).display().to_string()
}

#[test]
fn pictures_are_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let (a, b) = (data("teapot-field.png"), data("teapot-mesh.png"));
    let maps = ["flip.png", "laplacian.png"].map(|name| folder.path().join(name));
    let [flip, laplacian] = maps.clone().map(|path| path.display().to_string());
    let report = json(&argil(&[
        "compare",
        &a,
        &b,
        "--flip",
        &flip,
        "--laplacian",
        &laplacian,
        "--json",
    ]));
    let expected = std::fs::read_to_string(data("reference.json")).expect("numbers");
    let expected: serde_json::Value = serde_json::from_str(&expected).expect("JSON");
    for key in ["psnr_db", "ssim", "flip_mean", "laplacian_mean_abs"] {
        let (found, right) = (report[key].as_f64(), expected[0][key].as_f64());
        let off = found.zip(right).map(|(a, b)| (a - b).abs());
        assert!(
            off.is_some_and(|off| off < 1e-4),
            "{key}: {found:?} {right:?}"
        );
    }
    for key in [
        "differing_pixels",
        "laplacian_equal_pixels",
        "laplacian_histogram",
    ] {
        assert_eq!(report[key], expected[0][key], "{key}");
    }
    for map in &maps {
        let map = image::open(map).expect("a picture").to_rgb8();
        assert_eq!(map.dimensions(), (240, 160));
        assert!(map.pixels().any(|p| p.0 != [0; 3]));
    }
    let same = json(&argil(&["compare", &a, &a, "--json"]));
    assert!(
        same["psnr_db"].is_null() && same["differing_pixels"] == 0,
        "{same}"
    );
    assert_eq!(same["flip_mean"], 0.0);
}

#[test]
fn incomparable_images_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let a = data("teapot-field.png");
    let broken = folder.path().join("broken.png");
    let bytes = std::fs::read(&a).expect("a picture");
    std::fs::write(&broken, &bytes[..bytes.len() / 2]).expect("a file");
    let broken = broken.display().to_string();
    fails(&["compare", &a, &broken], 1, "broken.png");
    fails(&["compare", &a, "nothing.png"], 1, "nothing.png");
    fails(&["compare", &a, &data("reference.json")], 1, "PNG");
    let small = folder.path().join("small.png");
    image::RgbImage::new(8, 8).save(&small).expect("a picture");
    fails(
        &["compare", &a, &small.display().to_string()],
        1,
        "240x160 and 8x8",
    );
    fails(&["compare", &a, &a, "--flip", &a], 1, "teapot-field.png");
    fails(&["compare", &a, &a, "--flip", "map.jpg"], 1, ".png");
    fails(&["compare", &a], 2, "");
    fails(&["compare", &a, &a, "--pixels-per-degree", "nan"], 2, "");
    assert_eq!(std::fs::read(&a).expect("a picture"), bytes);
}

/// An image of bricks is close to the field's, and one from another side is not.
#[test]
fn rendered_images_are_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let draw = |name: &str, more: &[&str]| {
        let place = folder.path().join(name).display().to_string();
        let path = scene("edgy-cube");
        let mut all = vec!["render", &path, "--size", "160x120", "-o", &place, "--json"];
        all.extend(more);
        json(&argil(&all));
        place
    };
    let field = draw("field.png", &[]);
    let bricks = draw("bricks.png", &["--via", "bricks", "--resolution", "96"]);
    let behind = draw("behind.png", &["--camera", "200,20,3"]);
    let flip = |other: &str| {
        let report = json(&argil(&["compare", &field, other, "--json"]));
        report["flip_mean"].as_f64().expect("a number")
    };
    let (near, far) = (flip(&bricks), flip(&behind));
    assert!(near < 0.05 && far > 2.0 * near, "{near} {far}");
}
