//! Rows of data, and the folder that they are kept in.
//!
//! *Practice.* A record is a line of JSON, written whole when its case is done, so that a run which is cut short loses one
//! case at most. Pictures lie beside, by the names that records give them. Reports are made of nothing else.

use anyhow::Context;
use image::RgbImage;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What a record was made on and by.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The operating system.
    pub system: String,
    /// The processor, and what it ran at when the study began, in MHz.
    pub processor: String,
    /// See `processor`.
    pub clock_mhz: u64,
    /// Threads that the CPU used.
    pub threads: usize,
    /// `cpu`, or the GPU's name.
    pub device: String,
    /// The GPU's driver and interface.
    pub driver: String,
    /// Argil's version.
    pub version: String,
    /// Argil's commit.
    pub commit: String,
    /// How much was measured: `quick` or `full`.
    pub preset: String,
}

/// What was expected of a value, and whether it was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// The value's name.
    pub value: String,
    /// Such as `= 512`.
    pub expected: String,
    /// What it was, if it was there.
    pub found: Option<f64>,
    /// Whether that is as expected.
    pub passed: bool,
}

/// One case of an experiment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The experiment's name.
    pub experiment: String,
    /// The case's, of its own in the experiment.
    pub case: String,
    /// The scene's name.
    pub scene: String,
    /// The representation in a word.
    pub via: String,
    /// What was varied, besides those.
    pub parameters: BTreeMap<String, Value>,
    /// The command that shows the same, where there is one.
    pub command: Option<String>,
    /// Where.
    pub machine: Machine,
    /// Every sample of what was measured more than once.
    pub samples: BTreeMap<String, Vec<f64>>,
    /// What was measured once.
    pub values: BTreeMap<String, f64>,
    /// Files in the folder of pictures.
    pub pictures: BTreeMap<String, String>,
    /// Whether what must be is.
    pub checks: Vec<Check>,
    /// Why there is nothing else.
    pub error: Option<String>,
    /// What the case took in all.
    pub seconds: f64,
}

impl Record {
    /// The median of a value's samples, or the value that was measured once.
    pub fn value(&self, name: &str) -> Option<f64> {
        match self.samples.get(name) {
            Some(samples) => median(samples),
            None => self.values.get(name).copied(),
        }
    }

    /// A parameter as a number.
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

/// The middle one, of an even count the mean of both; `None` of nothing.
pub(crate) fn median(samples: &[f64]) -> Option<f64> {
    let mut all = samples.to_vec();
    all.sort_by(f64::total_cmp);
    let last = all.len().checked_sub(1)?;
    Some(0.5 * (all[last / 2] + all[last.div_ceil(2)]))
}

/// The sample that a part of all is no greater than.
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
    /// A folder that may have records already.
    ///
    /// # Errors
    /// If there is a line that is no record, but for the last, which a run that was killed may have left unfinished.
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
            "{}: no records are in it, and it would be replaced; take another folder",
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

    /// The records of a folder or of a file of them; nothing is written.
    ///
    /// # Errors
    /// If there are none.
    pub fn read(place: &Path) -> anyhow::Result<Vec<Record>> {
        let file = Self::file_of(place);
        let text = fs::read_to_string(&file).with_context(|| {
            format!(
                "{}: a folder that `argil study` has written, or its {FILE}",
                file.display()
            )
        })?;
        let (records, _) = parse(&text, &file)?;
        anyhow::ensure!(!records.is_empty(), "{}: no record in it", file.display());
        Ok(records)
    }

    /// The file of a place's records.
    pub fn file_of(place: &Path) -> PathBuf {
        if place.is_dir() {
            place.join(FILE)
        } else {
            place.into()
        }
    }

    /// The folder of a place's pictures.
    pub fn pictures_of(place: &Path) -> PathBuf {
        let folder = if place.is_dir() {
            place
        } else {
            place.parent().unwrap_or(Path::new("."))
        };
        folder.join(PICTURES)
    }

    /// All records.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// Whether a case was done by the same commit, in the same preset.
    pub fn has(&self, like: &Record) -> bool {
        self.records.iter().any(|r| {
            r.is_same_case(like)
                && r.machine.commit == like.machine.commit
                && r.machine.preset == like.machine.preset
                && r.error.is_none()
        })
    }

    /// Keep a record and its pictures.
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

/// Records, the last of each case, and how many bytes are whole lines.
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
            .with_context(|| format!("{}:{}: no record", file.display(), number + 1))?;
        match records.iter_mut().find(|known| known.is_same_case(&record)) {
            Some(known) => *known = record,
            None => records.push(record),
        }
    }
    Ok((records, whole))
}
