//! Tests volumes by the command: bake, render, describe, and every wrong request.

use crate::common::{argil, fails, json, scene};

/// Bakes on one device and renders on each. The image equals that of a volume built on the spot.
#[test]
fn volumes_are_baked_described_and_drawn_on_both_devices() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let teapot = scene("teapot");
    for (via, more, levels) in [
        ("dense", &["--mips", "--resolution", "60"][..], 4),
        ("octree", &["--brick", "8", "--resolution", "60"][..], 0),
        ("bricks", &["--brick", "4", "--resolution", "60"][..], 0),
    ] {
        let mut pixels = Vec::new();
        for device in ["cpu", "gpu"] {
            let volume = place(&format!("{via}-{device}.argil"));
            let bake = ["bake", &teapot, "--via", via, "--device", device, "--json"];
            let bake = [&bake[..], &["-o", &volume, "--repeat", "2"], more].concat();
            let report = json(&argil(&bake));
            assert_eq!(report["via"], via);
            assert_eq!(report["resolution"][0], 60);
            assert_eq!(report["builds_ms"].as_array().map(Vec::len), Some(2));
            assert!(report["build_ms"].as_f64() > Some(0.0));
            assert!(report["stages_ms"]["fill"].as_f64() > Some(0.0));
            assert!(report["memory_bytes"].as_u64() > Some(60 * 30 * 30));
            assert!(
                report["device"]
                    .as_str()
                    .is_some_and(|d| d.starts_with(device))
            );
            if via == "octree" {
                assert!(report["bricks"].as_u64() > Some(50));
                assert!(report["nodes"].as_u64() > Some(10));
                assert!(report["stages_ms"]["select"].as_f64() >= Some(0.0));
            } else if via == "bricks" {
                assert!(report["bricks"].as_u64() > Some(200));
                assert_eq!(report["bits"], 16);
            } else {
                assert_eq!(report["levels"], levels);
            }

            let about = json(&argil(&["info", &volume, "--json"]));
            assert_eq!(about["via"], via);
            assert_eq!(about["scene"], "Teapot");
            assert_eq!(about["resolution"], report["resolution"]);

            for device in ["cpu", "gpu"] {
                let png = place("x.png");
                let size = ["--size", "96x64", "--show", "normal", "--json"];
                let stored = ["render", &volume, "-o", &png, "--device", device];
                let stored = json(&argil(&[&stored[..], &size].concat()));
                assert_eq!(stored["via"], via);
                assert_eq!(stored["resolution"], report["resolution"]);
                let built = [
                    "render", &teapot, "-o", &png, "--device", device, "--via", via,
                ];
                let built = json(&argil(&[&built[..], &size, more].concat()));
                for report in [&stored, &built] {
                    pixels.push(report["hit_pixels"].as_u64().expect("a number"));
                    let mean = |key: &str| report[key]["mean"].as_f64().expect("a number");
                    let sum = mean("samples") + mean("descents") + mean("cells");
                    assert!((sum - mean("steps")).abs() < 1e-9);
                    assert_eq!(report["fetches"], report["steps"]);
                    assert_eq!(mean("descents") > 0.0, via == "octree");
                }
                assert_eq!(built["resolution"], report["resolution"]);
            }
        }
        let (least, most) = (pixels.iter().min(), pixels.iter().max());
        assert!(
            most.zip(least).is_some_and(|(m, l)| m - l <= 3 && *l > 300),
            "{pixels:?}"
        );
    }
}

