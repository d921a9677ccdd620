//! Tests edits by the command.

use crate::common::{argil, fails, json, scene};

const EDITS: &str = r#"{"edit": "insert", "entry": {"operator": "subtract", "blend": 0.02, "shape": {"type": "sphere", "radius": 0.2}, "modifiers": [{"type": "translate", "by": [0.3, 0.9, 0.9]}]}}

{"edit": "begin_stroke"}
{"edit": "transform", "node": "brushes[0]", "by": {"type": "translate", "by": [0, 0.02, 0]}}
{"edit": "transform", "node": "brushes[0]", "by": {"type": "translate", "by": [0, 0.02, 0]}}
{"edit": "end_stroke"}
{"edit": "undo"}
{"edit": "redo"}
{"edit": "set_visible", "node": "brushes[1]", "visible": false}
{"edit": "undo"}
"#;

/// Edits a scene and a volume on both devices. The written scene bakes to the written volume.
#[test]
fn edits_are_replayed_timed_and_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let edits = place("edits.jsonl");
    std::fs::write(&edits, EDITS).expect("a file");
    let teapot = scene("teapot");
    let mut counts = Vec::new();
    for device in ["cpu", "gpu"] {
        let (volume, edited) = (place("v.argil"), place("edited.json"));
        let run = ["edit", &teapot, "--edits", &edits, "--resolution", "64"];
        let more = ["--device", device, "--check", "--json", "-o", &volume];
        let report = json(&argil(
            &[&run[..], &more, &["--scene-output", &edited]].concat(),
        ));
        let done = report["edits"].as_array().expect("a list");
        assert_eq!(done.len(), 7);
        assert!(done.iter().all(|e| e["duration_ms"].as_f64() > Some(0.0)));
        assert_eq!(report["differing_cells"], 0);
        assert_eq!(report["rebuilt"], 0);
        {
            let bricks = done[0]["bricks"].as_u64();
            assert!(bricks > Some(5) && bricks < report["edits"][1]["bricks"].as_u64());
            assert!(done[0]["dirty_box"][0][0].as_f64() < Some(0.3));
        }
        let held = json(&argil(&["info", &volume, "--json"]));
        counts.push(held["bricks"].as_u64().expect("a number"));
        let about = json(&argil(&["info", &edited, "--json"]));
        assert_eq!(about["brushes"], report["brushes"]);
        // The volume goes on being edited, with the scene that it carries.
        let again = ["edit", &volume, "--edits", &edits, "--device", device];
        let again = json(&argil(&[&again[..], &["--check", "--json"]].concat()));
        assert_eq!(
            again["brushes"].as_u64(),
            Some(report["brushes"].as_u64().unwrap_or(0) + 1)
        );
        assert_eq!(again["differing_cells"], 0);
    }
    // The same log gives the same volume on the other device, but for bricks that a rounding decides.
    assert!(counts[0].abs_diff(counts[1]) <= 2, "{counts:?}");
}

/// A journal stays until the scene is written, and is not overwritten.
#[test]
fn a_journal_brings_edits_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let [edits, bad, journal, found, edited] =
        ["e.jsonl", "bad.jsonl", "j", "found.json", "edited.json"].map(place);
    std::fs::write(&edits, EDITS).expect("a file");
    let third = EDITS.lines().take(3).collect::<Vec<_>>().join("\n");
    std::fs::write(&bad, third + "\nno edit").expect("a file");
    let teapot = scene("teapot");
    let run = |edits| {
        let journal: &str = &journal;
        [
            "edit",
            &teapot,
            "--edits",
            edits,
            "--resolution",
            "32",
            "--journal",
            journal,
        ]
    };
    // It stops half way; what was done is not lost.
    fails(&run(&bad), 1, "bad.jsonl:4");
    std::fs::remove_file(&journal).expect("removed");
    // And it says where that is.
    fails(&run(&bad), 1, &format!("argil recover {journal}"));
    let report = json(&argil(&["recover", &journal, "-o", &found, "--json"]));
    assert_eq!(report["edits"], 2);
    fails(&run(&edits), 1, "argil recover");
    std::fs::remove_file(&journal).expect("removed");
    argil(&[&run(&edits)[..], &["--scene-output", &edited]].concat());
    assert!(!std::path::Path::new(&journal).exists());
    fails(&["recover", &edited, "-o", &found], 1, "not a journal");
    // No output replaces another, or what is read.
    let both = [&run(&edits)[..], &["--scene-output", &journal]].concat();
    fails(&both, 1, "two outputs");
    let read = [&run(&edits)[..], &["-o", &edits]].concat();
    fails(&read, 1, "this is the input");
}

/// A journal is whole before the bake. One that a killed program left empty is nobody's.
#[test]
fn a_kill_during_the_bake_leaves_a_whole_journal() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let [edits, journal, found] = ["e.jsonl", "j", "found.json"].map(place);
    std::fs::write(&edits, EDITS).expect("a file");
    std::fs::write(&journal, "").expect("a file");
    fails(
        &["recover", &journal, "-o", &found],
        1,
        "nothing was recorded",
    );
    let teapot = scene("teapot");
    let run = |resolution| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_argil"));
        command.args([
            "edit",
            &teapot,
            "--edits",
            &edits,
            "--resolution",
            resolution,
        ]);
        command.args(["--journal", &journal]);
        command
    };
    let mut killed = run("1500").spawn().expect("a process");
    while std::fs::metadata(&journal).map_or(0, |about| about.len()) == 0 {
        assert!(killed.try_wait().expect("a process").is_none());
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    killed.kill().expect("killed");
    killed.wait().expect("its end");
    let report = json(&argil(&["recover", &journal, "-o", &found, "--json"]));
    assert_eq!(report["edits"], 0);
    // A bake that fails leaves none.
    std::fs::remove_file(&journal).expect("removed");
    assert_eq!(run("3").status().expect("a process").code(), Some(1));
    assert!(!std::path::Path::new(&journal).exists());
}

