//! The preset `hardware`: what tells most about a GPU, in five minutes.
//!
//! *Practice.* Low resolutions of all experiments come first, because what comes last is left out where time runs out. A
//! software GPU gets one small scene, so that a test can run all parts.

use crate::configuration::{
    BRICKS, Configuration, ConfigurationKind, DENSE, MESH, MIPPED, STUDY_OCTREE,
};
use crate::experiment::StudyCase;
use crate::plan::{Plan, Preset};
use crate::scenes::OF_THE_STUDY;
use crate::task::{FirstUse, FrameSeries, Task};
use argil::volume::SampleFormat;
use std::time::Duration;

/// The experiments of the preset, in the order of their use.
pub const EXPERIMENTS: [&str; 10] = [
    "construction",
    "bakes",
    "frames",
    "edits",
    "triangles",
    "stills",
    "peer",
    "pipelines",
    "memory",
    "dense-fill",
];

/// How long the preset measures. The rest of five minutes is for the end of the last sitting and the report.
pub const BUDGET: Duration = Duration::from_secs(285);

/// How long samples of one sitting are taken.
pub(crate) const SAMPLING: Duration = Duration::from_secs(8);

/// Returns the scenes of bakes, frames and meshes.
fn scenes(plan: &Plan) -> &'static [&'static str] {
    let all = &["csg20", "teapot", "temple", "props"];
    if plan.is_hardware() { all } else { &all[..1] }
}

/// Returns the voxels along the longest side.
fn resolutions(plan: &Plan) -> &'static [u32] {
    if plan.is_hardware() {
        &[256, 512, 1024]
    } else {
        &[32]
    }
}

/// Returns one of two numbers of runs.
fn runs(plan: &Plan, on_hardware: u32) -> u32 {
    if plan.is_hardware() { on_hardware } else { 1 }
}

/// Returns the cases of bakes. They are measured by this preset alone.
pub(crate) fn bakes(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    if plan.preset != Preset::Hardware {
        return all;
    }
    for &resolution in resolutions(plan) {
        for scene in scenes(plan) {
            for kind in [DENSE, STUDY_OCTREE, BRICKS] {
                let way = Configuration::of(kind, resolution);
                all.push(StudyCase::new(*scene, way, Task::Build(runs(plan, 5))));
            }
        }
    }
    all
}

/// Returns frames with and without light, through volumes of each resolution and through the field.
pub(crate) fn frames(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    let mut add = |scene: &str, kind: ConfigurationKind, resolution: u32, is_lit: bool| {
        let series = FrameSeries {
            count: plan.frames(),
            is_lit,
            ..FrameSeries::default()
        };
        let way = Configuration::of(kind, resolution);
        let case = StudyCase::new(scene, way, Task::Frames(series));
        all.push(case.expect("hit_pixels", 1.0, f64::INFINITY));
    };
    let first = resolutions(plan)[0];
    for &resolution in resolutions(plan) {
        for scene in scenes(plan) {
            for kind in [DENSE, MIPPED, STUDY_OCTREE, BRICKS] {
                add(scene, kind, resolution, false);
            }
            for kind in [DENSE, BRICKS] {
                add(scene, kind, resolution, true);
            }
            if resolution == first {
                add(scene, ConfigurationKind::Field, resolution, false);
                add(scene, ConfigurationKind::Field, resolution, true);
            }
            // The study's functional renderer compiled its scene into the shader.
            if resolution == first && *scene == "teapot" {
                add(scene, ConfigurationKind::Compiled, resolution, false);
            }
        }
    }
    // The study's other scenes.
    let others = OF_THE_STUDY.iter().filter(|scene| **scene != "teapot");
    for scene in others.filter(|_| plan.is_hardware()) {
        for kind in [
            ConfigurationKind::Field,
            DENSE,
            MIPPED,
            STUDY_OCTREE,
            BRICKS,
        ] {
            add(scene, kind, first, false);
        }
    }
    all
}