#[test]
fn a_volume_can_be_rebaked_and_shown_as_bricks() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let (first, second) = (place("first.argil"), place("second.argil"));
    let small = ["--resolution", "40", "--device", "cpu"];
    let bake = ["bake", &scene("edgy-cube"), "-o", &first];
    assert!(argil(&[&bake[..], &small].concat()).status.success());
    // From the volume's own scene, with another structure.
    let bake = [
        "bake", &first, "-o", &second, "--via", "octree", "--brick", "8",
    ];
    let more = ["--keep", "center", "--count-lost", "--json"];
    let report = json(&argil(&[&bake[..], &small, &more].concat()));
    assert!(report["lost_bricks"].as_u64() > Some(0));
    for show in ["bricks", "nodes"] {
        let png = place("bricks.png");
        let draw = [
            "render", &second, "-o", &png, "--show", show, "--size", "64x48",
        ];
        let more = ["--device", "cpu", "--descent", "path", "--json"];
        let report = json(&argil(&[&draw[..], &more].concat()));
        assert!(report["hit_pixels"].as_u64() > Some(100));
        let colors: std::collections::HashSet<_> = image::open(&png)
            .expect("a PNG")
            .to_rgb8()
            .pixels()
            .copied()
            .collect();
        assert!(colors.len() > 8, "{show}: {}", colors.len());
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of requests")]
fn senseless_requests_name_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let brick = scene("brick");
    let cpu = ["--device", "cpu"];
    let bake = |more: &[&str], code, message| {
        fails(&[&["bake", &brick][..], &cpu, more].concat(), code, message);
    };
    bake(&["--via", "field"], 1, "use dense, octree or bricks");
    bake(&["--resolution", "0"], 2, "0 is not in");
    bake(&["--resolution", "7"], 1, "8 to 4096");
    bake(&["--resolution", "100000"], 1, "8 to 4096");
    bake(&["--resolution", "-1"], 2, "-1 is not in");
    bake(&["--bits", "12"], 2, "8 or 16");
    bake(&["--band", "NaN"], 2, "above 0");
    bake(&["--band", "1e9"], 1, "0.5 to 4096 voxels");
    bake(&["--stride", "33"], 2, "1..=32");
    bake(&["--stride", "4", "--band", "4"], 2, "cannot be used with");
    bake(
        &["--via", "dense", "--brick", "8"],
        1,
        "--brick has no effect with --via dense",
    );
    bake(&["--via", "octree", "--mips"], 1, "--mips has no effect");
    bake(&["--via", "octree", "--brick", "7"], 2, "8, 16 or 32");
    bake(&["--via", "levels"], 1, "use `argil render`");
    bake(&["--via", "octree", "--depth", "2"], 1, "use 3 levels");
    bake(&["--via", "octree", "--depth", "40"], 1, "the limit is 8");
    bake(
        &["--via", "octree", "--resolution", "4096", "--brick", "8"],
        1,
        "choose larger bricks",
    );
    bake(&["--via", "bricks", "--brick", "32"], 1, "4, 8 or 16");
    bake(&["--via", "bricks", "--mips"], 1, "--mips has no effect");
    let budget = ["--via", "bricks", "--memory-budget", "1"];
    bake(&budget, 1, "--memory-budget");
    bake(
        &["--via", "dense", "--memory-budget", "1"],
        1,
        "has no effect with --via dense",
    );
    bake(&["--fill", "naive"], 1, "add --device gpu");
    bake(&["--via", "octree", "--descent", "path"], 1, "argil render");
    bake(&["-o", "/dev/null"], 1, "not a regular file");
    bake(&["--count-lost"], 1, "add --via octree");
    bake(&["-o", "/nowhere/at/all.argil"], 1, "/nowhere/at");
    bake(&["-o", &brick], 1, "this is the input");
    fails(
        &["render", &brick, "--mips"],
        1,
        "--mips has no effect with --via field",
    );
    let dense = [
        "render",
        &brick,
        "--via",
        "dense",
        "--resolution",
        "16",
        "--show",
        "bricks",
    ];
    fails(
        &[&dense[..], &cpu].concat(),
        1,
        "only octrees have nodes, and only levels have levels (--via bricks, levels or octree)",
    );

    // Files: cut short, damaged, of another kind.
    let volume = place("v.argil");
    let small = ["--resolution", "16", "-o", &volume];
    assert!(
        argil(&[&["bake", &brick][..], &small, &cpu].concat())
            .status
            .success()
    );
    let bytes = std::fs::read(&volume).expect("a volume");
    let cut = place("cut.argil");
    std::fs::write(&cut, &bytes[..bytes.len() - 100]).expect("a file");
    for command in ["render", "bake", "info"] {
        fails(&[command, &cut], 1, "section TEX0 (texels) ends at byte");
    }
    let mut damaged = bytes.clone();
    // Within the description: what is between sections is nobody's.
    damaged[330] ^= 1;
    std::fs::write(&cut, &damaged).expect("a file");
    fails(&["info", &cut], 1, "checksum differs");
    let mut newer = bytes.clone();
    newer[8] = 9;
    std::fs::write(&cut, &newer).expect("a file");
    fails(&["info", &cut], 1, "update argil");
    std::fs::write(&cut, &bytes[..5]).expect("a file");
    fails(&["render", &cut], 1, "not a volume file");
    let enumerated = [
        "bake",
        &brick,
        "--via",
        "octree",
        "--brick",
        "8",
        "--resolution",
        "512",
    ];
    let enumerated = [
        &enumerated[..],
        &["--sort", "enumerated", "--device", "gpu"],
    ]
    .concat();
    fails(&enumerated, 1, "choose larger bricks");
    fails(&["render", &volume, "--via", "octree"], 1, "already baked");
    fails(
        &["render", &volume, "--resolution", "32"],
        1,
        "already baked",
    );
    fails(
        &["render", &volume, "--descent", "path"],
        1,
        "is not an octree",
    );
    // Nothing was left behind by what failed.
    let left: Vec<_> = std::fs::read_dir(folder.path())
        .expect("a folder")
        .collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

/// A volume file needs no mesh files: it is rendered, measured, meshed and edited without them.
#[test]
fn a_volume_file_needs_no_other_file() {
    let done = |arguments: &[&str]| {
        let output = argil(arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {errors}");
    };
    let [here, there] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let at =
        |folder: &tempfile::TempDir, name: &str| folder.path().join(name).display().to_string();
    let (solid, imported) = (at(&here, "solid.ply"), at(&here, "solid.json"));
    let meshing = ["mesh", &scene("csg20"), "--resolution", "48", "-o", &solid];
    done(&meshing);
    done(&["import", &solid, "-o", &imported]);
    for via in ["bricks", "dense", "octree"] {
        let volume = at(&here, &format!("{via}.argil"));
        done(&[
            "bake",
            &imported,
            "--via",
            via,
            "--resolution",
            "48",
            "-o",
            &volume,
        ]);
        let alone = at(&there, &format!("{via}.argil"));
        std::fs::copy(&volume, &alone).expect("a copy");
        let pictures = [&volume, &alone].map(|volume| {
            let png = format!("{volume}.png");
            done(&["render", volume, "-o", &png, "--size", "64x48"]);
            std::fs::read(png).expect("a picture")
        });
        assert!(pictures[0] == pictures[1], "{via}");
        let again = at(&there, "again.argil");
        done(&["bake", &alone, "--resolution", "32", "-o", &again]);
        if via == "bricks" {
            done(&["mesh", &alone, "-o", &at(&there, "again.glb")]);
        }
    }
}

/// A file name that announces another format is refused before any work.
#[test]
fn volumes_are_not_named_as_other_files_are() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["v.glb", "v.json", "v.gif"] {
        let place = folder.path().join(name).display().to_string();
        let run = ["bake", &scene("csg20"), "--resolution", "32", "-o", &place];
        fails(&run, 1, "name it .argil");
        assert!(!std::path::Path::new(&place).exists());
    }
}

/// What is not JSON is not said to be damaged JSON.
#[test]
fn unknown_formats_are_named_with_a_way_round() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let scene = place("scene.json");
    for name in ["a.fbx", "a.nhdr", "a.npz", "a.mha", "a"] {
        let file = place(name);
        std::fs::write(&file, b"NRRD0004\ndata file: a.raw\n\0").expect("a file");
        for command in [&["import", &file, "-o", &scene][..], &["info", &file]] {
            fails(command, 1, "unknown format");
            fails(command, 1, ".nrrd (volume)");
        }
    }
}
