//! Times that tell nothing, because the GPU's clock was asleep or unknown.

use super::devices::devices;
use super::source::StoredRecord;
use crate::formatting::counted;
use crate::record::Record;

/// The part of a GPU's highest clock below which it counts as asleep.
const AWAKE: f64 = 0.5;

/// Returns true if the times of a record count. For a hardware GPU, they need a sitting, in which it was kept awake. If
/// its clock is known, it must be above half of the highest.
fn has_fair_times(record: &Record) -> bool {
    if !record.machine.is_hardware_gpu() {
        return true;
    }
    let clock = record.value("gpu_clock_mhz");
    let limit = record.value("gpu_clock_limit_mhz");
    let is_asleep = clock
        .zip(limit)
        .is_some_and(|(mhz, limit)| mhz < AWAKE * limit);
    record.sitting.is_some() && !is_asleep
}

fn is_time(name: &str) -> bool {
    name.ends_with("_ms")
}

fn has_times(record: &Record) -> bool {
    record
        .samples
        .keys()
        .chain(record.values.keys())
        .any(|name| is_time(name))
}

/// Drops the times that do not count.
pub(super) fn drop_unfair_times(all: &mut [StoredRecord]) {
    for source in all {
        let record = &mut source.record;
        if !has_fair_times(record) && has_times(record) {
            record.samples.retain(|name, _| !is_time(name));
            record.values.retain(|name, _| !is_time(name));
            source.lost_times = true;
        }
    }
}

/// Says which times are missing.
pub(super) fn notes(all: &[StoredRecord]) -> Vec<String> {
    let records: Vec<&Record> = all.iter().map(|source| &source.record).collect();
    let mut notes = Vec::new();
    let mut is_any_timed = false;
    for device in devices(&records) {
        let is_own = |source: &&StoredRecord| source.record.machine.device == device;
        let of_experiment: Vec<&StoredRecord> = all.iter().filter(is_own).collect();
        let reasons = of_experiment.iter().filter_map(|source| {
            let sitting = source.record.sitting.as_ref()?;
            sitting.alone_because.as_deref()
        });
        let reasons: Vec<&str> = reasons.collect();
        if let Some(reason) = reasons.first() {
            notes.push(format!(
                "On {device}, {} measured alone. The reason of the first: {reason}.",
                if reasons.len() == 1 {
                    "1 case was".into()
                } else {
                    format!("{} cases were", reasons.len())
                }
            ));
        }
        let is_hardware = of_experiment
            .iter()
            .any(|source| source.record.machine.is_hardware_gpu());
        if !is_hardware {
            continue;
        }
        let is_timed = of_experiment.iter().any(|source| has_times(&source.record));
        is_any_timed |= is_timed;
        let lost = of_experiment
            .iter()
            .filter(|source| source.lost_times)
            .count();
        if !is_timed {
            notes.push(format!(
                "Records of {device} have no times: its clock was asleep, or not sampled while they were measured."
            ));
        } else if lost > 0 {
            notes.push(format!(
                "On {device}, {} ran below half of its highest clock. Their times are left out.",
                counted(lost, "case")
            ));
        }
    }
    if !is_any_timed {
        notes.push(
            "There is no record of a hardware GPU at full clock yet. `argil study --preset hardware` makes one."
                .into(),
        );
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Sitting;
    use std::path::PathBuf;

    fn source(device: &str, has_sitting: bool, clock: Option<f64>) -> StoredRecord {
        let mut record = Record::default();
        record.machine.device = device.into();
        if device != "cpu" {
            record.machine.driver = "some driver, vulkan".into();
        }
        record.sitting = has_sitting.then(Sitting::default);
        record.samples.insert("frame_ms".into(), vec![2.0]);
        record.samples.insert("steps_mean".into(), vec![9.0]);
        record.values.insert("gpu_clock_limit_mhz".into(), 1980.0);
        if let Some(clock) = clock {
            record.values.insert("gpu_clock_mhz".into(), clock);
        }
        StoredRecord {
            record,
            pictures: PathBuf::new(),
            lost_times: false,
        }
    }

    #[test]
    fn times_of_a_sleeping_gpu_are_dropped() {
        let gpu = "NVIDIA H100";
        let cases = [
            (source(gpu, true, Some(1980.0)), true),
            (source(gpu, true, None), true),
            (source(gpu, true, Some(345.0)), false),
            (source(gpu, false, Some(1980.0)), false),
            (source("cpu", false, None), true),
            (source("llvmpipe (LLVM 15.0.6)", false, None), true),
        ];
        for (source, expected) in cases {
            let mut all = [source];
            drop_unfair_times(&mut all);
            let record = &all[0].record;
            assert_eq!(record.value("frame_ms").is_some(), expected);
            assert_eq!(all[0].lost_times, !expected);
            assert_eq!(record.value("steps_mean"), Some(9.0));
        }
    }

    #[test]
    fn missing_times_are_named() {
        let note = |mut all: Vec<StoredRecord>| {
            drop_unfair_times(&mut all);
            notes(&all).join(" ")
        };
        let awake = || source("A", true, Some(1980.0));
        let asleep = || source("A", true, Some(345.0));
        assert_eq!(note(vec![awake(), source("cpu", false, None)]), "");
        assert!(note(vec![awake(), asleep()]).contains("On A, 1 case ran below half"));
        let text = note(vec![asleep()]);
        assert!(text.contains("Records of A have no times") && text.contains("no record of a"));
        assert!(note(vec![source("cpu", false, None)]).starts_with("There is no record of a"));
    }
}
