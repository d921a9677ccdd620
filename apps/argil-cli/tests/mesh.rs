//! Tests triangles by the command: exports from scenes and volumes, and imports.
//!
//! *Length.* A test for each way to export or import triangles, with the files that they share.

use crate::common::{argil, fails, json, scene};
use argil::mesh::{MeshFormat, MeshReport};
use std::path::Path;

fn read(path: &str) -> argil::mesh::Mesh {
    argil::mesh::read(Path::new(path))
        .expect("a mesh file")
        .mesh
}

/// Lists of formats in help and documents follow the table.
#[test]
fn lists_of_formats_are_complete() {
    let help = |command| String::from_utf8_lossy(&argil(&[command, "--help"]).stdout).into_owned();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = |path: &str| std::fs::read_to_string(root.join(path)).expect("a page");
    let python = "bindings/python/python/argil/";
    let pages = [
        help("mesh"),
        help("import"),
        page("README.md"),
        page("crates/argil/src/meshing.rs"),
        page("bindings/python/README.md"),
        page(&format!("{python}_load.py")),
        page(&format!("{python}_mesh.py")),
        page(&format!("{python}_output.py")),
        page(&format!("{python}_sdf3.py")),
    ];
    for (index, text) in pages.iter().enumerate() {
        for format in MeshFormat::all() {
            let is_listed = text.contains(&format!(".{}", format.extension()));
            assert!(is_listed, "{format:?} in page {index}");
        }
    }
}

#[test]
fn every_format_comes_back_closed() {
    let folder = tempfile::tempdir().expect("a folder");
    for ending in ["glb", "gltf", "obj", "ply", "stl"] {
        let file = folder
            .path()
            .join(format!("out.{ending}"))
            .display()
            .to_string();
        let report = json(&argil(&[
            "mesh",
            &scene("csg20"),
            "--resolution",
            "64",
            "-o",
            &file,
            "--json",
        ]));
        assert_eq!(report["watertight"], true, "{report}");
        assert_eq!(report["non_manifold_edges"], 0);
        assert!(
            report["off_voxels"]["rms"].as_f64() < Some(0.02)
                && report["surface_error_voxels"]["rms"].as_f64() < Some(0.02),
            "{report}"
        );
        let counted = MeshReport::of(&read(&file).welded());
        assert!(counted.is_watertight(), "{ending} {counted:?}");
        assert_eq!(report["triangles"], counted.triangles, "{ending}");
        assert_eq!(report["euler"], counted.euler_characteristic, "{ending}");
        let info = json(&argil(&["info", &file, "--json"]));
        assert_eq!(info["watertight"], true);
    }
}

#[test]
fn the_ways_to_a_mesh_agree() {
    let folder = tempfile::tempdir().expect("a folder");
    let volume = folder.path().join("v.argil").display().to_string();
    let csg20 = scene("csg20");
    json(&argil(&[
        "bake",
        &csg20,
        "--via",
        "bricks",
        "--resolution",
        "96",
        "-o",
        &volume,
        "--json",
    ]));
    let ways: [&[&str]; 7] = [
        &[&csg20, "--resolution", "96"],
        &[&csg20, "--resolution", "96", "--via", "bricks"],
        &[
            &csg20,
            "--resolution",
            "96",
            "--via",
            "bricks",
            "--device",
            "gpu",
        ],
        &[
            &csg20,
            "--resolution",
            "96",
            "--via",
            "dense",
            "--bits",
            "16",
            "--normals",
            "gradient",
        ],
        &[&volume],
        &[&csg20, "--resolution", "96", "--method", "dc"],
        &[&csg20, "--resolution", "96", "--iso", "0.0001"],
    ];
    let mut volumes = Vec::new();
    for way in ways {
        let report = json(&argil(&[&["mesh"], way, &["--json"]].concat()));
        assert_eq!(report["watertight"], true, "{way:?} {report}");
        assert_eq!(report["euler"], -24, "{way:?} {report}");
        volumes.push(report["enclosed_volume"].as_f64().expect("a number"));
    }
    for volume in &volumes {
        assert!((volume / volumes[0] - 1.0).abs() < 0.01, "{volumes:?}");
    }
    // A larger iso level is a larger solid.
    let at = |iso: &str| {
        let run = ["mesh", &csg20, "--resolution", "64", "--json", "--iso", iso];
        json(&argil(&run))["enclosed_volume"].as_f64()
    };
    assert!(at("0.05") > at("0.02") && at("0.02") > at("-0.02"));
    // Voxels of a size.
    let run = ["mesh", &csg20, "--voxel", "0.02", "--json"];
    let report = json(&argil(&run));
    assert!((report["voxel"].as_f64().expect("a number") - 0.02).abs() < 1e-6);
    assert_eq!(report["watertight"], true, "{report}");
    // The study's triangles share no corners.
    let run = [
        "mesh",
        &csg20,
        "--resolution",
        "64",
        "--normals",
        "face",
        "--json",
    ];
    let report = json(&argil(&run));
    assert_eq!(
        report["vertices"].as_u64(),
        report["triangles"].as_u64().map(|n| 3 * n)
    );
}

