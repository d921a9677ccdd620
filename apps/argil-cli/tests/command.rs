//! Tests the command as a script uses it: exit codes, messages, JSON, files.

use crate::common::{argil, fails, json, scene};
use std::path::{Path, PathBuf};
use std::process::Command;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

#[test]
fn every_scene_that_ships_is_drawn_and_can_be_written_again() {
    let folder = folder();
    let scenes: Vec<PathBuf> =
        std::fs::read_dir(format!("{}/../../scenes", env!("CARGO_MANIFEST_DIR")))
            .expect("the scenes")
            .map(|entry| entry.expect("an entry").path())
            .filter(|path| {
                path.extension().is_some_and(|e| e == "json")
                    && !text(path).ends_with("schema.json")
            })
            .collect();
    assert!(scenes.len() >= 9);
    for path in scenes {
        let read = argil::scene::Scene::open(&path).expect("a scene");
        assert_eq!(
            argil::scene::Scene::from_json(&read.to_json(), "again").expect("the same"),
            read
        );
        if text(&path).ends_with("city.json") {
            // `levels.rs` draws it, which takes long.
            continue;
        }
        let png = folder.path().join("x.png");
        let arguments = [
            "render",
            &text(&path),
            "-o",
            &text(&png),
            "--size",
            "64x40",
            "--device",
            "cpu",
            "--json",
        ];
        // The field of so many instances is slow.
        let is_wide = text(&path).ends_with("valley.json");
        let levels = [
            "--via",
            "levels",
            "--show",
            "normal",
            "--resolution",
            "1024",
        ];
        let flags = if is_wide { &levels[..] } else { &[] };
        let report = json(&argil(&[&arguments[..], flags].concat()));
        assert!(
            report["hit_pixels"].as_u64() > Some(150),
            "{path:?}: {report}"
        );
        assert_eq!(
            image::open(&png).expect("a PNG").to_rgb8().dimensions(),
            (64, 40)
        );
    }
}

#[test]
fn json_has_the_promised_keys_and_the_devices_agree() {
    let folder = folder();
    let mut pictures = Vec::new();
    for device in ["cpu", "gpu"] {
        let png = folder.path().join(format!("{device}.png"));
        let (scene, png_text) = (scene("csg20"), text(&png));
        let size = ["--size", "96x64", "--samples", "1", "--json"];
        let arguments = [
            &["render", &scene, "-o", &png_text, "--device", device][..],
            &size,
        ]
        .concat();
        let report = json(&argil(&arguments));
        assert!(
            report["device"]
                .as_str()
                .expect("a name")
                .starts_with(device)
        );
        assert_eq!(
            (report["via"].as_str(), report["brushes"].as_u64()),
            (Some("field"), Some(20))
        );
        for key in ["build_ms", "memory_bytes", "hit_pixels"] {
            assert!(report[key].as_f64() > Some(0.0), "{key}");
        }
        for key in ["min", "median", "p95", "max"] {
            assert!(report["frame_ms"][key].as_f64() > Some(0.0), "{key}");
        }
        for key in ["mean", "p95", "max"] {
            assert!(
                report["steps"][key].is_number() && report["fetches"][key].is_number(),
                "{key}"
            );
        }
        pictures.push((
            report["hit_pixels"].as_f64().expect("a number"),
            image::open(&png).expect("a PNG").to_rgb8(),
        ));
    }
    // A ray that grazes something within a tenth of a pixel may hit on one of them.
    let hits = [pictures[0].0, pictures[1].0];
    assert!((hits[0] - hits[1]).abs() <= 3.0, "{hits:?}");
    let differ = pictures[0]
        .1
        .iter()
        .zip(pictures[1].1.iter())
        .filter(|(a, b)| a.abs_diff(**b) > 2)
        .count();
    assert!(differ < 96 * 64 * 3 / 200, "{differ}");
}

/// A warning precedes slow work.
#[test]
fn scenes_that_take_long_say_why() {
    let folder = folder();
    let place = folder.path().join("many.json").display().to_string();
    let draw = |spacing: [f32; 2]| {
        let [inner, outer] = spacing;
        let text = format!(
            r#"{{"argil": 1, "brushes": [{{"brushes": [{{"shape": {{"type": "box", "half_size": [0.3, 0.3, 0.3]}},
            "modifiers": [{{"type": "rotate", "axis": [1, 1, 0], "degrees": 20}}, {{"type": "repeat", "spacing": [{inner}, {inner}, {inner}], "count": [4, 4, 4]}}]}}],
            "modifiers": [{{"type": "repeat", "spacing": [{outer}, 0, 0], "count": [5, 1, 1]}}]}}]}}"#
        );
        std::fs::write(&place, text).expect("a file");
        let picture = folder.path().join("p.png").display().to_string();
        let output = argil(&[
            "render", &place, "-o", &picture, "--size", "16x16", "--show", "normal",
        ]);
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert_eq!(draw([2.0, 20.0]), "");
    let warned = draw([0.25, 0.5]);
    assert!(
        warned.contains("many.json: this will be slow: each point evaluates 320 copies"),
        "{warned}"
    );
}

