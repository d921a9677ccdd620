//! Runs experiments on devices, and stores their records.

use crate::command;
use crate::environment;
use crate::experiment::{Expectation, Experiment, StudyCase};
use crate::experiments;
use crate::hardware;
use crate::outcome::Outcome;
use crate::peer::Peer;
use crate::plan::{Plan, Preset};
use crate::prepared::Setup;
use crate::record::{Check, Machine, Record, Store};
use crate::report;
use crate::sitting::{SittingResult, TimeLimit, sit};
use crate::warm_up::Awake;
use anyhow::Context;
use argil::Engine;
use argil::gpu::DeviceKind;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// Options of a study.
#[derive(Clone, Debug, Default)]
pub struct StudyOptions {
    /// The amount of measurements.
    pub preset: Preset,
    /// Names of experiments to run. Empty runs all of the preset.
    pub only: Vec<String>,
    /// The program of another renderer, to measure in the same sitting.
    pub peer: Option<Peer>,
    /// How long the study may take. `None` is the limit of the preset, if it has one.
    pub time_limit: Option<Duration>,
}

/// Receives the progress of a study.
pub trait StudyProgress {
    /// The study started, with a number of cases. Some of them were done in an earlier run.
    fn started(&mut self, cases: usize, done: usize);
    /// A case begins.
    fn case(&mut self, device: &str, experiment: &str, case: &str);
    /// A case has finished, possibly with an error.
    fn done(&mut self, error: Option<&str>);
    /// Something is worth knowing.
    fn note(&mut self, _text: &str) {}
}

/// The result of a study.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Cases measured in this run.
    pub done: usize,
    /// Cases that failed.
    pub failed: usize,
    /// Checks that failed.
    pub broken: usize,
    /// Experiments and cases that were left out, because the time was used up.
    pub left_out: Vec<String>,
}

/// Cases of a device that are measured in one sitting.
struct Group<'a> {
    engine: &'a Engine,
    plan: Plan,
    experiment: &'static Experiment,
    cases: Vec<(StudyCase, Record)>,
}

impl Group<'_> {
    /// Returns the highest resolution of the cases.
    fn resolution(&self) -> u32 {
        let all = self.cases.iter().map(|(case, _)| case.way.resolution);
        all.max().unwrap_or(0)
    }
}

/// Measures on engines, one after another, and writes records to a folder. A group of cases whose records exist is not
/// measured again.
///
/// # Errors
/// If the folder cannot be read or written, an experiment's name is unknown, or a GPU fails.
pub fn study(
    engines: &[Engine],
    options: &StudyOptions,
    folder: &Path,
    progress: &mut dyn StudyProgress,
) -> anyhow::Result<Summary> {
    let start = Instant::now();
    let wanted = wanted(options)?;
    let mut store = Store::open(folder)?;
    let mut todo = Vec::new();
    let (mut count, mut known) = (0, 0);
    for engine in engines {
        let plan = plan(engine, options);
        let machine = environment::machine(engine, options.preset);
        for &experiment in &wanted {
            for group in groups(engine, plan, experiment, &machine) {
                let cases = group.cases.len();
                count += cases;
                if group.cases.iter().all(|(_, record)| store.has(record)) {
                    known += cases;
                } else {
                    todo.push(group);
                }
            }
        }
    }
    if options.preset == Preset::Hardware {
        // Each experiment gets its turn before time runs out.
        todo.sort_by_key(Group::resolution);
    }
    progress.started(count, known);
    let budget = (options.preset == Preset::Hardware).then_some(hardware::BUDGET);
    let budget = options.time_limit.or(budget);
    let mut clock = TimeBudget::new(start, budget);
    let mut summary = Summary::default();
    let mut awake: Option<(&Engine, Awake)> = None;
    for group in todo {
        if !clock.has_time_for(group.experiment) {
            let names = group.cases.iter().map(|(_, record)| name_of(record));
            summary.left_out.extend(names);
            continue;
        }
        let is_other = |(engine, _): &(&Engine, Awake)| !std::ptr::eq(*engine, group.engine);
        if awake.as_ref().is_none_or(is_other) {
            // The last sampler ends before another starts.
            drop(awake.take());
            let woken = wake(&group)?;
            if let Some(reason) = woken.unknown_clock() {
                progress.note(&format!("the clock of the GPU is unknown: {reason}"));
            }
            awake = Some((group.engine, woken));
        }
        let Some((_, woken)) = &awake else { continue };
        let (name, began) = (group.experiment.name, Instant::now());
        measure(
            group,
            options,
            (woken, &clock),
            &mut store,
            (progress, &mut summary),
        )?;
        clock.add(name, began.elapsed());
    }
    Ok(summary)
}

/// Returns the experiments to run.
fn wanted(options: &StudyOptions) -> anyhow::Result<Vec<&'static Experiment>> {
    let all: Vec<&Experiment> = if options.preset == Preset::Hardware {
        let find = |name: &&str| experiments::ALL.iter().find(|e| e.name == *name);
        hardware::EXPERIMENTS.iter().filter_map(find).collect()
    } else {
        experiments::ALL.iter().collect()
    };
    let names: Vec<&str> = all.iter().map(|e| e.name).collect();
    for name in &options.only {
        anyhow::ensure!(
            names.contains(&name.as_str()),
            "unknown experiment {name}; available with this preset: {}",
            names.join(", ")
        );
    }
    let is_wanted =
        |e: &&Experiment| options.only.is_empty() || options.only.iter().any(|n| n == e.name);
    Ok(all.into_iter().filter(is_wanted).collect())
}