#[test]
fn fewer_triangles_and_levels_of_detail() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("out.obj").display().to_string();
    let run = ["mesh", &scene("props"), "--resolution", "128", "--json"];
    let report = json(&argil(
        &[
            &run[..],
            &["--triangles", "9000", "-o", &file, "--lods", "3"],
        ]
        .concat(),
    ));
    assert!(report["triangles"].as_u64() <= Some(9000));
    assert!(report["simplification_error"].as_f64() > Some(0.0));
    // Scripts of earlier versions read this key.
    assert_eq!(report["simplified_by"], report["simplification_error"]);
    let lods = report["lods"].as_array().expect("a list");
    assert_eq!(lods.len(), 3);
    let mut before = report["triangles"].as_u64();
    for lod in lods {
        assert_eq!(lod["open_edges"], 0, "{lod}");
        assert!(lod["triangles"].as_u64() < before);
        before = lod["triangles"].as_u64();
        let level = read(lod["mesh"].as_str().expect("a path"));
        assert_eq!(Some(level.triangles.len() as u64), before);
    }
}

/// Levels of detail end when no triangle is left, or none can be removed.
#[test]
fn levels_of_detail_end_where_nothing_would_be_left() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("o.glb").display().to_string();
    let flags = ["--resolution", "48", "--lods", "7", "-o", &file, "--json"];
    let report = json(&argil(&[&["mesh", &scene("csg20")], &flags[..]].concat()));
    let lods = report["lods"].as_array().expect("a list");
    assert!((3..8).contains(&lods.len()), "{report}");
    assert!(lods.iter().all(|lod| lod["triangles"].as_u64() > Some(0)));
}

#[test]
#[expect(
    clippy::too_many_lines,
    reason = "one story, from a mesh to a picture of it"
)]
fn meshes_become_scenes() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let suzanne = format!("{}/../../scenes/suzanne.obj", env!("CARGO_MANIFEST_DIR"));
    std::fs::copy(suzanne, place("suzanne.obj")).expect("a copy");
    let report = json(&argil(&[
        "import",
        &place("suzanne.obj"),
        "-o",
        &place("s.json"),
        "--resolution",
        "48",
        "--json",
    ]));
    // The eyes are open, and so is where they lie.
    assert_eq!(report["holes_closed"], 4, "{report}");
    assert_eq!(report["mesh"], "suzanne.obj");
    let text = std::fs::read_to_string(place("s.json")).expect("a scene");
    assert!(
        text.contains("\"suzanne.obj\"") && !text.contains(&place("")),
        "{text}"
    );

    let mut hits = Vec::new();
    for more in [
        &["--device", "cpu"][..],
        &["--device", "gpu"],
        &["--via", "bricks", "--resolution", "96"],
    ] {
        let run = [
            "render",
            &place("s.json"),
            "-o",
            &place("p.png"),
            "--size",
            "96x72",
            "--show",
            "normal",
            // A ray that grazes the surface takes more than usual on a GPU, which does not prune.
            "--max-steps",
            "512",
            "--json",
        ];
        hits.push(
            json(&argil(&[&run[..], more].concat()))["hit_pixels"]
                .as_f64()
                .expect("a number"),
        );
    }
    // At so few pixels the bricks' half voxel tells.
    assert!(
        hits[0] > 500.0 && hits[0] == hits[1] && (hits[2] / hits[0] - 1.0).abs() < 0.15,
        "{hits:?}"
    );

    // A volume elsewhere names the mesh by the way from there, and needs no file of it to be drawn; its scene does.
    std::fs::create_dir(place("elsewhere")).expect("a folder");
    let volume = place("elsewhere/v.argil");
    let bake = [
        "bake",
        &place("s.json"),
        "--via",
        "bricks",
        "--resolution",
        "48",
        "-o",
        &volume,
    ];
    json(&argil(&[&bake[..], &["--json"]].concat()));
    let run = [
        "render",
        &volume,
        "-o",
        &place("p.png"),
        "--size",
        "96x72",
        "--json",
    ];
    json(&argil(&run));
    json(&argil(&[&run[..], &["--allow-external-meshes"]].concat()));

    // It is a solid: its mesh is closed.
    let report = json(&argil(&[
        "mesh",
        &place("s.json"),
        "--resolution",
        "96",
        "-o",
        &place("back.stl"),
        "--json",
    ]));
    assert_eq!(report["watertight"], true, "{report}");
    assert!(MeshFormat::from_path(Path::new(&place("back.stl"))).is_some());

    // A scene elsewhere names it by a path that leads out.
    std::fs::create_dir(place("sub")).expect("a folder");
    let out = place("sub/s.json");
    fails(
        &["import", &place("suzanne.obj"), "-o", &out],
        1,
        "--allow-external-meshes",
    );
    json(&argil(&[
        "import",
        &place("suzanne.obj"),
        "-o",
        &out,
        "--allow-external-meshes",
        "--resolution",
        "32",
        "--json",
    ]));
    fails(&["info", &out], 1, "../suzanne.obj");
    json(&argil(&["info", &out, "--allow-external-meshes", "--json"]));
}

