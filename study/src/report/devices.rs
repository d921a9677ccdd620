//! Devices of records.

use crate::record::Record;

/// Returns the devices, in the order of their records.
pub(super) fn devices<'a>(records: &[&'a Record]) -> Vec<&'a str> {
    let mut all: Vec<&str> = Vec::new();
    for record in records {
        if !all.contains(&record.machine.device.as_str()) {
            all.push(&record.machine.device);
        }
    }
    all
}

/// Returns the records without errors by device, in the order of their records.
pub(super) fn done_by_device<'a>(records: &[&'a Record]) -> Vec<(&'a str, Vec<&'a Record>)> {
    let of = |device| {
        let measured = records.iter().copied();
        measured
            .filter(|r| r.machine.device == device && r.error.is_none())
            .collect()
    };
    let all = devices(records).into_iter();
    all.map(|device| (device, of(device))).collect()
}