fn plan(engine: &Engine, options: &StudyOptions) -> Plan {
    Plan {
        preset: options.preset,
        is_software_gpu: engine.gpu_kind() == Some(DeviceKind::Software),
        is_gpu: engine.gpu_kind().is_some(),
        has_peer: options.peer.is_some(),
    }
}

/// Returns the groups of an experiment, in the order of their first cases.
fn groups<'a>(
    engine: &'a Engine,
    plan: Plan,
    experiment: &'static Experiment,
    machine: &Machine,
) -> Vec<Group<'a>> {
    let mut names: Vec<String> = Vec::new();
    let mut all: Vec<Group<'_>> = Vec::new();
    for case in (experiment.cases)(&plan) {
        let name = experiment.compared.group(&case);
        let record = blank(experiment, &case, &plan, machine);
        if let Some(i) = names.iter().position(|known| *known == name) {
            all[i].cases.push((case, record));
        } else {
            names.push(name);
            all.push(Group {
                engine,
                plan,
                experiment,
                cases: vec![(case, record)],
            });
        }
    }
    all
}

/// The time that is left.
struct TimeBudget {
    deadline: Option<Instant>,
    /// The longest sitting of each experiment.
    longest: BTreeMap<&'static str, Duration>,
}

impl TimeBudget {
    fn new(start: Instant, limit: Option<Duration>) -> Self {
        Self {
            deadline: limit.map(|limit| start + limit),
            longest: BTreeMap::new(),
        }
    }

    /// Returns true if a sitting as long as the longest of its experiment so far ends in time.
    fn has_time_for(&self, experiment: &Experiment) -> bool {
        let longest = self.longest.get(experiment.name);
        let longest = longest.copied().unwrap_or_default();
        self.deadline
            .is_none_or(|deadline| Instant::now() + longest < deadline)
    }

    fn add(&mut self, experiment: &'static str, time: Duration) {
        let longest = self.longest.entry(experiment).or_default();
        *longest = time.max(*longest);
    }
}

/// Starts to keep a group's GPU awake.
fn wake(group: &Group<'_>) -> anyhow::Result<Awake> {
    if !group.plan.is_hardware() {
        return Ok(Awake::idle());
    }
    let device = group
        .cases
        .first()
        .map(|(_, record)| &record.machine.device);
    Awake::start(group.engine, device.map_or("", String::as_str))
}

fn name_of(record: &Record) -> String {
    format!("{} {}", record.experiment, record.case)
}

/// Measures a group, and stores its records.
fn measure(
    group: Group<'_>,
    options: &StudyOptions,
    (awake, clock): (&Awake, &TimeBudget),
    store: &mut Store,
    (progress, summary): (&mut dyn StudyProgress, &mut Summary),
) -> anyhow::Result<()> {
    let setup = Setup {
        engine: group.engine,
        plan: &group.plan,
        peer: options.peer.as_ref(),
    };
    let limit = TimeLimit {
        sampling: clock.deadline.map(|_| hardware::SAMPLING),
        deadline: clock.deadline,
    };
    for (_, record) in &group.cases {
        progress.case(&record.machine.device, &record.experiment, &record.case);
    }
    let cases: Vec<&StudyCase> = group.cases.iter().map(|(case, _)| case).collect();
    let results = sit(&cases, setup, awake, limit);
    for ((case, record), result) in group.cases.into_iter().zip(results) {
        let Some(result) = result else {
            summary.left_out.push(name_of(&record));
            continue;
        };
        let (record, pictures) = filled(&case, record, result);
        summary.done += 1;
        summary.failed += usize::from(record.error.is_some());
        summary.broken += record.checks.iter().filter(|check| !check.passed).count();
        progress.done(record.error.as_deref());
        store.add(record, &pictures)?;
    }
    Ok(())
}

/// Creates a case's record without results.
fn blank(experiment: &Experiment, case: &StudyCase, plan: &Plan, machine: &Machine) -> Record {
    let parameters = case.parameters().into_iter();
    let mut parameters: BTreeMap<_, _> = parameters
        .map(|(key, value)| (key.to_owned(), value))
        .collect();
    parameters
        .entry("size".into())
        .or_insert_with(|| serde_json::json!(plan.size()));
    Record {
        experiment: experiment.name.into(),
        case: format!("{}/{}", case.name(), case.task.word()),
        scene: case.scene.clone(),
        via: case.way.label().into(),
        parameters,
        command: command::command(case, plan),
        machine: machine.clone(),
        ..Record::default()
    }
}

type Pictures = Vec<(String, image::RgbImage)>;

/// Adds results to a record.
fn filled(case: &StudyCase, mut record: Record, result: SittingResult) -> (Record, Pictures) {
    record.seconds = result.seconds;
    record.sitting = Some(result.sitting);
    let mut pictures = Vec::new();
    match result.outcome.with_context(|| record.case.clone()) {
        Err(error) => record.error = Some(format!("{error:#}")),
        Ok(Outcome {
            samples,
            values,
            pictures: images,
        }) => {
            record.samples = samples;
            record.values = values;
            record.checks = checks(case, &record);
            for (name, picture) in images {
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

fn checks(case: &StudyCase, record: &Record) -> Vec<Check> {
    let check = |expect: &Expectation| {
        let found = record.value(expect.value);
        Check {
            value: expect.value.into(),
            expected: if expect.min == expect.max {
                format!("= {}", expect.min)
            } else {
                format!("from {} to {}", expect.min, expect.max)
            },
            found,
            passed: found.is_some_and(|n| (expect.min..=expect.max).contains(&n)),
        }
    };
    case.expect.iter().map(check).collect()
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