/// A log with a byte order mark, as editors write it, inserts a mesh whose file is next to the scene's.
#[test]
fn a_log_can_bring_a_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    std::fs::copy(scene("csg20"), place("s.json")).expect("a copy");
    let suzanne = format!("{}/../../scenes/suzanne.obj", env!("CARGO_MANIFEST_DIR"));
    std::fs::copy(suzanne, place("suzanne.obj")).expect("a copy");
    let edit = r#"{"edit": "insert", "entry": {"shape": {"type": "mesh", "path": "suzanne.obj", "resolution": 32}}}"#;
    let edits = place("edits.jsonl");
    std::fs::write(&edits, format!("\u{feff}{edit}\r\n")).expect("a file");
    let file = place("s.json");
    let run = [
        "edit",
        &file,
        "--edits",
        &edits,
        "--resolution",
        "48",
        "--check",
    ];
    let output = argil(&[&run[..], &["--json"]].concat());
    let warned = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(warned.contains("suzanne.obj: closed 4 holes"), "{warned}");
    assert_eq!(json(&output)["differing_cells"], 0);
    // Only the first line can have such a mark, and a file that is not there is named.
    std::fs::write(&edits, format!("{edit}\n\u{feff}{edit}\n")).expect("a file");
    fails(&run, 1, "edits.jsonl:2: ");
    std::fs::write(&edits, edit.replace("suzanne.obj", "gone.obj")).expect("a file");
    fails(&run, 1, "gone.obj");
}

#[test]
fn edits_that_cannot_be_done_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let teapot = scene("teapot");
    let edits = place("edits.jsonl");
    std::fs::write(
        &edits,
        format!("{EDITS}{{\"edit\": \"redo\"}}\n{{\"edit\": \"redo\"}}\n"),
    )
    .expect("a file");
    let run = ["edit", &teapot, "--edits", &edits, "--resolution", "32"];
    let volume = place("v.argil");
    let run = [&run[..], &["--device", "cpu", "-o", &volume]].concat();
    fails(&run, 1, "edits.jsonl:12: nothing to redo");
    assert!(!std::path::Path::new(&volume).exists());
    std::fs::write(&edits, "{\"edit\": \"remove\", \"node\": 3}\n").expect("a file");
    fails(&run, 1, "edits.jsonl:1: column 28: node: invalid type");
    let ball = r#"{"edit": "insert", "entry": {"shape": {"type": "sphere", "radiusx": 0.1}}}"#;
    std::fs::write(&edits, format!("\n{ball}\n")).expect("a file");
    fails(
        &run,
        1,
        "edits.jsonl:2: column 58: entry.shape.radiusx: unknown field `radiusx`, expected `radius`; did you mean `radius`?",
    );
    std::fs::write(&edits, [0xff, 0xfe, b'\n']).expect("a file");
    fails(&run, 1, "edits.jsonl:1");
    if cfg!(unix) {
        let run = [
            "edit",
            &teapot,
            "--edits",
            "/dev/zero",
            "--resolution",
            "16",
        ];
        fails(&run, 1, "/dev/zero:1: this line is longer");
    }
    let gone = place("gone.jsonl");
    fails(&["edit", &teapot, "--edits", &gone], 1, "gone.jsonl");
    let dense = ["--via", "dense", "--check", "--device", "cpu"];
    std::fs::write(&edits, "").expect("a file");
    let run = ["edit", &teapot, "--edits", &edits, "--resolution", "16"];
    fails(
        &[&run[..], &dense].concat(),
        1,
        "--check compares sparse bricks",
    );
}

/// Copies that are all in one place are named with their brush.
#[test]
fn copies_in_one_place_are_warned_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().join("ring.json").display().to_string();
    let said = |by: f32| {
        let text = format!(
            r#"{{"argil": 1, "brushes": [{{"name": "ring", "shape": {{"type": "sphere", "radius": 0.5}},
            "modifiers": [{{"type": "translate", "by": [{by}, 0, 0]}}, {{"type": "radial_repeat", "count": 6}}]}}]}}"#
        );
        std::fs::write(&place, text).expect("a file");
        let output = argil(&["info", &place]);
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let warned = said(0.0);
    let expected = "ring.json: brushes[0].modifiers[1] (\"ring\"): all copies are in one place";
    assert!(warned.contains(expected), "{warned}");
    assert_eq!(said(2.0), "");
}

/// Renaming meshes is not an edit of the solid, and is saved anyway.
#[test]
fn renamed_meshes_are_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let renamed = r#"{"edit":"rename_meshes","paths":{"suzanne.obj":"monkey.obj"}}"#;
    std::fs::write(place("edits.jsonl"), renamed).expect("a file");
    let (suzanne, edits, out) = (scene("suzanne"), place("edits.jsonl"), place("out.argil"));
    let run = ["edit", &suzanne, "--edits", &edits, "--resolution", "32"];
    let rest = ["-o", &out, "--device", "cpu"];
    let output = argil(&[&run[..], &rest].concat());
    assert!(output.status.success(), "{output:?}");
    let bytes = std::fs::read(&out).expect("a volume");
    let has = |text: &str| {
        bytes
            .windows(text.len())
            .any(|window| window == text.as_bytes())
    };
    assert!(has("monkey.obj") && !has("suzanne.obj"));
}
