//! Tests the program that runs fuzz targets, by targets that fail.

use argil_fuzz::{CONTROLS, Mutator, TARGETS};
use std::process::{Command, Output};

fn fuzz(arguments: &[&str]) -> Output {
    let program = Command::new(env!("CARGO_BIN_EXE_argil-fuzz"))
        .args(arguments)
        .output();
    program.expect("the program runs")
}

#[test]
fn failing_targets_stop_the_program_and_leave_their_input() {
    let controls = [
        ("control-panic", "it panics"),
        ("control-memory", "bytes of memory"),
        ("control-slow", "does not end"),
    ];
    for (name, reason) in controls {
        let out = fuzz(&["--seconds", "30", name]);
        let said = String::from_utf8_lossy(&out.stderr);
        assert!(
            !out.status.success() && said.contains(reason),
            "{name}: {said}"
        );
        let path = said.rsplit(": ").next().expect("a path").trim();
        assert!(std::fs::read(path).is_ok(), "{path}");
    }
    let out = fuzz(&["--seconds", "0.2", "control-good"]);
    assert!(out.status.success(), "{out:?}");
    assert!(
        !fuzz(&["--seconds", "0.2", "control-good", "control-panic"])
            .status
            .success()
    );
}

/// Seeds that no reader accepts would reach nothing.
#[test]
fn seeds_can_be_read() {
    for target in TARGETS {
        let seeds = (target.seeds)();
        assert!(
            !seeds.is_empty() && seeds.iter().all(|seed| !seed.is_empty()),
            "{}",
            target.name
        );
        seeds.iter().for_each(|seed| (target.run)(seed));
    }
    for (name, format) in [
        ("glb", "glb"),
        ("gltf", "gltf"),
        ("obj", "obj"),
        ("ply", "ply"),
        ("stl", "stl"),
        ("3mf", "3mf"),
    ] {
        let target = argil_fuzz::find(name).expect("a target");
        let path = format!("a.{format}");
        let format = argil_mesh::MeshFormat::from_path(path.as_ref()).expect("a format");
        let first = &(target.seeds)()[0];
        assert!(
            argil_mesh::from_bytes(first, format, path.as_ref()).is_ok(),
            "{name}"
        );
    }
}

#[test]
fn inputs_are_the_same_each_time_and_differ_from_each_other() {
    let seeds = || (CONTROLS[0].seeds)();
    let inputs = |name| {
        let mut mutator = Mutator::new(name, seeds());
        (0..100).map(|_| mutator.next_input()).collect::<Vec<_>>()
    };
    assert_eq!(inputs("a"), inputs("a"));
    assert_ne!(inputs("a"), inputs("b"));
    let mut distinct = inputs("a");
    distinct.sort();
    distinct.dedup();
    assert!(distinct.len() > 50, "{}", distinct.len());
}
