//! The range of a GPU's clock while a case was measured.

use crate::clock::ClockReading;
use std::time::{Duration, Instant};

/// The largest ratio of the clocks of two cases that are compared.
pub(crate) const MAX_CLOCK_RATIO: f64 = 1.03;

/// How old the last reading may be where no reading falls into an interval.
const MAX_AGE: Duration = Duration::from_millis(300);

/// A reading with its time.
pub(crate) type Stamped = (Instant, ClockReading);

/// A time interval.
pub(crate) type Interval = (Instant, Instant);

/// Tells the clock of a device at earlier times.
pub(crate) trait ClockMeter {
    /// Returns the range of the clock in intervals. `None` if it is unknown.
    fn range(&self, intervals: &[Interval]) -> Option<ClockRange>;

    /// Returns true if the clock no longer rises. `None` if it is unknown.
    fn has_settled(&self, since: Instant) -> Option<bool>;

    /// Returns the reason why the clock is unknown.
    fn unknown_because(&self) -> Option<&str>;
}

/// The range of a clock in MHz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClockRange {
    /// The lowest.
    pub min: f64,
    /// The median.
    pub median: f64,
    /// The highest.
    pub max: f64,
    /// The highest clock of the device, if it says so.
    pub limit: Option<f64>,
}

impl ClockRange {
    /// Returns the range of the readings in intervals. An interval without a reading takes the last one before its end,
    /// unless that is too old. Returns `None` if there is no reading.
    pub(crate) fn within(readings: &[Stamped], intervals: &[Interval]) -> Option<Self> {
        let mut clocks = Vec::new();
        let mut limit = None;
        for (start, end) in intervals {
            let until = readings.partition_point(|(at, _)| at <= end);
            let from = readings.partition_point(|(at, _)| at < start).min(until);
            let last = until.saturating_sub(1)..until;
            let range = if from < until { from..until } else { last };
            for (at, reading) in &readings[range] {
                if end.saturating_duration_since(*at) <= MAX_AGE || at >= start {
                    clocks.push(reading.mhz);
                    limit = reading.limit_mhz.or(limit);
                }
            }
        }
        Some(Self {
            min: clocks.iter().copied().reduce(f64::min)?,
            median: crate::record::median(&clocks)?,
            max: clocks.iter().copied().reduce(f64::max)?,
            limit,
        })
    }
}

/// Returns true if all medians are within [`MAX_CLOCK_RATIO`]. Unknown clocks agree with all.
pub(crate) fn agree(ranges: &[Option<ClockRange>]) -> bool {
    let medians = ranges.iter().flatten().map(|range| range.median);
    let (low, high) = medians.fold((f64::INFINITY, 0.0f64), |(low, high), clock| {
        (low.min(clock), high.max(clock))
    });
    high <= low * MAX_CLOCK_RATIO
}

/// Returns true if the readings since a time no longer rise: the last third is at most 1 % above the others.
pub(crate) fn has_settled(readings: &[Stamped], since: Instant) -> bool {
    let values: Vec<f64> = readings
        .iter()
        .filter(|(at, _)| *at >= since)
        .map(|(_, reading)| reading.mhz)
        .collect();
    if values.len() < 6 {
        return false;
    }
    let (before, last) = values.split_at(values.len() - values.len() / 3);
    let highest = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    highest(last) <= 1.01 * highest(before)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns readings at times in milliseconds.
    fn readings(start: Instant, all: &[(u64, f64)]) -> Vec<Stamped> {
        let stamped = |&(ms, mhz): &(u64, f64)| {
            let reading = ClockReading {
                mhz,
                limit_mhz: Some(1980.0),
            };
            (start + Duration::from_millis(ms), reading)
        };
        all.iter().map(stamped).collect()
    }

    fn range(median: f64) -> Option<ClockRange> {
        Some(ClockRange {
            min: median,
            median,
            max: median,
            limit: None,
        })
    }

    #[test]
    fn only_readings_of_the_intervals_count() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let all = readings(
            start,
            &[
                (0, 345.0),
                (50, 1000.0),
                (100, 1980.0),
                (150, 1900.0),
                (200, 345.0),
            ],
        );
        let found = ClockRange::within(&all, &[(at(90), at(160))]).expect("a range");
        assert_eq!(
            (found.min, found.median, found.max),
            (1900.0, 1940.0, 1980.0)
        );
        assert_eq!(found.limit, Some(1980.0));
        // A short interval takes the reading before it, and not the one after it.
        let found = ClockRange::within(&all, &[(at(110), at(120))]).expect("a range");
        assert_eq!((found.min, found.max), (1980.0, 1980.0));
        // A reading that is too old does not count, and neither does a later one.
        assert_eq!(ClockRange::within(&all, &[(at(900), at(901))]), None);
        assert_eq!(ClockRange::within(&all[1..], &[(at(10), at(20))]), None);
        assert_eq!(ClockRange::within(&[], &[(at(10), at(20))]), None);
    }

    #[test]
    fn clocks_agree_within_three_percent() {
        assert!(agree(&[range(1980.0), range(1930.0), None]));
        assert!(!agree(&[range(1980.0), range(1900.0), None]));
        assert!(agree(&[None, None]));
        assert!(agree(&[]));
    }

    #[test]
    fn rising_clocks_have_not_settled() {
        let start = Instant::now();
        let rising: Vec<(u64, f64)> = (0..9).map(|i| (50 * i, 345.0 + 150.0 * i as f64)).collect();
        assert!(!has_settled(&readings(start, &rising), start));
        let mut level = rising;
        level.extend((9..24).map(|i| (50 * i, 1545.0)));
        let all = readings(start, &level);
        assert!(has_settled(&all, start));
        // Too few readings say nothing.
        assert!(!has_settled(&all, start + Duration::from_millis(50 * 20)));
    }
}
