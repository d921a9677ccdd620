//! Tests `argil render --integrator path`.

use crate::common::{argil, fails, json, scene};
use std::io::{BufRead, BufReader};

const SMALL: [&str; 6] = ["--integrator", "path", "--size", "48x32", "--via", "bricks"];

/// A still is always the same, with noise removed it is another one, and in an .exr it is not cut at white.
#[test]
fn stills_are_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    let csg = scene("csg20");
    let picture = |name: &str, more: &[&str]| {
        let path = place(name);
        let asked = [&["render", &csg, "-o", &path, "--json"], &SMALL[..], more].concat();
        let found = json(&argil(&asked));
        assert_eq!(found["integrator"], "path");
        (found, std::fs::read(path).expect("a picture"))
    };
    let (found, first) = picture("a.png", &["--samples", "3"]);
    assert_eq!(
        (&found["samples"], &found["interrupted"]),
        (&3.into(), &false.into())
    );
    assert!(found["hit_pixels"].as_u64() > Some(100));
    assert!(picture("b.png", &["--samples", "3", "--threads", "1"]).1 == first);
    assert!(picture("c.png", &["--samples", "3", "--denoise"]).1 != first);
    let in_time = picture("f.png", &["--samples", "3", "--time-limit", "3600"]);
    assert!(in_time.1 == first);
    let (found, _) = picture("d.png", &["--samples", "1000000", "--time-limit", "0.5"]);
    assert!(
        found["samples"]
            .as_u64()
            .is_some_and(|samples| samples < 1_000_000),
        "{found}"
    );
    let (_, exr) = picture("e.exr", &["--samples", "16"]);
    let read = image::load_from_memory(&exr).expect("an EXR").into_rgb32f();
    assert_eq!((read.width(), read.height()), (48, 32));
    assert!(read.iter().any(|&light| light > 1.0) && read.iter().all(|light| *light >= 0.0));
}

/// A long still says how long it will take, and may pass through bricks if it was not told otherwise. Which of both takes less time
/// is up to the machine.
#[test]
fn long_stills_are_announced() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.png").display().to_string();
    let temple = scene("temple");
    let short = ["--samples", "1"];
    // Interrupted in time: nobody waits for all of it.
    let long = ["--samples", "1000000"];
    for (flags, is_long) in [
        (&short[..], false),
        (&[&long[..], &["--via", "field"]].concat(), true),
        (&long, true),
    ] {
        let fixed = ["--integrator", "path", "--size", "48x32", "--json"];
        let asked = [&["render", &temple, "-o", &path], &fixed[..], flags].concat();
        let mut process = std::process::Command::new(env!("CARGO_BIN_EXE_argil"))
            .args(&asked)
            .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("the command starts");
        let mut lines = BufReader::new(process.stderr.take().expect("stderr")).lines();
        let mut said = Vec::new();
        if is_long {
            // The last line before paths begin.
            said.extend(
                lines
                    .by_ref()
                    .map_while(Result::ok)
                    .find(|line| line.contains("48x32 pixels take about")),
            );
            process.kill().expect("a process");
        }
        let output = process.wait_with_output().expect("an end");
        assert_eq!(said.len(), usize::from(is_long), "{flags:?}");
        if !is_long {
            assert_eq!(json(&output)["via"], "field");
            let mut said = lines.map_while(Result::ok);
            assert!(!said.any(|line| line.contains("take about")));
        }
    }
}

#[test]
fn flags_that_mean_nothing_are_refused() {
    let csg = scene("csg20");
    for flags in [
        &["--denoise"][..],
        &["--time-limit", "5"],
        &["--firefly-clamp", "3"],
        &["--samples", "65"],
        &["--integrator", "path", "--frames", "3"],
        &["--integrator", "path", "--show", "normal"],
        &["--integrator", "path", "--via", "octree"],
        &["--integrator", "path", "--via", "octree", "--device", "gpu"],
    ] {
        let asked = [&["render", &csg, "-o", "/nowhere/x.png"], flags].concat();
        fails(&asked, 1, "");
    }
    for flags in [
        &["--samples", "0"][..],
        &["--samples", "1048577"],
        &["--firefly-clamp", "-1"],
        &["--firefly-clamp", "nan"],
        &["--time-limit", "inf"],
        &["--integrator", "magic"],
    ] {
        fails(&[&["render", &csg], flags].concat(), 2, "");
    }
}