#[test]
fn an_orbit_is_timed_and_numbered() {
    let folder = folder();
    let png = text(&folder.path().join("o.png"));
    let arguments = [
        "render",
        &scene("brick"),
        "-o",
        &png,
        "--frames",
        "3",
        "--size",
        "32x32",
        "--show",
        "heat",
        "--json",
    ];
    assert_eq!(json(&argil(&arguments))["frames"], 3);
    let names: Vec<_> = (0..3)
        .map(|i| folder.path().join(format!("o-{i:04}.png")))
        .collect();
    assert!(names.iter().all(|n| n.exists()));
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        3,
        "nothing else is left behind"
    );
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of requests")]
fn faults_of_the_request_have_their_codes_and_remedies() {
    let folder = folder();
    let path = |name: &str| text(&folder.path().join(name));
    let write = |name: &str, content: &str| {
        std::fs::write(folder.path().join(name), content).expect("a file");
        path(name)
    };
    let out = path("x.png");
    // 1: the input or the request.
    fails(
        &["render", &path("none.json"), "-o", &out],
        1,
        "none.json: this file cannot be read or written: No such file",
    );
    fails(
        &["render", &text(folder.path()), "-o", &out],
        1,
        "is a folder",
    );
    let negative = write(
        "a.json",
        r#"{"argil": 1, "brushes": [{"shape": {"type": "sphere", "radius": -1}}]}"#,
    );
    fails(
        &["render", &negative, "-o", &out],
        1,
        "brushes[0].shape.radius: -1 is not positive",
    );
    let newer = write("b.json", r#"{"argil": 9, "whatever": []}"#);
    fails(
        &["info", &newer],
        1,
        "format version 9 is newer than this program reads (1): update argil",
    );
    fails(
        &["render", &write("c.json", "\u{0}garbage"), "-o", &out],
        1,
        "c.json:1:1",
    );
    let infinite = write(
        "d.json",
        r#"{"argil": 1, "brushes": [{"shape": {"type": "plane", "normal": [0, 1, 0]},
            "modifiers": [{"type": "twist", "degrees_per_unit": 10}]}]}"#,
    );
    fails(
        &["render", &infinite, "-o", &out],
        1,
        "brushes[0]: twist needs a solid of finite size",
    );
    let crowded = write(
        "e.json",
        r#"{"argil": 1, "brushes": [{"shape": {"type": "capsule", "from": [-9, -9, 0], "to": [9, 9, 0], "radius": 1},
            "modifiers": [{"type": "repeat", "spacing": [0.01, 0.01, 0.01]}]}]}"#,
    );
    fails(&["info", &crowded], 1, "increase the spacing");
    fails(
        &["render", &scene("brick"), "-o", &path("no/x.png")],
        1,
        "no",
    );
    fails(
        &["render", &scene("brick"), "-o", &path("x.jpg")],
        1,
        "name it .png",
    );
    fails(
        &["render", &scene("brick"), "-o", &out, "--epsilon=-1"],
        2,
        "expected a length above 0",
    );
    fails(
        &[
            "render",
            &scene("brick"),
            "-o",
            &out,
            "--normal-bias",
            "nan",
        ],
        2,
        "--normal-bias",
    );
    fails(
        &[
            "render",
            &scene("brick"),
            "-o",
            &out,
            "--specialize",
            "--device",
            "cpu",
        ],
        1,
        "add --device gpu",
    );
    fails(
        &["import", &scene("brick"), "-o", &path("t.json")],
        1,
        "already a scene",
    );
    let no_tree = path("no-tree.json");
    std::fs::write(&no_tree, "{}").expect("a file");
    fails(
        &["import", &no_tree, "-o", &path("t.json")],
        1,
        "nodeType: is missing",
    );
    // 2: usage.
    fails(
        &["render", &scene("brick"), "--size", "0x10"],
        2,
        "each side must be 1 to 16384",
    );
    fails(
        &["render", &scene("brick"), "--size", "1000000x10"],
        2,
        "16384",
    );
    fails(
        &["render", &scene("brick"), "--camera", "1,2"],
        2,
        "AZIMUTH,ELEVATION,DISTANCE",
    );
    fails(
        &["render", &scene("brick"), "--camera", "0,nan,2"],
        2,
        "is not from -90 to 90",
    );
    fails(
        &["render", &scene("brick"), "--via", "voxels"],
        2,
        "invalid value",
    );
    fails(&["render"], 2, "required");
    assert!(!folder.path().join("x.png").exists());
}

