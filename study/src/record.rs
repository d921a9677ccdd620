//! Records, and the folder that stores them.
//!
//! *Practice.* A record is a line of JSON, written when its sitting has finished. An interrupted run loses at most one
//! sitting. Images are stored next to the records, by the names in them. Reports are made from nothing else.

use anyhow::Context;
use image::RgbImage;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The machine and program of a record.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The operating system.
    pub system: String,
    /// The processor.
    pub processor: String,
    /// Clock of the processor at the start, in MHz.
    pub clock_mhz: u64,
    /// Number of CPU threads.
    pub threads: usize,
    /// `cpu`, or the GPU's name.
    pub device: String,
    /// The GPU's driver and interface.
    pub driver: String,
    /// Argil's version.
    pub version: String,
    /// Argil's commit.
    pub commit: String,
    /// The preset: `quick`, `full` or `hardware`.
    pub preset: String,
}

/// Words in the names of software GPUs.
const SOFTWARE: [&str; 3] = ["llvmpipe", "SwiftShader", "Microsoft Basic Render"];

impl Machine {
    /// Returns true if the device is a GPU in hardware.
    pub fn is_hardware_gpu(&self) -> bool {
        let is_software = SOFTWARE.iter().any(|word| self.device.contains(word));
        !self.driver.is_empty() && !is_software
    }
}

/// How the samples of a case were taken.
///
/// Samples of cases with one `id` took turns: a sample of each case, round by round.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sitting {
    /// When the sitting started, in microseconds since 1970.
    pub id: u64,
    /// The number of cases.
    pub cases: usize,
    /// How often all samples were taken, until the clocks of the GPU agreed. The last ones are kept.
    pub attempts: u32,
    /// Why the case was measured without those that it is compared with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alone_because: Option<String>,
}

/// An expected value, and the value found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Name of the value.
    pub value: String,
    /// The expectation, such as `= 512`.
    pub expected: String,
    /// The value found, if there is one.
    pub found: Option<f64>,
    /// Whether it matches.
    pub passed: bool,
}

/// A measured case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Name of the experiment.
    pub experiment: String,
    /// Name of the case, unique in the experiment.
    pub case: String,
    /// Name of the scene.
    pub scene: String,
    /// The representation as a word.
    pub via: String,
    /// Other parameters that vary.
    pub parameters: BTreeMap<String, Value>,
    /// The command that repeats the case, if there is one.
    pub command: Option<String>,
    /// The machine.
    pub machine: Machine,
    /// All samples of repeated measurements.
    pub samples: BTreeMap<String, Vec<f64>>,
    /// Single measurements.
    pub values: BTreeMap<String, f64>,
    /// Files in the folder of images.
    pub pictures: BTreeMap<String, String>,
    /// Checks of expectations.
    pub checks: Vec<Check>,
    /// The error, if the case failed.
    pub error: Option<String>,
    /// How the samples were taken. Records from before 2026-11-27 do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sitting: Option<Sitting>,
    /// Total duration of the case in seconds.
    pub seconds: f64,
}

impl Record {
    /// Returns the median of a value's samples, or the single value.
    pub fn value(&self, name: &str) -> Option<f64> {
        match self.samples.get(name) {
            Some(samples) => median(samples),
            None => self.values.get(name).copied(),
        }
    }

    /// Returns a parameter as a number.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters.get(name)?.as_f64()
    }

    fn is_same_case(&self, other: &Self) -> bool {
        self.experiment == other.experiment
            && self.case == other.case
            && self.machine.device == other.machine.device
            && self.machine.processor == other.machine.processor
            && self.machine.preset == other.machine.preset
    }
}

/// Returns the median, or `None` of no samples.
pub(crate) fn median(samples: &[f64]) -> Option<f64> {
    let mut all = samples.to_vec();
    all.sort_by(f64::total_cmp);
    let last = all.len().checked_sub(1)?;
    Some(0.5 * (all[last / 2] + all[last.div_ceil(2)]))
}

/// Returns the smallest sample that is at least as large as a fraction of all.
pub(crate) fn quantile(samples: &[f64], part: f64) -> Option<f64> {
    let mut all = samples.to_vec();
    all.sort_by(f64::total_cmp);
    let at = (part * all.len() as f64).ceil() as usize;
    all.get(at.saturating_sub(1)).copied()
}