/// Whoever interrupts a still gets what is there.
#[cfg(unix)]
#[test]
fn interrupted_stills_are_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.png");
    let csg = scene("csg20");
    let mut asked = std::process::Command::new(env!("CARGO_BIN_EXE_argil"));
    asked.args(["render", &csg, "--json", "--samples", "1000000", "-o"]);
    let process = asked
        .arg(&path)
        .args(SMALL)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("the command starts");
    std::thread::sleep(std::time::Duration::from_secs(3));
    let id = process.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(sent.expect("a signal").success());
    let found = json(&process.wait_with_output().expect("an end"));
    assert_eq!(found["interrupted"], true);
    assert!(found["samples"].as_u64() > Some(0) && path.is_file());
}

/// The scenes of the gallery are read, and their images are found beside them. What is behind a transparent still is left out.
#[test]
fn the_gallery_is_rendered() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["textures", "glass", "fog", "lights"] {
        let path = folder.path().join(format!("{name}.png"));
        let path = path.display().to_string();
        let gallery_scene = scene(&format!("gallery/{name}"));
        let size = [
            "--integrator",
            "path",
            "--size",
            "24x15",
            "--samples",
            "1",
            "--transparent",
        ];
        argil(&[&["render", &gallery_scene, "-o", &path], &size[..]].concat());
        let picture = image::open(&path).expect("a picture").into_rgba8();
        let alpha = |index: fn(u8) -> bool| picture.pixels().any(|pixel| index(pixel.0[3]));
        assert!(alpha(|a| a == 255), "{name}");
        assert!(alpha(|a| a == 0), "{name}");
    }
}

