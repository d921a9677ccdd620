//! Records of two versions of Argil, compared case by case.

use crate::clock_range::MAX_CLOCK_RATIO;
use crate::formatting::{counted, number};
use crate::record::{Record, Store};
use std::path::Path;

/// The times that are compared, in the order of the table.
const TIMES: [&str; 5] = ["build_ms", "frame_ms", "edit_ms", "mesh_ms", "first_ms"];

/// Returns a Markdown table of each case's times in two folders, with their ratios. A case is left out if the clocks of the
/// GPU differ by more than 3 %, and the last line says how many were.
///
/// # Errors
/// If a folder has no records, or they have no case in common.
pub fn compare(before: &Path, after: &Path) -> anyhow::Result<String> {
    let [old, new] = [Store::read(before)?, Store::read(after)?];
    let text = table(&old, &new);
    anyhow::ensure!(
        text.is_some(),
        "{} and {}: no case was timed in both, on the same device and with the same preset",
        before.display(),
        after.display()
    );
    Ok(text.unwrap_or_default())
}

fn is_same(a: &Record, b: &Record) -> bool {
    let key = |r: &Record| {
        let m = &r.machine;
        let machine = [&m.device, &m.processor, &m.preset].map(String::clone);
        (r.experiment.clone(), r.case.clone(), machine)
    };
    key(a) == key(b) && a.error.is_none() && b.error.is_none()
}

fn table(old: &[Record], new: &[Record]) -> Option<String> {
    let mut rows = String::new();
    let mut ratios = Vec::new();
    let mut left_out = 0;
    let pairs = new
        .iter()
        .filter_map(|b| Some((old.iter().find(|a| is_same(a, b))?, b)));
    for (a, b) in pairs {
        for name in TIMES {
            let Some((before, after)) = a.value(name).zip(b.value(name)) else {
                continue;
            };
            let clocks = [a, b].map(|r| r.value("gpu_clock_mhz"));
            let is_fair = match clocks {
                [Some(a), Some(b)] => a.max(b) <= a.min(b) * MAX_CLOCK_RATIO,
                [None, None] => true,
                _ => false,
            };
            if !is_fair || after <= 0.0 {
                left_out += 1;
                continue;
            }
            ratios.push(before / after);
            rows += &format!(
                "| {} | {} | {} | {} | {} | {} |\n",
                a.experiment,
                a.case,
                name.trim_end_matches("_ms"),
                number(before),
                number(after),
                number(before / after)
            );
        }
    }
    if ratios.is_empty() && left_out == 0 {
        return None;
    }
    let mut text = String::from(
        "| experiment | case | time of | before, ms | after, ms | before / after |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    text += &rows;
    text += &format!("\n{} compared", counted(ratios.len(), "time"));
    if let Some(median) = crate::record::median(&ratios) {
        text += &format!("; the median ratio is {}", number(median));
    }
    if left_out > 0 {
        text += &format!(
            "; {} left out: the clocks of the GPU differ by more than 3 %",
            counted(left_out, "time")
        );
    }
    text += ".\n";
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(case: &str, ms: f64, clock: Option<f64>) -> Record {
        let mut record = Record {
            experiment: "frames".into(),
            case: case.into(),
            ..Record::default()
        };
        record.samples.insert("frame_ms".into(), vec![ms]);
        if let Some(clock) = clock {
            record.values.insert("gpu_clock_mhz".into(), clock);
        }
        record
    }

    #[test]
    fn cases_at_one_clock_are_compared() {
        let old = [
            record("a", 3.0, Some(1980.0)),
            record("b", 3.0, Some(1980.0)),
            record("c", 3.0, Some(1980.0)),
            record("d", 3.0, None),
        ];
        let new = [
            record("a", 2.0, Some(1960.0)),
            record("b", 2.0, Some(345.0)),
            record("c", 2.0, None),
            record("e", 2.0, None),
        ];
        let text = table(&old, &new).expect("a table");
        assert!(
            text.contains("| frames | a | frame | 3 | 2 | 1.50 |"),
            "{text}"
        );
        assert!(text.contains("1 time compared; the median ratio is 1.50; 2 times left out"));
        // Cases of one folder alone are not compared.
        assert_eq!(table(&old[3..], &new[3..]), None);
        let mut other = new[0].clone();
        other.machine.device = "another".into();
        assert_eq!(table(&old, &[other]), None);
    }
}
