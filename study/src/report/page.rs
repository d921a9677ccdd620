//! The page.

use super::source::StoredRecord;
use super::table::study_command;
use super::{plots, sections, sentences, times};
use crate::claims;
use crate::experiments::ALL;
use crate::formatting::escaped;
use crate::record::Record;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use std::io::Cursor;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Returns the clocks of a GPU while its cases were measured.
fn clocks(records: &[&Record], device: &str) -> String {
    let of_device: Vec<&&Record> = records
        .iter()
        .filter(|r| r.machine.device == device)
        .collect();
    let all = |name: &'static str| of_device.iter().filter_map(move |r| r.value(name));
    let least = all("gpu_clock_min_mhz").reduce(f64::min);
    let most = all("gpu_clock_max_mhz").reduce(f64::max);
    let Some((least, most)) = least.zip(most) else {
        return String::new();
    };
    let limit = all("gpu_clock_limit_mhz").reduce(f64::max);
    let limit = limit.map_or(String::new(), |limit| format!(" of {limit}"));
    format!(", {least} to {most}{limit} MHz while measured")
}

/// Describes each machine and device in a line.
pub(super) fn machines(records: &[&Record]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for record in records {
        let m = &record.machine;
        let device = if m.driver.is_empty() {
            format!(
                "{}: {} threads of {} at {} MHz",
                m.device, m.threads, m.processor, m.clock_mhz
            )
        } else {
            let clocks = clocks(records, &m.device);
            format!(
                "{} ({}{clocks}), on a host with {}",
                m.device, m.driver, m.processor
            )
        };
        let line = format!(
            "{device}; {}; Argil {} at {}, preset {}",
            m.system, m.version, m.commit, m.preset
        );
        if !all.contains(&line) {
            all.push(line);
        }
    }
    all
}

/// Returns the page.
pub(super) fn page(all: &[StoredRecord]) -> String {
    let records: Vec<&Record> = all.iter().map(|source| &source.record).collect();
    let devices = {
        let mut all: Vec<&str> = records.iter().map(|r| r.machine.device.as_str()).collect();
        all.sort_unstable();
        all.dedup();
        all.len()
    };
    let mut text = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>Argil: the study</title><style>{STYLE}</style></head><body><main><h1>Sparse signed distance fields: building, editing, rendering</h1><p>How do sparse structures for signed distance fields change the time to build, edit and render a world, and the error of its images? A 2023 study asked this. This report repeats its measurements, and adds those that it left out.</p>"
    );
    text += "<ul>";
    for line in machines(&records) {
        text += &format!("<li>{}</li>", escaped(&line));
    }
    text += "</ul>";
    for note in times::notes(all) {
        text += &format!("<p>{}</p>", escaped(&note));
    }
    text += "<nav><a href=\"#claims\">Claims</a>";
    let has = |name: &str| records.iter().any(|r| r.experiment == name);
    for experiment in ALL.iter().filter(|e| has(e.name)) {
        text += &format!(
            " <a href=\"#{}\">{}</a>",
            experiment.name,
            escaped(experiment.title)
        );
    }
    text += "</nav><section id=\"claims\"><h2>Claims of the 2023 study</h2><div class=\"wide\"><table class=\"claims\"><thead><tr><th>section</th><th>claim</th><th>device</th><th>verdict</th><th>our records</th></tr></thead><tbody>";
    for claim in claims::ALL {
        text += &claim_rows(claim, &records);
    }
    text += "</tbody></table></div></section>";
    for experiment in ALL {
        let of_experiment: Vec<&StoredRecord> = all
            .iter()
            .filter(|source| source.record.experiment == experiment.name)
            .collect();
        if of_experiment.is_empty() {
            continue;
        }
        let rows: Vec<&Record> = of_experiment.iter().map(|source| &source.record).collect();
        text += &format!(
            "<section id=\"{}\"><h2>{}</h2><p class=\"question\">{}</p><p><b>In the study:</b> {}</p>",
            experiment.name,
            escaped(experiment.title),
            escaped(experiment.question),
            escaped(experiment.study)
        );
        for sentence in sentences::sentences(experiment.name, &rows) {
            text += &format!("<p><b>Measured:</b> {}</p>", escaped(&sentence));
        }
        for plot in plots::plots(experiment.name, &rows) {
            text += &format!(
                "<figure class=\"plot\">{plot}<figcaption class=\"command\">created by <code>argil study --only {}</code></figcaption></figure>",
                experiment.name
            );
        }
        let shown = sections::pictures(experiment.name, &of_experiment);
        if !shown.is_empty() {
            text += "<div class=\"pictures\">";
            for one in &shown {
                text += &picture(one);
            }
            text += "</div>";
        }
        text += &format!(
            "<details><summary>All rows ({})</summary>{}</details></section>",
            rows.len(),
            sections::table_of(experiment.name, &rows, devices > 1)
        );
    }
    text += &format!("</main><script>{SCRIPT}</script></body></html>\n");
    text
}

/// Returns the rows of a claim: a row per device.
fn claim_rows(claim: &claims::Claim, records: &[&Record]) -> String {
    let verdicts = claims::verdicts(claim, records);
    let first = format!(
        "<td rowspan=\"{rows}\">{}</td><td rowspan=\"{rows}\">{}</td>",
        claim.place,
        escaped(&claims::with_reason(claim, &verdicts)),
        rows = verdicts.len().max(1)
    );
    if verdicts.is_empty() {
        return format!("<tr>{first}<td></td><td></td><td>not measured</td></tr>");
    }
    let row = |(i, verdict): (usize, &claims::DeviceVerdict)| {
        format!(
            "<tr>{}<td>{}</td><td class=\"{word}\">{word}</td><td>{}</td></tr>",
            if i == 0 { first.as_str() } else { "" },
            escaped(&verdict.device),
            escaped(&verdict.reason),
            word = verdict.verdict.word()
        )
    };
    verdicts.iter().enumerate().map(row).collect()
}

/// Returns an image of the page, or the reason why it is missing.
fn picture(shown: &sections::Figure<'_>) -> String {
    let record = &shown.source.record;
    let caption = format!(
        "{}{}",
        escaped(&shown.text),
        if record.machine.device == "cpu" {
            String::new()
        } else {
            format!(" ({})", escaped(&record.machine.device))
        }
    );
    let usual = study_command(record);
    let command = record.command.as_deref().unwrap_or(&usual);
    let place = record
        .pictures
        .get(shown.name)
        .map(|file| shown.source.pictures.join(file));
    let encoded = place.and_then(|place| {
        let picture = image::open(place).ok()?.to_rgb8();
        let small = crate::formatting::shown(&picture);
        let mut bytes = Cursor::new(Vec::new());
        small.write_to(&mut bytes, image::ImageFormat::Png).ok()?;
        Some(STANDARD.encode(bytes.into_inner()))
    });
    match encoded {
        Some(data) => format!(
            "<figure><img loading=\"lazy\" alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}<details class=\"command\"><summary>created by</summary><code>{}</code></details></figcaption></figure>",
            escaped(command)
        ),
        None => format!(
            "<figure><figcaption>{caption}: the image file is missing</figcaption></figure>"
        ),
    }
}