/// Exit code 3 blames the machine. Without any driver there is no GPU.
#[test]
fn a_machine_without_a_gpu_says_so() {
    let folder = folder();
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_argil"))
            .args(arguments)
            .env("VK_DRIVER_FILES", "/nonexistent.json")
            .env("VK_ICD_FILENAMES", "/nonexistent.json")
            .env("WGPU_BACKEND", "vulkan")
            .output()
            .expect("the command starts")
    };
    let png = text(&folder.path().join("x.png"));
    let output = run(&["render", &scene("brick"), "-o", &png, "--device", "gpu"]);
    assert_eq!(
        output.status.code(),
        Some(3),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(String::from_utf8_lossy(&output.stderr).contains("mesa-vulkan-drivers"));
    let listed = run(&["devices", "--json"]);
    assert_eq!(json(&listed)["devices"].as_array().map(Vec::len), Some(0));
    let auto = run(&[
        "render",
        &scene("brick"),
        "-o",
        &png,
        "--size",
        "32x32",
        "--json",
    ]);
    assert!(
        json(&auto)["device"]
            .as_str()
            .expect("a name")
            .starts_with("cpu")
    );
}

/// Returns a tree of `depth` operators that leans to one side.
fn tree(depth: usize, left: bool) -> String {
    let leaf = |i: usize| {
        format!(
            r#"{{"nodeType": "primitive", "primitiveType": "sphere", "radius": 0.1, "round_x": 0, "round_y": 0,
            "color": [0.5, 0.2, 0.1], "matrix": [1, 0, 0, {x}, 0, 1, 0, 0, 0, 0, 1, 0]}}"#,
            x = -(i as f32) * 0.01
        )
    };
    let operator = r#""nodeType": "binaryOperator", "blendMode": "union", "blendRadius": 0.05"#;
    let mut text = String::new();
    for i in 0..depth {
        let other = leaf(i);
        text += &if left {
            format!(r#"{{{operator}, "rightChild": {other}, "leftChild": "#)
        } else {
            format!(r#"{{{operator}, "leftChild": {other}, "rightChild": "#)
        };
    }
    text + &leaf(depth) + &"}".repeat(depth)
}

#[test]
fn trees_thousands_of_levels_deep_are_imported_and_drawn() {
    let folder = folder();
    for left in [true, false] {
        let (from, to) = (
            folder.path().join("tree.json"),
            folder.path().join("scene.json"),
        );
        std::fs::write(&from, tree(5000, left)).expect("a file");
        let report = json(&argil(&[
            "import",
            &text(&from),
            "-o",
            &text(&to),
            "--json",
        ]));
        assert_eq!(report["brushes"], 5001);
        let info = json(&argil(&["info", &text(&to), "--json"]));
        // However deep, evaluation needs a handful of slots.
        assert!(info["stack_slots"][0].as_u64() < Some(4), "{info}");
        let png = text(&folder.path().join("x.png"));
        let size = [
            "--size",
            "16x16",
            "--samples",
            "1",
            "--device",
            "cpu",
            "--json",
        ];
        let to = text(&to);
        let arguments = [&["render", &to, "-o", &png][..], &size].concat();
        assert!(json(&argil(&arguments))["hit_pixels"].as_u64() > Some(0));
    }
}

/// What a voxel is larger than can be lost, and the message says so.
#[test]
fn a_mesh_without_triangles_names_the_voxels() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let ball = |x: f32| {
        format!(
            r#"{{"shape":{{"type":"sphere","radius":0.01}},"modifiers":[{{"type":"translate","by":[{x},0.3,0]}}]}}"#
        )
    };
    let text = format!(r#"{{"argil":1,"brushes":[{},{}]}}"#, ball(-5.0), ball(5.2));
    std::fs::write(place("two.json"), text).expect("a file");
    let mesh = ["mesh", &place("two.json"), "-o", &place("two.glb")];
    fails(
        &[&mesh[..], &["--resolution", "8"]].concat(),
        1,
        "raise --resolution",
    );
    std::fs::write(place("none.json"), r#"{"argil":1,"brushes":[]}"#).expect("a file");
    fails(
        &["mesh", &place("none.json"), "-o", &place("two.glb")],
        1,
        "none.json",
    );
    #[cfg(not(feature = "world"))]
    fails(&["world", "plan", "--help"], 3, "--features world");
}
