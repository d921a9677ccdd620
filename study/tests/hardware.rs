//! The preset `hardware`: what it measures, and a run of it on a software GPU.

use argil::{Backend, Engine};
use argil_study::experiment::StudyCase;
use argil_study::experiments::ALL;
use argil_study::hardware::EXPERIMENTS;
use argil_study::plan::{Plan, Preset};
use argil_study::task::{FirstUse, Task};
use argil_study::{Record, Store, StudyOptions, StudyProgress, study};
use std::collections::BTreeSet;
use std::time::Duration;

const GPU: Plan = Plan {
    preset: Preset::Hardware,
    is_software_gpu: false,
    is_gpu: true,
    has_peer: true,
};

fn cases(name: &str, plan: &Plan) -> Vec<StudyCase> {
    let experiment = ALL.iter().find(|e| e.name == name).expect("an experiment");
    (experiment.cases)(plan)
}

/// Counts the cases of an experiment for which something holds.
fn count(name: &str, holds: impl Fn(&StudyCase) -> bool) -> usize {
    cases(name, &GPU).iter().filter(|case| holds(case)).count()
}

#[test]
fn the_preset_has_what_it_promises() {
    let spheres: Vec<String> = (1..=8).map(|side| format!("spheres-{side}")).collect();
    for scene in &spheres {
        let label = |case: &StudyCase, label| case.scene == *scene && case.way.label() == label;
        assert!(count("construction", |case| label(case, "octree")) > 0);
        assert!(count("construction", |case| label(case, "bricks")) > 0);
    }
    for scene in ["csg20", "teapot", "temple", "props"] {
        for resolution in [256, 512, 1024] {
            let is = |case: &StudyCase| case.scene == scene && case.way.resolution == resolution;
            let lit = |case: &StudyCase, lit| matches!(case.task, Task::Frames(series) if series.is_lit == lit);
            assert_eq!(count("bakes", is), 3, "{scene} {resolution}");
            assert!(count("frames", |case| is(case) && lit(case, false)) >= 4);
            assert!(count("frames", |case| is(case) && lit(case, true)) >= 2);
            let has_mesh = resolution <= 512 || scene == "csg20";
            assert_eq!(count("triangles", is), usize::from(has_mesh));
        }
    }
    for resolution in [256, 512, 1024] {
        let is = |case: &StudyCase| case.way.resolution == resolution;
        assert!(count("edits", is) > 0 && count("memory", is) == 10);
        assert_eq!(count("peer", is), 3);
    }
    assert_eq!(count("pipelines", |_| true), FirstUse::ALL.len());
}

#[test]
fn names_of_cases_are_unique() {
    for name in EXPERIMENTS {
        let all = cases(name, &GPU);
        let names: BTreeSet<String> = all
            .iter()
            .map(|case| format!("{}/{}", case.name(), case.task.word()))
            .collect();
        assert_eq!(names.len(), all.len(), "{name}");
    }
}

#[test]
fn compared_cases_share_a_group() {
    let experiment = ALL.iter().find(|e| e.name == "frames").expect("frames");
    let all = cases("frames", &GPU);
    let groups: BTreeSet<String> = all
        .iter()
        .map(|case| experiment.compared.group(case))
        .collect();
    // Each scene, resolution and light has one, and so does each of the study's other scenes.
    assert_eq!(groups.len(), 4 * 3 * 2 + 4);
}

#[test]
fn other_presets_and_devices_leave_out_what_they_lack() {
    let quick = Plan {
        preset: Preset::Quick,
        ..GPU
    };
    for name in ["bakes", "pipelines", "peer"] {
        assert!(cases(name, &quick).is_empty(), "{name}");
    }
    let without = Plan {
        has_peer: false,
        ..GPU
    };
    assert!(cases("peer", &without).is_empty());
}

struct Silent;

impl StudyProgress for Silent {
    fn started(&mut self, _: usize, _: usize) {}
    fn case(&mut self, _: &str, _: &str, _: &str) {}
    fn done(&mut self, error: Option<&str>) {
        assert_eq!(error, None);
    }
}

/// A software GPU runs each part of the preset with a small scene. A hardware GPU would take minutes.
#[test]
fn each_part_of_the_preset_becomes_records() {
    let engine = Engine::with_backend(Backend::Gpu).expect("a GPU");
    if engine
        .gpu_kind()
        .is_some_and(argil::gpu::DeviceKind::is_real_gpu)
    {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let options = StudyOptions {
        preset: Preset::Hardware,
        time_limit: Some(Duration::from_secs(3600)),
        ..StudyOptions::default()
    };
    let summary = study(
        std::slice::from_ref(&engine),
        &options,
        folder.path(),
        &mut Silent,
    )
    .expect("a study");
    assert_eq!((summary.failed, summary.broken), (0, 0));
    assert_eq!(summary.left_out, Vec::<String>::new());
    let records = Store::read(folder.path()).expect("records");
    for name in EXPERIMENTS.iter().filter(|name| **name != "peer") {
        let of_experiment: Vec<&Record> =
            records.iter().filter(|r| r.experiment == *name).collect();
        assert!(!of_experiment.is_empty(), "{name}");
        assert!(of_experiment.iter().all(|r| r.machine.preset == "hardware"));
    }
    let value = |record: &Record, name: &str| record.value(name).is_some_and(|value| value > 0.0);
    let frames: Vec<&Record> = records
        .iter()
        .filter(|r| r.experiment == "frames")
        .collect();
    assert!(
        frames
            .iter()
            .all(|r| value(r, "frame_ms") && value(r, "frame_wall_ms"))
    );
    // Frames with light and frames without are two sittings. Nothing says what the clock was.
    let sitting = |r: &Record| r.sitting.clone().expect("a sitting");
    let ids: BTreeSet<u64> = frames.iter().map(|r| sitting(r).id).collect();
    assert_eq!(ids.len(), 2);
    assert!(
        frames
            .iter()
            .all(|r| sitting(r).cases > 1 && sitting(r).attempts == 1)
    );
    assert!(records.iter().all(|r| r.value("gpu_clock_mhz").is_none()));
    assert!(
        records
            .iter()
            .any(|r| value(r, "first_ms") && value(r, "second_ms"))
    );

    // Nothing is measured in no time, and what was left out is named.
    let other = tempfile::tempdir().expect("a folder");
    let options = StudyOptions {
        time_limit: Some(Duration::ZERO),
        ..options
    };
    let summary = study(&[engine], &options, other.path(), &mut Silent).expect("a study");
    assert_eq!((summary.done, summary.left_out.len()), (0, records.len()));
    assert!(
        summary
            .left_out
            .iter()
            .any(|name| name.starts_with("frames csg20/bricks-32"))
    );
}
