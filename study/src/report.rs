//! The report: one self-contained page.
//!
//! *Practice.* The report is a function of records and images. Its text is derived from them as well
//! ([`crate::claims`], and [`sentences`]), so other records produce other text.

mod devices;
mod page;
mod plot;
mod plots;
mod sections;
mod sentences;
mod source;
mod table;
mod times;

pub(crate) use sections::is_shown;

use crate::claims;
use crate::record::{Machine, Record, Store};
use anyhow::Context;
use source::StoredRecord;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Writes a page from records, which may come from several machines.
///
/// # Errors
/// If a path contains no records, or the page cannot be written.
pub fn report(places: &[PathBuf], out: &Path) -> anyhow::Result<()> {
    save(&page::page(&read(places, out)?), out)
}

/// Reads the records of several paths, none of which may be the output.
fn read(places: &[PathBuf], out: &Path) -> anyhow::Result<Vec<StoredRecord>> {
    let mut all: Vec<StoredRecord> = Vec::new();
    for place in places {
        let file = Store::file_of(place);
        let is_same = |p: &Path| {
            let [a, b] = [p, out].map(Path::canonicalize);
            a.is_ok_and(|a| b.is_ok_and(|b| a == b))
        };
        anyhow::ensure!(
            !is_same(&file),
            "{}: contains the records: choose another path",
            out.display()
        );
        for record in Store::read(place)? {
            // A folder that is given twice is read once.
            if all.iter().all(|known| known.record != record) {
                let pictures = Store::pictures_of(place);
                all.push(StoredRecord {
                    record,
                    pictures,
                    lost_times: false,
                });
            }
        }
    }
    anyhow::ensure!(
        !out.exists() || out.is_file(),
        "{}: not a regular file: choose another path",
        out.display()
    );
    tell_apart(&mut all);
    times::drop_unfair_times(&mut all);
    Ok(all)
}

/// Gives devices of different machines, presets or devices different names, because every CPU is called `cpu`.
fn tell_apart(all: &mut [StoredRecord]) {
    type Key = [String; 3];
    let key = |m: &Machine| [&m.processor, &m.system, &m.preset].map(String::clone);
    let mut places: BTreeMap<String, Vec<Key>> = BTreeMap::new();
    for source in all.iter() {
        let m = &source.record.machine;
        places.entry(m.device.clone()).or_default().push(key(m));
    }
    for source in all {
        let m = &mut source.record.machine;
        let parts_of_key = key(m);
        let keys = places.get(&m.device).map_or(&[][..], Vec::as_slice);
        let differs = |&i: &usize| keys.iter().any(|k| k[i] != parts_of_key[i]);
        let parts: Vec<&str> = (0..3)
            .filter(differs)
            .map(|i| parts_of_key[i].as_str())
            .collect();
        if !parts.is_empty() {
            m.device = format!("{} ({})", m.device, parts.join(", "));
        }
    }
}

/// Writes text to a file, atomically.
fn save(text: &str, out: &Path) -> anyhow::Result<()> {
    if let Some(folder) = out.parent().filter(|p| !p.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let mut name = out
        .file_name()
        .context("the output path has no file name")?
        .to_owned();
    name.push(".part");
    let beside = out.with_file_name(name);
    std::fs::write(&beside, text).with_context(|| beside.display().to_string())?;
    std::fs::rename(&beside, out).with_context(|| out.display().to_string())?;
    Ok(())
}

/// Writes the findings as Markdown: questions, results, and verdicts on claims.
///
/// # Errors
/// If a path contains no records, or the page cannot be written.
pub fn findings(places: &[PathBuf], out: &Path) -> anyhow::Result<()> {
    let all = read(places, out)?;
    let mut text = String::from(
        "# Findings of the study\n\n`argil study findings` generated this page from the records in `study/records`.\n",
    );
    let borrowed: Vec<&Record> = all.iter().map(|source| &source.record).collect();
    for line in page::machines(&borrowed) {
        text += &format!("\n* {line}");
    }
    text += "\n";
    for note in times::notes(&all) {
        text += &format!("\n{note}\n");
    }
    text += &claims_of(&borrowed);
    for experiment in crate::experiments::ALL {
        let of_experiment: Vec<&Record> = borrowed
            .iter()
            .copied()
            .filter(|r| r.experiment == experiment.name)
            .collect();
        if of_experiment.is_empty() {
            continue;
        }
        text += &format!(
            "\n## {}\n\n{}\n\n*In the study:* {}\n",
            experiment.title, experiment.question, experiment.study
        );
        for sentence in sentences::sentences(experiment.name, &of_experiment) {
            text += &format!("\n* {sentence}");
        }
        text += "\n";
    }
    save(&text, out)
}

/// Returns the verdicts on claims: a row per claim and device.
fn claims_of(records: &[&Record]) -> String {
    let mut text = String::from(
        "\n## Claims of the 2023 study\n\nEach device is judged by its own records. Times are compared if they were measured in one sitting at one clock. Records of a CPU or a software GPU from before sittings were measured one after another.\n\n| section | claim | device | our records |\n| --- | --- | --- | --- |\n",
    );
    for claim in claims::ALL {
        let verdicts = claims::verdicts(claim, records);
        let claimed = claims::with_reason(claim, &verdicts);
        if verdicts.is_empty() {
            text += &format!("| {} | {claimed} | | not measured |\n", claim.place);
        }
        for (i, verdict) in verdicts.iter().enumerate() {
            let (place, claimed) = if i == 0 {
                (claim.place, claimed.as_str())
            } else {
                ("", "")
            };
            text += &format!(
                "| {place} | {claimed} | {} | **{}**: {} |\n",
                verdict.device,
                verdict.verdict.word(),
                verdict.reason
            );
        }
    }
    text
}
