//! Tests `--via levels`.

use crate::common::{argil, fails, json, scene};

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

/// A mesh has small triangles where the camera is, and no cracks where they become larger.
#[test]
fn a_mesh_of_levels_is_closed() {
    let folder = tempfile::tempdir().expect("a folder");
    let near = folder.path().join("near.json");
    // A camera close to the ground, so that nine levels are in use.
    let text = r#"{"argil": 1, "view": {"camera": {"look_at": {"eye": [0.02, 0.03, 0.1], "target": [0, 0, 0]}}},
        "brushes": [
            {"shape": {"type": "box", "half_size": [2, 0.2, 2]}, "modifiers": [
                {"type": "displace", "amplitude": 0.05, "frequency": 3, "octaves": 2, "seed": 1},
                {"type": "translate", "by": [0, -0.2, 0]}]},
            {"shape": {"type": "sphere", "radius": 0.4}, "operator": "subtract", "blend": 0.1, "modifiers": [
                {"type": "translate", "by": [0.8, 0, -0.6]}]},
            {"shape": {"type": "torus", "major_radius": 0.3, "minor_radius": 0.01}, "modifiers": [
                {"type": "translate", "by": [-0.9, 0.2, 0.3]}]}]}"#;
    std::fs::write(&near, text).expect("a file");
    let scene = near.display().to_string();
    let levels = ["--via", "levels", "--resolution", "8192"];
    let even = [
        "mesh",
        &scene,
        "--resolution",
        "256",
        "--json",
        "--device",
        "cpu",
    ];
    let even = json(&argil(&even));
    let file = folder.path().join("out.stl");
    let file = file.display().to_string();
    let out = [
        "--pixel-error",
        "8",
        "-o",
        &file,
        "--json",
        "--device",
        "gpu",
    ];
    let report = json(&argil(&[&["mesh", &scene][..], &levels, &out].concat()));
    assert_eq!(report["watertight"], true, "{report}");
    // Another library reads it, and finds no hole.
    let mut stl = std::fs::File::open(&file).expect("a file");
    let indexed = stl_io::read_stl(&mut stl).expect("an STL file");
    let mut directed = std::collections::HashMap::new();
    for face in &indexed.faces {
        let [a, b, c] = face.vertices;
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *directed.entry((a.min(b), a.max(b))).or_insert(0i32) += if a < b { 1 } else { -1 };
        }
    }
    assert!(directed.values().all(|&sum| sum == 0), "a hole");
    let mesh = argil::mesh::read(file.as_ref()).expect("a mesh file");
    let mesh = mesh.mesh.welded();
    let counted = argil::mesh::MeshReport::of(&mesh);
    assert!(counted.is_watertight(), "{counted:?}");
    // The finest edges are much shorter than the longest.
    let mut lengths: Vec<f32> = (0..mesh.triangles.len())
        .map(|triangle| {
            let [a, b, _] = mesh.triangle_vertices(triangle);
            a.distance(b)
        })
        .collect();
    lengths.sort_by(f32::total_cmp);
    let (short, long) = (lengths[lengths.len() / 50], lengths[lengths.len() - 1]);
    assert!(long > 30.0 * short, "{short} {long}");
    // The volume is that of a mesh of one size.
    let volume = |report: &serde_json::Value| report["enclosed_volume"].as_f64().unwrap_or(0.0);
    let (a, b) = (volume(&report), volume(&even));
    assert!((a - b).abs() < 5e-3 * b, "{a} {b}");
    let simple = [&["mesh", &scene][..], &levels, &["--max-triangles", "1000"]].concat();
    fails(&simple, 1, "choose the pixel error instead");
}
