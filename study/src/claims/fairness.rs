//! Which times are compared.

use crate::clock_range::MAX_CLOCK_RATIO;
use crate::formatting::counted;
use crate::record::Record;

/// Why the times of two records are not compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unfair {
    /// They were not measured in one sitting.
    Apart,
    /// The clocks of the GPU differ.
    Clocks,
}

/// Returns why the times of two records of a device must not be compared.
///
/// Records from before sittings were taken one after another. They are compared for devices whose clock does not depend on
/// their work.
pub(super) fn compare_times(a: &Record, b: &Record) -> Result<(), Unfair> {
    let id = |r: &Record| r.sitting.as_ref().map(|sitting| sitting.id);
    let is_hardware = a.machine.is_hardware_gpu() || b.machine.is_hardware_gpu();
    if id(a) != id(b) || (is_hardware && id(a).is_none()) {
        return Err(Unfair::Apart);
    }
    match [a, b].map(|r| r.value("gpu_clock_mhz")) {
        [Some(a), Some(b)] if a.max(b) <= a.min(b) * MAX_CLOCK_RATIO => Ok(()),
        [None, None] => Ok(()),
        _ => Err(Unfair::Clocks),
    }
}

/// Ratios of records, and how many were left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ratios {
    /// The ratios.
    pub values: Vec<f64>,
    apart: usize,
    clocks: usize,
}

impl Ratios {
    /// Adds the ratio of a value of two records, unless it is a time and the records are not compared. Adds nothing if a
    /// value is missing.
    pub(super) fn add(&mut self, value: &str, a: &Record, b: &Record) {
        if let (Some(above), Some(below)) = (a.value(value), b.value(value)) {
            self.add_ratio(value, (a, above), (b, below));
        }
    }

    /// Adds the ratio of two numbers that were derived from a value of two records.
    pub(super) fn add_ratio(
        &mut self,
        value: &str,
        (a, above): (&Record, f64),
        (b, below): (&Record, f64),
    ) {
        if below <= 0.0 {
            return;
        }
        let is_time = value.ends_with("_ms");
        match compare_times(a, b) {
            Err(Unfair::Apart) if is_time => self.apart += 1,
            Err(Unfair::Clocks) if is_time => self.clocks += 1,
            _ => self.values.push(above / below),
        }
    }

    /// Returns how many pairs were left out, and why. Empty if none was.
    pub(super) fn left_out(&self) -> String {
        let mut all = String::new();
        for (count, reason) in [
            (self.clocks, "clocks differ by more than 3 %"),
            (self.apart, "not measured in one sitting"),
        ] {
            if count > 0 {
                all += &format!("; {} left out: {reason}", counted(count, "pair"));
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Sitting;

    fn record(device: &str, id: Option<u64>, clock: Option<f64>) -> Record {
        let mut record = Record::default();
        record.machine.device = device.into();
        if device != "cpu" {
            record.machine.driver = "some driver, vulkan".into();
        }
        record.sitting = id.map(|id| Sitting {
            id,
            ..Sitting::default()
        });
        let clock = clock.map(|mhz| ("gpu_clock_mhz".to_owned(), mhz));
        record.values = clock.into_iter().collect();
        record.values.insert("frame_ms".into(), 2.0);
        record
    }

    #[test]
    fn times_of_one_sitting_and_clock_are_compared() {
        let gpu = |id, clock| record("NVIDIA H100", id, clock);
        let first = gpu(Some(1), Some(1980.0));
        let other = |record: &Record| compare_times(&first, record);
        assert_eq!(other(&gpu(Some(1), Some(1930.0))), Ok(()));
        assert_eq!(other(&gpu(Some(1), Some(1900.0))), Err(Unfair::Clocks));
        assert_eq!(other(&gpu(Some(1), None)), Err(Unfair::Clocks));
        assert_eq!(other(&gpu(Some(2), Some(1980.0))), Err(Unfair::Apart));
        assert_eq!(other(&gpu(None, Some(1980.0))), Err(Unfair::Apart));
        // A hardware GPU needs a sitting, and other devices do not.
        let old = gpu(None, None);
        assert_eq!(compare_times(&old, &old), Err(Unfair::Apart));
        for device in ["cpu", "llvmpipe (LLVM 15.0.6, 256 bits)"] {
            let old = record(device, None, None);
            assert_eq!(compare_times(&old, &old), Ok(()));
            let new = record(device, Some(1), None);
            assert_eq!(compare_times(&old, &new), Err(Unfair::Apart));
        }
    }

    #[test]
    fn pairs_that_are_left_out_are_counted() {
        let gpu = |id, clock| record("NVIDIA H100", Some(id), Some(clock));
        let mut ratios = Ratios::default();
        ratios.add("frame_ms", &gpu(1, 1980.0), &gpu(1, 1980.0));
        assert_eq!((ratios.values.len(), ratios.left_out()), (1, String::new()));
        ratios.add("frame_ms", &gpu(1, 1980.0), &gpu(1, 345.0));
        ratios.add("frame_ms", &gpu(1, 1980.0), &gpu(2, 1980.0));
        ratios.add("edit_ms", &gpu(1, 1980.0), &gpu(2, 1980.0));
        assert_eq!(ratios.values, [1.0]);
        assert_eq!(
            ratios.left_out(),
            "; 1 pair left out: clocks differ by more than 3 %; 1 pair left out: not measured in one sitting"
        );
        // What is not a time does not depend on clocks.
        ratios.add("gpu_clock_mhz", &gpu(1, 1980.0), &gpu(2, 990.0));
        assert_eq!(ratios.values, [1.0, 2.0]);
    }
}
