//! Tests `--via levels`.

mod common;

use common::{argil, fails, json, scene};

/// Levels are as fine as the pixels, within the memory that they were given.
#[test]
fn levels_say_what_a_view_brought() {
    let (folder, brick) = (tempfile::tempdir().expect("a folder"), scene("brick"));
    let out = folder.path().join("x.png").display().to_string();
    let size = ["--size", "160x90", "--show", "normal", "--device", "cpu"];
    let levels = ["render", &brick, "-o", &out, "--via", "levels", "--json"];
    let found = json(&argil(&[&levels[..], &size].concat()));
    assert_eq!(found["finest_voxels"].as_array().map(Vec::len), Some(3));
    let voxels = found["finest_voxels"].as_array().into_iter().flatten();
    let longest = voxels.filter_map(serde_json::Value::as_u64).max();
    assert!(
        longest.is_some_and(|n| (16_000..=16_400).contains(&n)),
        "{longest:?}"
    );
    assert_eq!(found["bricks_missing"], 0);
    assert_eq!(found["is_full"], false);
    assert!(found["levels_bytes"].as_u64() <= Some(160 << 20));
    let on_gpu = ["--size", "160x90", "--show", "normal", "--device", "gpu"];
    let there = json(&argil(&[&levels[..], &on_gpu].concat()));
    assert_eq!(there["bricks_missing"], 0);
    assert_eq!(there["finest_voxels"], found["finest_voxels"]);
    assert!(there["hit_pixels"].as_u64() > Some(0));
    let orbit = [
        &levels[..],
        &size,
        &["--frames", "3", "--memory-budget", "8"],
    ]
    .concat();
    let found = json(&argil(&orbit));
    assert!(found["levels_bytes"].as_u64() <= Some(8 << 20));
    assert_eq!(found["frames"], 3);
}

/// A camera follows a path of the view, with what some milliseconds per frame bring.
#[test]
fn a_camera_follows_a_path() {
    let city = scene("city");
    let size = ["--size", "64x36", "--show", "normal", "--device", "cpu"];
    let levels = [
        "render", &city, "--via", "levels", "--json", "--frames", "3",
    ];
    let flight = ["--path", "flight", "--fill-ms", "20"];
    let found = json(&argil(&[&levels[..], &size, &flight].concat()));
    assert_eq!(found["frames"], 3);
    assert_eq!(found["brushes"], 300_001);
    assert!(found["coarse_share"]["max"].as_f64() > Some(0.0));
    let stray = [&levels[..], &size, &["--path", "stroll"]].concat();
    fails(
        &stray,
        1,
        "the scene has no path \"stroll\", but flight, walk",
    );
    fails(&["render", &city, "--path", "walk"], 2, "--frames");
}
