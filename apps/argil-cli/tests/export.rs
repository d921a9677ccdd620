//! Tests files for and of other programs by the command.

use crate::common::{argil, fails, json, scene};

#[test]
fn volumes_for_other_programs_are_written_and_imported() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let csg = scene("csg20");
    let hits = |file: &str| {
        let png = place("x.png");
        let flags = ["--size", "96x64", "--show", "normal", "--json", "-o", &png];
        let camera = ["--camera", "30,20,2.5", "--device", "cpu"];
        let report = json(&argil(&[&["render", file][..], &flags, &camera].concat()));
        report["hit_pixels"].as_u64().expect("a number")
    };
    for (name, flags) in [
        (
            "a.vdb",
            &["--colors", "--codec", "blosc", "--bits", "16"][..],
        ),
        ("b.vdb", &["--class", "fog", "--codec", "zip"]),
        (
            "c.vdb",
            &["--keep-bounds", "--band", "5", "--voxel-size", "0.03"],
        ),
        ("d.nvdb", &["--bits", "8"]),
        ("e.nrrd", &[]),
        ("f.npy", &[]),
    ] {
        let file = place(name);
        let size = if flags.contains(&"--voxel-size") {
            &[][..]
        } else {
            &["--resolution", "64"]
        };
        let bake = [&["bake", &csg, "--json", "-o", &file][..], flags, size].concat();
        let report = json(&argil(&bake));
        assert_eq!(report["volume"], file);
        assert!(report["voxels"].as_u64() > Some(10_000), "{report}");
        assert!(report["export_ms"].as_f64() > Some(0.0));
        assert_eq!(
            report["file_bytes"],
            std::fs::metadata(&file).expect("a file").len()
        );
        let back = place("back.json");
        let about = json(&argil(&["import", &file, "-o", &back, "--json"]));
        assert_eq!(
            about["class"],
            if name == "b.vdb" { "fog" } else { "level-set" }
        );
        assert_eq!(about["brushes"], 1);
        assert!(hits(&back) > 300, "{name}: {}", hits(&back));
    }
    // A scene can name such a file itself.
    let text = r#"{"argil": 1, "brushes": [{"shape": {"type": "mesh", "path": "a.vdb"}}]}"#;
    std::fs::write(place("named.json"), text).expect("a file");
    assert!(hits(&place("named.json")) > 300);
    // Raw samples say how they are read.
    let raw = place("g.raw");
    let report = json(&argil(&[
        "bake",
        &csg,
        "--resolution",
        "64",
        "-o",
        &raw,
        "--json",
    ]));
    let shape: Vec<String> = report["resolution"]
        .as_array()
        .expect("numbers")
        .iter()
        .map(ToString::to_string)
        .collect();
    let back = place("raw.json");
    fails(&["import", &raw, "-o", &back], 1, "--shape X,Y,Z");
    argil(&["import", &raw, "-o", &back, "--shape", &shape.join(",")]);
    assert!(hits(&back) > 300);
    assert!(std::fs::exists(place("g.raw.json")).expect("a folder"));
}

#[test]
fn meshes_for_slicers_are_written_and_imported() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let (csg, file) = (scene("csg20"), place("a.3mf"));
    let mesh = [
        "mesh",
        &csg,
        "--resolution",
        "48",
        "--unit",
        "mm",
        "-o",
        &file,
        "--json",
    ];
    let report = json(&argil(&mesh));
    let about = json(&argil(&["info", &file, "--json"]));
    assert_eq!(about["triangles"], report["triangles"]);
    assert_eq!(about["watertight"], true);
    let near = |a: &serde_json::Value, b: &serde_json::Value| {
        let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
        (a / b - 1.0).abs() < 1e-4
    };
    assert!(
        near(&about["enclosed_volume"], &report["enclosed_volume"]),
        "{about} {report}"
    );
    fails(&["mesh", &csg, "--axes", "y-up", "-o", &file], 1, "--axes");
    let back = place("back.json");
    assert_eq!(
        json(&argil(&["import", &file, "-o", &back, "--json"]))["brushes"],
        1
    );
}

#[test]
fn flags_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let csg = scene("csg20");
    let (vdb, npy, argil_file) = (place("a.vdb"), place("a.npy"), place("a.argil"));
    let bake = |file: &str, flags: &[&str], code: i32, text: &str| {
        fails(
            &[&["bake", &csg, "-o", file][..], flags].concat(),
            code,
            text,
        );
        assert!(!std::fs::exists(file).expect("a folder"), "{file}");
    };
    bake(&vdb, &["--via", "dense"], 1, "--via");
    bake(&vdb, &["--repeat", "3"], 1, "--repeat");
    bake(&vdb, &["--bits", "8"], 1, "8 bits");
    bake(&vdb, &["--band", "0.1"], 1, "band of 0.1 voxels");
    bake(&vdb, &["--resolution", "1000000"], 1, "resolution");
    bake(&npy, &["--colors"], 1, "colors");
    bake(&argil_file, &["--class", "fog"], 1, "--class");
    bake(&place("a.glb"), &[], 1, "not a .glb file");
    if !cfg!(feature = "zarr") {
        bake(&place("a.zarr"), &[], 1, "--features zarr");
    }
    let obj = scene("suzanne").replace(".json", ".obj");
    let back = place("back.json");
    fails(
        &["import", &obj, "-o", &back, "--grid", "x"],
        1,
        "--grid applies to volumes",
    );
    std::fs::write(&vdb, b"garbage").expect("a file");
    fails(&["import", &vdb, "-o", &back], 1, "not a VDB file");
    fails(
        &["import", &vdb, "-o", &back, "--resolution", "64"],
        1,
        "--resolution applies to meshes",
    );
    fails(&["import", &place("gone.vdb"), "-o", &back], 1, "gone.vdb");
    assert!(!std::fs::exists(&back).expect("a folder"));
}

/// What a file holds, and what of it is not read.
#[test]
fn volumes_of_other_programs_are_described() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    for (name, flags) in [
        ("a.vdb", &["--colors"][..]),
        ("b.nvdb", &[]),
        ("c.nrrd", &[]),
        ("d.npy", &[]),
    ] {
        let (csg, file) = (scene("csg20"), place(name));
        argil(
            &[
                &["bake", &csg, "--resolution", "32", "-o", &file][..],
                flags,
            ]
            .concat(),
        );
        let about = json(&argil(&["info", &file, "--json"]));
        assert!(about["voxels"].as_u64() > Some(1000), "{name}: {about}");
        fails(&["render", &file], 1, "argil import");
    }
    let about = json(&argil(&["info", &place("a.vdb"), "--json"]));
    assert_eq!(about["class"], "level-set");
    assert_eq!(about["other_grids"], serde_json::json!(["Cd"]));
    let import = argil(&["import", &place("a.vdb"), "-o", &place("back.json")]);
    assert!(String::from_utf8_lossy(&import.stderr).contains("not Cd"));
}