/// A folder of records.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    records: Vec<Record>,
}

const FILE: &str = "records.jsonl";
const PICTURES: &str = "pictures";

impl Store {
    /// Opens a folder, which may contain records.
    ///
    /// # Errors
    /// If a line is not a record. The last line may be incomplete, because a run was interrupted.
    pub fn open(folder: &Path) -> anyhow::Result<Self> {
        fs::create_dir_all(folder.join(PICTURES))
            .with_context(|| folder.join(PICTURES).display().to_string())?;
        let file = folder.join(FILE);
        let mut store = Self {
            folder: folder.into(),
            records: Vec::new(),
        };
        if !file.exists() {
            return Ok(store);
        }
        let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        let (records, whole) = parse(&text, &file)?;
        anyhow::ensure!(
            whole > 0 || text.is_empty() || text.starts_with("{\"experiment\""),
            "cannot use {}: it contains no records and would be overwritten; choose another folder",
            file.display()
        );
        store.records = records;
        if whole < text.len() {
            let handle = fs::OpenOptions::new().write(true).open(&file);
            let cut = handle.and_then(|handle| handle.set_len(whole as u64));
            cut.with_context(|| file.display().to_string())?;
        }
        Ok(store)
    }

    /// Reads the records of a folder or file.
    ///
    /// # Errors
    /// If there are none.
    pub fn read(place: &Path) -> anyhow::Result<Vec<Record>> {
        let file = Self::file_of(place);
        let text = fs::read_to_string(&file).with_context(|| {
            format!(
                "cannot read {}: expected a folder written by `argil study`, or its {FILE}",
                file.display()
            )
        })?;
        let (records, _) = parse(&text, &file)?;
        anyhow::ensure!(
            !records.is_empty(),
            "{}: contains no records",
            file.display()
        );
        Ok(records)
    }

    /// Returns the records file of a path.
    pub fn file_of(place: &Path) -> PathBuf {
        if place.is_dir() {
            place.join(FILE)
        } else {
            place.into()
        }
    }

    /// Returns the image folder of a path.
    pub fn pictures_of(place: &Path) -> PathBuf {
        let folder = if place.is_dir() {
            place
        } else {
            place.parent().unwrap_or(Path::new("."))
        };
        folder.join(PICTURES)
    }

    /// Returns all records.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// Returns true if a case was measured by the same commit with the same preset.
    pub fn has(&self, like: &Record) -> bool {
        self.records.iter().any(|r| {
            r.is_same_case(like)
                && r.machine.commit == like.machine.commit
                && r.machine.preset == like.machine.preset
                && r.error.is_none()
        })
    }

    /// Adds a record and its images.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn add(&mut self, record: Record, pictures: &[(String, RgbImage)]) -> anyhow::Result<()> {
        for (name, picture) in pictures {
            let path = self.folder.join(PICTURES).join(name);
            let small = crate::formatting::shown(picture);
            argil::save_png(&path, small.dimensions().into(), &small)?;
        }
        let file = self.folder.join(FILE);
        let mut line = serde_json::to_string(&record)?;
        line.push('\n');
        let mut handle = fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&file)
            .with_context(|| file.display().to_string())?;
        handle
            .write_all(line.as_bytes())
            .with_context(|| file.display().to_string())?;
        self.records.push(record);
        Ok(())
    }
}

/// Parses records. Returns the last record of each case, and the number of bytes in complete lines.
fn parse(text: &str, file: &Path) -> anyhow::Result<(Vec<Record>, usize)> {
    let mut records: Vec<Record> = Vec::new();
    let mut whole = 0;
    for (number, line) in text.split_inclusive('\n').enumerate() {
        if !line.ends_with('\n') {
            break;
        }
        whole += line.len();
        if line.trim().is_empty() {
            continue;
        }
        let record: Record = serde_json::from_str(line)
            .with_context(|| format!("{}:{}: not a record", file.display(), number + 1))?;
        match records.iter_mut().find(|known| known.is_same_case(&record)) {
            Some(known) => *known = record,
            None => records.push(record),
        }
    }
    Ok((records, whole))
}
