//! The evaluation of the 2023 study, repeated and extended.
//!
//! *Practice.* Experiments ([`experiments`]) are data: questions, and cases of a scene, a representation and a
//! task. Each case runs alone and becomes a [`Record`]. A case that fails becomes a record with its error. The
//! [`report`](fn@report) is a function of records only: tables, plots, images, and the verdicts on the study's
//! claims.

mod claims;
mod command;
pub mod configuration;
mod environment;
pub mod experiment;
pub mod experiments;
mod formatting;
mod record;
mod report;
mod runner;
mod scenes;
mod views;
mod warm_up;

use anyhow::Context;
use argil::Engine;
use argil::gpu::DeviceKind;
use experiment::{Experiment, Plan, StudyCase};
pub use record::{Check, Machine, Record, Store};
pub use report::{findings, report};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

/// Options of a study.
#[derive(Clone, Debug, Default)]
pub struct StudyOptions {
    /// Whether to measure everything, instead of a quarter of an hour's worth.
    pub full: bool,
    /// Names of experiments to run. Empty runs all.
    pub only: Vec<String>,
}

/// Receives the progress of a study.
pub trait StudyProgress {
    /// The study started, with a number of cases. Some of them were done in an earlier run.
    fn started(&mut self, cases: usize, done: usize);
    /// A case begins.
    fn case(&mut self, device: &str, experiment: &str, case: &str);
    /// A case has finished, possibly with an error.
    fn done(&mut self, error: Option<&str>);
}

/// The result of a study.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Cases measured in this run.
    pub done: usize,
    /// Cases that failed.
    pub failed: usize,
    /// Checks that failed.
    pub broken: usize,
}

/// Measures on engines, one after another, and writes records to a folder. Records that exist are not measured
/// again.
///
/// # Errors
/// If the folder cannot be read or written, or an experiment's name is unknown.
pub fn study(
    engines: &[Engine],
    options: &StudyOptions,
    folder: &Path,
    progress: &mut dyn StudyProgress,
) -> anyhow::Result<Summary> {
    for name in &options.only {
        let known = || experiments::ALL.iter().map(|e| e.name).collect::<Vec<_>>();
        anyhow::ensure!(
            known().contains(&name.as_str()),
            "unknown experiment {name}; available: {}",
            known().join(", ")
        );
    }
    let mut store = Store::open(folder)?;
    let mut todo = Vec::new();
    let mut known = 0;
    for engine in engines {
        let machine = environment::machine(engine, options.full);
        let plan = plan(engine, options.full);
        for experiment in experiments::ALL {
            if !options.only.is_empty() && !options.only.iter().any(|n| n == experiment.name) {
                continue;
            }
            for case in (experiment.cases)(&plan) {
                let record = blank(experiment, &case, &plan, &machine);
                if store.has(&record) {
                    known += 1;
                } else {
                    todo.push((engine, plan, case, record));
                }
            }
        }
    }
    progress.started(todo.len() + known, known);
    let mut summary = Summary::default();
    for (engine, plan, case, record) in todo {
        progress.case(&record.machine.device, &record.experiment, &record.case);
        let (record, pictures) = run(&case, engine, &plan, record);
        summary.done += 1;
        summary.failed += usize::from(record.error.is_some());
        summary.broken += record.checks.iter().filter(|check| !check.passed).count();
        progress.done(record.error.as_deref());
        store.add(record, &pictures)?;
    }
    Ok(summary)
}

fn plan(engine: &Engine, full: bool) -> Plan {
    Plan {
        full,
        is_software_gpu: engine.gpu_kind() == Some(DeviceKind::Software),
        is_gpu: engine.gpu_kind().is_some(),
    }
}

/// Creates a case's record without results.
fn blank(experiment: &Experiment, case: &StudyCase, plan: &Plan, machine: &Machine) -> Record {
    let parameters = case.parameters().into_iter();
    let mut parameters: std::collections::BTreeMap<_, _> = parameters
        .map(|(key, value)| (key.to_owned(), value))
        .collect();
    let size = plan.size();
    parameters.insert("size".into(), serde_json::json!(size));
    Record {
        experiment: experiment.name.into(),
        case: format!("{}/{}", case.name(), task_word(case)),
        scene: case.scene.clone(),
        via: case.way.label().into(),
        parameters,
        command: command::command(case, plan),
        machine: machine.clone(),
        ..Record::default()
    }
}

fn task_word(case: &StudyCase) -> &'static str {
    use experiment::Task;
    match case.task {
        Task::Build(_) => "build",
        Task::Frames(..) => "frames",
        Task::Picture(_) => "picture",
        Task::Stored(_) => "stored",
        Task::Surface(_) => "surface",
        Task::Edits(..) => "edits",
        Task::CountLostBricks => "lost",
    }
}

type Pictures = Vec<(String, image::RgbImage)>;

fn run(case: &StudyCase, engine: &Engine, plan: &Plan, mut record: Record) -> (Record, Pictures) {
    let start = Instant::now();
    // An error in one case does not end the others.
    let result = catch_unwind(AssertUnwindSafe(|| runner::perform(case, engine, plan)));
    let result = result.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        Err(anyhow::anyhow!(
            "internal error: {}",
            text.unwrap_or_default()
        ))
    });
    record.seconds = start.elapsed().as_secs_f64();
    let mut pictures = Vec::new();
    match result.with_context(|| record.case.clone()) {
        Err(error) => record.error = Some(format!("{error:#}")),
        Ok(outcome) => {
            record.samples = outcome.samples;
            record.values = outcome.values;
            if let Some(clock) = environment::gpu_clock_mhz(&record.machine.device) {
                record.values.insert("gpu_clock_mhz".into(), clock);
            }
            for expect in &case.expect {
                let found = record.value(expect.value);
                record.checks.push(Check {
                    value: expect.value.into(),
                    expected: if expect.min == expect.max {
                        format!("= {}", expect.min)
                    } else {
                        format!("from {} to {}", expect.min, expect.max)
                    },
                    found,
                    passed: found.is_some_and(|n| (expect.min..=expect.max).contains(&n)),
                });
            }
            for (name, picture) in outcome.pictures {
                if !report::is_shown(&record, &name) {
                    continue;
                }
                let file = file_name(&record, &name);
                record.pictures.insert(name, file.clone());
                pictures.push((file, picture));
            }
        }
    }
    (record, pictures)
}

/// Returns a file name for an image that is valid on any system.
fn file_name(record: &Record, name: &str) -> String {
    let text = format!(
        "{}-{}-{}-{}-{name}",
        record.machine.preset, record.machine.device, record.experiment, record.case
    );
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() {
            c.to_ascii_lowercase()
        } else {
            '-'
        }
    };
    let mut name: String = text.chars().map(plain).collect();
    name.push_str(".png");
    name
}