/// Bad images and lights are refused with the place and the remedy.
#[test]
#[expect(clippy::too_many_lines, reason = "a table of mistakes")]
fn bad_images_and_lights_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path().join(name), bytes).expect("a file");
    };
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(8, 8, image::Rgb([200, 10, 10]))
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("a PNG");
    let png = png.into_inner();
    write("cut.png", &png[..png.len() / 2]);
    write("text.jpg", b"no image");
    write("empty.hdr", b"");
    let mut exr = std::io::Cursor::new(Vec::new());
    let mut light = image::Rgb32FImage::from_pixel(4, 2, image::Rgb([1.0; 3]));
    light.put_pixel(3, 1, image::Rgb([1.0, f32::NAN, 0.0]));
    light
        .write_to(&mut exr, image::ImageFormat::OpenExr)
        .expect("an EXR");
    write("nan.exr", &exr.into_inner());
    let lights = |count: usize, light: &str| {
        format!(
            r#""view": {{"lights": [{}]}},"#,
            vec![light; count].join(",")
        )
    };
    let around = |path: &str| {
        format!(r#""view": {{"environment": {{"type": "image", "path": "{path}"}}}},"#)
    };
    let texture =
        |json: &str| format!(r#""materials": {{"a": {{"textures": {{"base_color": {json}}}}}}},"#);
    let image = |path: &str| {
        texture(&format!(
            r#"{{"pattern": {{"type": "image", "path": "{path}"}}}}"#
        ))
    };
    let sun = |irradiance: &str| {
        lights(
            1,
            &format!(
                r#"{{"type": "sun", "direction_degrees": [0, 0], "irradiance": {irradiance}}}"#
            ),
        )
    };
    let point = r#"{"type": "point", "at": [0, 1, 0], "intensity": [1, 1, 1]}"#;
    for (what, expected) in [
        (lights(10_000, point), "256"),
        (sun("[1e30, 1, 1]"), "irradiance[0]"),
        (sun("[-1, 1, 1]"), "irradiance[0]"),
        (
            lights(
                1,
                r#"{"type": "spot", "at": [1, 1, 1], "target": [1, 1, 1], "intensity": [1, 1, 1]}"#,
            ),
            "target",
        ),
        (
            lights(
                1,
                r#"{"type": "area", "at": [0, 1, 0], "target": [0, 0, 0], "size": [0, 1], "radiance": [1, 1, 1]}"#,
            ),
            "size[0]",
        ),
        (
            r#""view": {"fog": {"density": -1}},"#.into(),
            "view.fog.density",
        ),
        (r#""view": {"exposure": 99},"#.into(), "view.exposure"),
        (r#""view": {"tone": "film"},"#.into(), "film"),
        (around("nowhere.hdr"), "nowhere.hdr"),
        (around("../outside.hdr"), "outside.hdr"),
        (around("scene.json"), ".exr"),
        (around("empty.hdr"), "empty.hdr"),
        (around("nan.exr"), "column 3 of row 1"),
        (image("cut.png"), "cut.png"),
        (image("text.jpg"), "text.jpg"),
        (texture(r#"{"size": 0}"#), "textures.base_color.size"),
        (
            texture(r#"{"high": [2, 0, 0]}"#),
            "textures.base_color.high[0]",
        ),
        (
            texture(r#"{"pattern": {"type": "noise", "octaves": 99}}"#),
            "octaves",
        ),
        (texture(r#"{"pattern": {"type": "tiles"}}"#), "tiles"),
        (
            r#""materials": {"a": {"refractive_index": 0.5}},"#.into(),
            "refractive_index",
        ),
        (
            r#""materials": {"a": {"transmission": 2}},"#.into(),
            "transmission",
        ),
    ] {
        let text = format!(
            r#"{{"argil": 1, {what} "brushes": [{{"shape": {{"type": "sphere", "radius": 1}}}}]}}"#
        );
        let place = folder.path().join("scene.json");
        std::fs::write(&place, text).expect("a file");
        let place = place.display().to_string();
        let picture = folder.path().join("x.png").display().to_string();
        let asked = [&["render", &place, "-o", &picture], &SMALL[..]].concat();
        fails(&asked, 1, expected);
    }
}

/// Edits bring images, which are checked like the scene's own. Only stills need the image of the environment.
#[test]
fn edits_bring_images() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).display().to_string();
    image::RgbImage::from_pixel(2, 2, image::Rgb([200, 10, 10]))
        .save(place("red.png"))
        .expect("a PNG");
    let scene = r#"{"argil": 1, "materials": {"a": {}}, "brushes": [{"shape": {"type": "sphere", "radius": 1}, "material": "a"}]}"#;
    std::fs::write(place("scene.json"), scene).expect("a file");
    let edit = |line: &str| {
        std::fs::write(place("edits.jsonl"), line).expect("a file");
        [
            "edit",
            &place("scene.json"),
            "--edits",
            &place("edits.jsonl"),
            "--resolution",
            "32",
            "-o",
            &place("a.argil"),
        ]
        .map(str::to_owned)
        .to_vec()
    };
    let material = |path: &str| {
        format!(
            r#"{{"edit": "set_material", "name": "a", "material": {{"textures": {{"base_color": {{"pattern": {{"type": "image", "path": "{path}"}}}}}}}}}}"#
        )
    };
    let view = |path: &str| {
        format!(
            r#"{{"edit": "set_view", "view": {{"environment": {{"type": "image", "path": "{path}"}}}}}}"#
        )
    };
    let words = |line: &str| edit(line);
    for good in [material("red.png"), view("red.png")] {
        let asked = words(&good);
        argil(&asked.iter().map(String::as_str).collect::<Vec<_>>());
    }
    for bad in [material("blue.png"), view("blue.hdr"), view("../red.png")] {
        let asked = words(&bad);
        fails(
            &asked.iter().map(String::as_str).collect::<Vec<_>>(),
            1,
            "edits.jsonl:1",
        );
    }
    let around = scene.replace(
        r#""materials""#,
        r#""view": {"environment": {"type": "image", "path": "no.hdr"}}, "materials""#,
    );
    std::fs::write(place("around.json"), around).expect("a file");
    argil(&["info", &place("around.json")]);
    argil(&[
        "render",
        &place("around.json"),
        "--size",
        "8x8",
        "-o",
        &place("x.png"),
    ]);
    let (around, picture) = (place("around.json"), place("x.png"));
    let still = [&["render", &around, "-o", &picture], &SMALL[..]].concat();
    fails(&still, 1, "no.hdr");
}
