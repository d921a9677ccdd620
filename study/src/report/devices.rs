//! Which devices records are of.

use crate::record::Record;

/// Devices in the order of their records.
pub fn devices<'a>(records: &[&'a Record]) -> Vec<&'a str> {
    let mut all: Vec<&str> = Vec::new();
    for record in records {
        if !all.contains(&record.machine.device.as_str()) {
            all.push(&record.machine.device);
        }
    }
    all
}
