//! Tests `argil render --integrator path`.

mod common;

use common::{argil, fails, json, scene};

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
    let (found, _) = picture("d.png", &["--samples", "1000000", "--time-limit", "0.5"]);
    assert!(
        (1..1_000_000).contains(&found["samples"].as_u64().unwrap_or(0)),
        "{found}"
    );
    let (_, exr) = picture("e.exr", &["--samples", "16"]);
    let read = image::load_from_memory(&exr).expect("an EXR").into_rgb32f();
    assert_eq!((read.width(), read.height()), (48, 32));
    assert!(read.iter().any(|&light| light > 1.0) && read.iter().all(|light| *light >= 0.0));
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
        &["--integrator", "path", "--device", "gpu"],
        &["--integrator", "path", "--via", "octree"],
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