/// Returns edits: of bricks at each resolution, and of volumes that are rebuilt.
pub(crate) fn edits(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    let mut add = |kind: ConfigurationKind, resolution: u32, radius: f32| {
        let count = if kind == BRICKS { 60 } else { 5 };
        let way = Configuration::of(kind, resolution);
        let task = Task::Edits(runs(plan, count), radius);
        all.push(StudyCase::new("csg20", way, task));
    };
    let first = resolutions(plan)[0];
    for &resolution in resolutions(plan) {
        add(BRICKS, resolution, 0.02);
    }
    if plan.is_hardware() {
        add(BRICKS, first, 0.08);
    }
    add(STUDY_OCTREE, first, 0.02);
    add(DENSE, first, 0.02);
    all
}

/// Returns meshes. They are compared with the exact surface by other presets.
pub(crate) fn triangles(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    for &resolution in resolutions(plan) {
        for &scene in scenes(plan) {
            // Others have too many triangles.
            if resolution <= 512 || scene == "csg20" {
                let way = Configuration::of(MESH, resolution);
                all.push(StudyCase::new(scene, way, Task::Surface(0)));
            }
        }
    }
    all
}

/// Returns builds whose memory counts.
pub(crate) fn memory(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    for &resolution in resolutions(plan) {
        for scene in scenes(plan).iter().take(2) {
            let kinds = [DENSE, BRICKS, MIPPED, STUDY_OCTREE];
            let count = if plan.is_hardware() { kinds.len() } else { 2 };
            for &kind in &kinds[..count] {
                let way = Configuration::of(kind, resolution);
                all.push(StudyCase::new(*scene, way, Task::Build(1)));
            }
            if !plan.is_hardware() {
                continue;
            }
            let eight = Configuration::of(BRICKS, resolution).bits(SampleFormat::Snorm8);
            all.push(StudyCase::new(*scene, eight, Task::Build(1)));
        }
    }
    all
}

/// Returns first uses of a GPU.
pub(crate) fn pipelines(plan: &Plan) -> Vec<StudyCase> {
    if plan.preset != Preset::Hardware || !plan.is_gpu {
        return Vec::new();
    }
    let case = |kind| {
        let kind_of_volume = match kind {
            FirstUse::FieldFrame | FirstUse::Mesh => ConfigurationKind::Field,
            _ => BRICKS,
        };
        let way = Configuration::of(kind_of_volume, 64);
        StudyCase::new("csg20", way, Task::FirstUse(kind))
    };
    // On a software GPU, most take seconds.
    let all = FirstUse::ALL.into_iter();
    let some = all.filter(|kind| plan.is_hardware() || *kind == FirstUse::FieldFrame);
    some.map(case).collect()
}

/// Returns stills of scenes from a small one to a large one. They are measured by this preset alone.
pub(crate) fn stills(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    if plan.preset != Preset::Hardware {
        return all;
    }
    for scene in scenes(plan).iter().take(3) {
        for kind in [ConfigurationKind::Field, BRICKS] {
            let way = Configuration::of(kind, resolutions(plan)[0]);
            all.push(StudyCase::new(*scene, way, Task::Still(runs(plan, 3))));
        }
    }
    all
}

/// Returns frames beside another renderer's. A software GPU takes minutes for one of those.
pub(crate) fn peer(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    if plan.preset != Preset::Hardware || !plan.has_peer || !plan.is_hardware() {
        return all;
    }
    for side in [256, 512, 1024] {
        let peer = Configuration::of(ConfigurationKind::FidgetWgpu, side);
        all.push(StudyCase::new("csg20", peer, Task::Peer(3)));
        for kind in [ConfigurationKind::Field, BRICKS] {
            let series = FrameSeries {
                count: plan.frames(),
                size: Some([side, side]),
                ..FrameSeries::default()
            };
            let way = Configuration::of(kind, side);
            all.push(StudyCase::new("csg20", way, Task::Frames(series)));
        }
    }
    all
}