/// An output never overwrites the scene's own files or a folder.
#[test]
fn a_scenes_own_meshes_are_spared() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    std::fs::copy(scene("suzanne").replace(".json", ".obj"), place("own.obj")).expect("a file");
    std::fs::copy(place("own.obj"), place("more-1.obj")).expect("a file");
    let text = r#"{"argil": 1, "brushes": [
        {"shape": {"type": "mesh", "path": "own.obj", "resolution": 16}},
        {"shape": {"type": "mesh", "path": "more-1.obj", "resolution": 16}}]}"#;
    std::fs::write(place("s.json"), text).expect("a file");
    let before = std::fs::read(place("own.obj")).expect("a file");
    let run = |more: &[&str]| {
        let path = place("s.json");
        let all = [&["mesh", &path, "--resolution", "16"][..], more].concat();
        fails(&all, 1, "input");
    };
    run(&["-o", &place("own.obj")]);
    run(&["-o", &place("more.obj"), "--lods", "2"]);
    fails(
        &["bake", &place("s.json"), "-o", &place("own.obj")],
        1,
        "name it .argil",
    );
    assert_eq!(std::fs::read(place("own.obj")).expect("a file"), before);
    assert!(!Path::new(&place("more.obj")).exists());
    std::fs::create_dir(place("lod-1.glb")).expect("a folder");
    let path = place("s.json");
    let lods = ["mesh", &path, "-o", &place("lod.glb"), "--lods", "1"];
    fails(&lods, 1, "is a folder");
    assert!(!Path::new(&place("lod.glb")).exists());
}

#[test]
fn a_mesh_is_drawn_on_both_devices() {
    let folder = tempfile::tempdir().expect("a folder");
    let png = folder.path().join("p.png").display().to_string();
    let csg20 = scene("csg20");
    let run = [
        "render", &csg20, "-o", &png, "--size", "96x72", "--show", "normal", "--json",
    ];
    let hits = |more: &[&str]| json(&argil(&[&run[..], more].concat()))["hit_pixels"].as_f64();
    let field = hits(&["--device", "cpu"]).expect("a number");
    for more in [
        &["--via", "mesh", "--resolution", "128"][..],
        &["--via", "mesh", "--resolution", "128", "--device", "gpu"],
        &[
            "--via",
            "mesh",
            "--resolution",
            "128",
            "--method",
            "dc",
            "--flat",
        ],
    ] {
        let count = hits(more).expect("a number");
        assert!(
            (count / field - 1.0).abs() < 0.01,
            "{count} and {field}: {more:?}"
        );
    }
    let bits = ["render", &csg20, "-o", &png, "--via", "mesh", "--bits", "8"];
    fails(&bits, 1, "--bits has no effect");
    fails(
        &["render", &csg20, "-o", &png, "--via", "bricks", "--flat"],
        1,
        "--flat has no effect",
    );
    fails(&["bake", &csg20, "--via", "mesh"], 1, "argil mesh");
    fails(&["mesh", &csg20, "--via", "mesh"], 1, "--normals face");
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of requests")]
fn impossible_requests_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let csg20 = scene("csg20");
    fails(
        &["mesh", &csg20, "-o", &place("x.fbx")],
        1,
        &MeshFormat::extensions("or"),
    );
    fails(
        &["mesh", &csg20, "-o", &place("x.glb"), "--axes", "z-up"],
        1,
        "omit them",
    );
    fails(&["mesh", &csg20, "--axes", "z-up"], 1, "add -o");
    fails(&["mesh", &csg20, "--via", "octree"], 1, "octree");
    fails(
        &[
            "mesh",
            &csg20,
            "--via",
            "bricks",
            "--iso",
            "0.1",
            "--resolution",
            "64",
        ],
        1,
        "iso",
    );
    fails(&["mesh", &csg20, "--iso", "nan"], 1, "iso");
    fails(
        &[
            "mesh",
            &csg20,
            "--via",
            "dense",
            "--iso",
            "5",
            "--resolution",
            "64",
        ],
        1,
        "band",
    );
    fails(
        &["mesh", &csg20, "--method", "dc", "--via", "dense"],
        1,
        "--method has no effect",
    );
    fails(
        &[
            "mesh",
            &csg20,
            "--iso",
            "-5",
            "--resolution",
            "32",
            "-o",
            &place("x.obj"),
        ],
        1,
        "no surface",
    );
    fails(&["mesh", &csg20, "--lods", "2"], 2, "--output");
    fails(
        &["mesh", &csg20, "--voxel", "0.1", "--resolution", "64"],
        2,
        "--voxel-size",
    );
    fails(&["mesh", &csg20, "--voxel", "0"], 2, "above 0");
    fails(&["mesh", &csg20, "--voxel", "1e-9"], 1, "4096");
    fails(
        &["mesh", &csg20, "--voxel", "0.1", "--via", "dense"],
        1,
        "--voxel-size",
    );
    fails(&["mesh", &csg20, "--resolution", "100000"], 1, "4096");
    assert!(!Path::new(&place("x.obj")).exists());

    for (name, content, message) in [
        ("empty.obj", "", "no triangle"),
        (
            "nan.obj",
            "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            "no triangle",
        ),
        (
            "flat.obj",
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
            "no triangle",
        ),
        (
            "beyond.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n",
            "not a valid",
        ),
        ("cut.glb", "glTF", "not a valid"),
        (
            "cut.ply",
            "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n",
            "not a valid",
        ),
        ("cut.stl", "solid\nfacet", "not a valid"),
    ] {
        std::fs::write(place(name), content).expect("a file");
        fails(
            &["import", &place(name), "-o", &place("x.json")],
            1,
            message,
        );
        assert!(!Path::new(&place("x.json")).exists());
    }
    let sheet = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    std::fs::write(place("sheet.obj"), sheet).expect("a file");
    let made = ["import", &place("sheet.obj"), "-o", &place("x.json")];
    fails(&made, 1, "enclose no volume");
    fails(&["info", &place("empty.obj")], 1, "no triangle");
    fails(&["mesh", &place("sheet.obj")], 1, "argil import");
    fails(
        &["import", &place("none.obj"), "-o", &place("x.json")],
        1,
        "none.obj",
    );
    let missing = r#"{"argil": 1, "brushes": [{"shape": {"type": "mesh", "path": "gone.obj"}}]}"#;
    std::fs::write(place("missing.json"), missing).expect("a file");
    fails(
        &["render", &place("missing.json"), "-o", &place("x.png")],
        1,
        "gone.obj",
    );
    let absolute =
        r#"{"argil": 1, "brushes": [{"shape": {"type": "mesh", "path": "/etc/hostname.obj"}}]}"#;
    std::fs::write(place("absolute.json"), absolute).expect("a file");
    fails(
        &["render", &place("absolute.json"), "-o", &place("x.png")],
        1,
        "--allow-external-meshes",
    );
    let coarse = r#"{"argil": 1, "brushes": [{"shape": {"type": "mesh", "path": "a.obj", "resolution": 9}}]}"#;
    std::fs::write(place("coarse.json"), coarse).expect("a file");
    fails(&["info", &place("coarse.json")], 1, "from 16 to 512");
}
