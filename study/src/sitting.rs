//! Cases that are compared, measured in one sitting.
//!
//! *Theory.* Times compare only if both were taken at one clock. So all cases of a group are prepared first. Then the GPU
//! is warmed up, and the cases take turns: a sample of each, round by round, in alternating order. If the clocks of two
//! cases differ by more than 3 %, all samples are taken again, at most twice.

use crate::clock_range::{ClockRange, Interval, agree};
use crate::experiment::StudyCase;
use crate::outcome::Outcome;
use crate::prepared::{PreparedCase, Setup};
use crate::record::Sitting;
use crate::warm_up::Awake;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How often samples are taken, at most, until clocks agree.
const ATTEMPTS: u32 = 3;

/// The estimated memory of cases that are kept at the same time, at most.
const MAX_BYTES: u64 = 4 << 30;

/// How long a sitting may last.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TimeLimit {
    /// How long samples are taken. Each case gets at least one.
    pub sampling: Option<Duration>,
    /// When to stop taking samples.
    pub deadline: Option<Instant>,
}

/// What a sitting found out about a case.
pub(crate) struct SittingResult {
    /// The results, with the clock of the GPU.
    pub outcome: anyhow::Result<Outcome>,
    /// How the samples were taken.
    pub sitting: Sitting,
    /// The time that the case took, in seconds.
    pub seconds: f64,
}

/// A case of a sitting.
struct Seat<'a> {
    prepared: Option<PreparedCase<'a>>,
    error: Option<anyhow::Error>,
    intervals: Vec<Interval>,
    time: Duration,
}

impl<'a> Seat<'a> {
    fn new(case: &'a StudyCase, setup: Setup<'a>) -> Self {
        let start = Instant::now();
        let (prepared, error) = match guarded(|| PreparedCase::prepare(case, setup)) {
            Ok(prepared) => (Some(prepared), None),
            Err(error) => (None, Some(error)),
        };
        Self {
            prepared,
            error,
            intervals: Vec::new(),
            time: start.elapsed(),
        }
    }

    /// Does something with the case. An error ends the case, and not the sitting.
    fn with(&mut self, run: impl FnOnce(&mut PreparedCase<'a>) -> anyhow::Result<()>) {
        let Some(prepared) = &mut self.prepared else {
            return;
        };
        let start = Instant::now();
        if let Err(error) = guarded(|| run(prepared)) {
            self.error = Some(error);
            self.prepared = None;
        }
        self.time += start.elapsed();
    }

    fn rounds(&self) -> usize {
        self.prepared.as_ref().map_or(0, PreparedCase::rounds)
    }
}

/// Calls a function. A panic becomes an error, so that it ends one case only.
fn guarded<T>(run: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
    catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        Err(anyhow::anyhow!(
            "internal error: {}",
            text.unwrap_or_default()
        ))
    })
}

/// Measures a group of cases in one sitting, and alone what cannot take part in it. Returns a result per case, or `None` if
/// there was no time to prepare it. Half of the time that is left is for preparation.
pub(crate) fn sit(
    cases: &[&StudyCase],
    setup: Setup<'_>,
    awake: &Awake,
    limit: TimeLimit,
) -> Vec<Option<SittingResult>> {
    let start = Instant::now();
    let is_late = || {
        let left = |deadline: Instant| deadline.saturating_duration_since(start);
        limit
            .deadline
            .is_some_and(|deadline| start.elapsed() >= left(deadline) / 2)
    };
    let mut results: Vec<Option<SittingResult>> = cases.iter().map(|_| None).collect();
    let mut alone: Vec<(usize, String)> = Vec::new();
    let mut seats: Vec<(usize, Seat<'_>)> = Vec::new();
    let mut bytes = 0;
    for (i, case) in cases.iter().enumerate() {
        if is_late() {
            break;
        }
        let needed = case.way.estimated_bytes();
        if bytes > 0 && bytes + needed > MAX_BYTES {
            let limit = MAX_BYTES >> 30;
            alone.push((i, format!("the group needs more than {limit} GiB")));
            continue;
        }
        let mut seat = Seat::new(case, setup);
        match seat.error.take() {
            Some(error) if cases.len() > 1 => {
                alone.push((
                    i,
                    format!("it could not be prepared with others: {error:#}"),
                ));
            }
            error => {
                seat.error = error;
                bytes += needed;
                seats.push((i, seat));
            }
        }
    }
    take_turns(seats, awake, limit, &mut results);
    for (i, reason) in alone {
        if is_late() {
            break;
        }
        let seat = Seat::new(cases[i], setup);
        take_turns(vec![(i, seat)], awake, limit, &mut results);
        if let Some(result) = &mut results[i] {
            result.sitting.alone_because = Some(reason);
        }
    }
    results
}

/// Takes the samples of cases in turns, until their clocks agree.
fn take_turns(
    mut seats: Vec<(usize, Seat<'_>)>,
    awake: &Awake,
    limit: TimeLimit,
    results: &mut [Option<SittingResult>],
) {
    let mut sitting = Sitting {
        id: SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |time| time.as_micros() as u64),
        cases: seats.len(),
        ..Sitting::default()
    };
    let mut clocks: Vec<Option<ClockRange>> = Vec::new();
    for attempt in 1..=ATTEMPTS {
        if attempt > 1 {
            for (_, seat) in &mut seats {
                seat.intervals.clear();
                seat.with(PreparedCase::restart);
            }
        }
        sitting.attempts = attempt;
        if seats.iter().any(|(_, seat)| seat.rounds() > 0) {
            rounds(&mut seats, awake, limit);
        }
        let range = |(_, seat): &(usize, Seat<'_>)| awake.clocks(&seat.intervals);
        clocks = seats.iter().map(range).collect();
        let is_late = limit.deadline.is_some_and(|at| Instant::now() >= at);
        if agree(&clocks) || is_late {
            break;
        }
    }
    for ((i, seat), clock) in seats.into_iter().zip(clocks) {
        let start = Instant::now();
        let outcome = match (seat.prepared, seat.error) {
            (Some(prepared), _) => guarded(|| prepared.finish()),
            (None, Some(error)) => Err(error),
            (None, None) => Err(anyhow::anyhow!("the case was not prepared")),
        };
        let outcome = outcome.map(|mut outcome| {
            if let Some(range) = clock {
                outcome.clocks(range);
            }
            outcome
        });
        results[i] = Some(SittingResult {
            outcome,
            sitting: sitting.clone(),
            seconds: (seat.time + start.elapsed()).as_secs_f64(),
        });
    }
}

/// Warms up, and takes all samples.
fn rounds(seats: &mut [(usize, Seat<'_>)], awake: &Awake, limit: TimeLimit) {
    // The next sample shows if the device has failed.
    let _ = awake.warm_up();
    let start = Instant::now();
    let most = seats.iter().map(|(_, seat)| seat.rounds()).max();
    let most = most.unwrap_or(0);
    for round in 0..most {
        let is_over = limit.sampling.is_some_and(|most| start.elapsed() > most)
            || limit.deadline.is_some_and(|at| Instant::now() >= at);
        let mut order: Vec<usize> = (0..seats.len()).collect();
        if round % 2 == 1 {
            order.reverse();
        }
        for i in order {
            let (_, seat) = &mut seats[i];
            let Some(sample) = turn(round, most, seat.rounds()) else {
                continue;
            };
            if is_over && sample > 0 {
                continue;
            }
            let from = Instant::now();
            seat.with(|prepared| {
                awake.burst()?;
                prepared.sample(sample)
            });
            let to = Instant::now();
            let end = seat.prepared.as_ref().and_then(PreparedCase::timed_end);
            let from = end.and_then(|end| to.checked_sub(end)).unwrap_or(from);
            seat.intervals.push((from, to));
        }
    }
}

/// Returns which of a case's samples is taken in a round, so that few samples are spread over all rounds.
fn turn(round: usize, rounds: usize, of_seat: usize) -> Option<usize> {
    let before = (round * of_seat).div_ceil(rounds.max(1));
    let after = ((round + 1) * of_seat).div_ceil(rounds.max(1));
    (after > before).then_some(before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock_range::ClockMeter;
    use crate::configuration::{BRICKS, Configuration, DENSE};
    use crate::plan::Plan;
    use crate::task::Task;
    use std::cell::RefCell;
    use std::rc::Rc;

    /// A clock whose readings are given, and which stores the intervals that it is asked for.
    #[derive(Clone)]
    struct GivenClock {
        mhz: Rc<RefCell<Vec<f64>>>,
        asked: Rc<RefCell<Vec<Vec<Interval>>>>,
    }

    impl ClockMeter for GivenClock {
        fn range(&self, intervals: &[Interval]) -> Option<ClockRange> {
            self.asked.borrow_mut().push(intervals.to_vec());
            let mhz = self.mhz.borrow_mut().pop()?;
            Some(ClockRange {
                min: mhz,
                median: mhz,
                max: mhz,
                limit: None,
            })
        }

        fn has_settled(&self, _: Instant) -> Option<bool> {
            None
        }

        fn unknown_because(&self) -> Option<&str> {
            None
        }
    }

    /// Measures two cases with clocks, a pair per attempt.
    fn sat(clocks: &[f64]) -> (Vec<SittingResult>, GivenClock) {
        let clock = GivenClock {
            mhz: Rc::new(RefCell::new(clocks.iter().rev().copied().collect())),
            asked: Rc::default(),
        };
        let engine = argil::Engine::cpu();
        let plan = Plan::default();
        let setup = Setup {
            engine: &engine,
            plan: &plan,
            peer: None,
        };
        let cases = [DENSE, BRICKS]
            .map(|kind| StudyCase::new("brick", Configuration::of(kind, 16), Task::Build(3)));
        let cases: Vec<&StudyCase> = cases.iter().collect();
        let awake = Awake::with_clock(clock.clone());
        let results = sit(&cases, setup, &awake, TimeLimit::default());
        (results.into_iter().flatten().collect(), clock)
    }

    fn clock_of(result: &SittingResult) -> Option<f64> {
        let outcome = result.outcome.as_ref().expect("an outcome");
        assert_eq!(outcome.samples["build_ms"].len(), 3);
        outcome.values.get("gpu_clock_mhz").copied()
    }

    #[test]
    fn compared_cases_take_turns() {
        let (results, clock) = sat(&[1980.0, 1950.0]);
        assert_eq!(results[0].sitting, results[1].sitting);
        let sitting = &results[0].sitting;
        assert_eq!((sitting.cases, sitting.attempts), (2, 1));
        let asked = clock.asked.borrow();
        let [a, b] = [&asked[0], &asked[1]];
        assert_eq!((a.len(), b.len()), (3, 3));
        // A B, B A, A B: a round ends before the next begins.
        for round in 0..2 {
            let ends = [a, b].map(|spans| spans[round].1);
            let starts = [a, b].map(|spans| spans[round + 1].0);
            assert!(
                ends.iter()
                    .all(|end| starts.iter().all(|start| end <= start))
            );
        }
        assert!(a[0].1 <= b[0].0 && b[1].1 <= a[1].0);
    }

    #[test]
    fn samples_are_taken_again_until_clocks_agree() {
        let (results, _) = sat(&[1980.0, 345.0, 1980.0, 1980.0]);
        assert_eq!(results[0].sitting.attempts, 2);
        assert_eq!(clock_of(&results[1]), Some(1980.0));
        // They may never agree. Then records tell so.
        let (results, _) = sat(&[1980.0, 345.0].repeat(9));
        assert_eq!(results[0].sitting.attempts, ATTEMPTS);
        assert_eq!(clock_of(&results[0]), Some(1980.0));
        assert_eq!(clock_of(&results[1]), Some(345.0));
        // Unknown clocks are not judged.
        let (results, _) = sat(&[]);
        assert_eq!(results[0].sitting.attempts, 1);
        assert_eq!(clock_of(&results[0]), None);
    }

    #[test]
    fn cases_that_do_not_fit_are_measured_alone() {
        let engine = argil::Engine::cpu();
        let plan = Plan::default();
        let setup = Setup {
            engine: &engine,
            plan: &plan,
            peer: None,
        };
        let build = |scene: &str| {
            let way = Configuration::of(BRICKS, 16);
            StudyCase::new(scene, way, Task::Build(1))
        };
        let cases = ["brick", "no such scene", "brick"].map(build);
        let cases: Vec<&StudyCase> = cases.iter().collect();
        let limit = TimeLimit::default();
        let results = sit(&cases, setup, &Awake::idle(), limit);
        let results: Vec<SittingResult> = results.into_iter().flatten().collect();
        let ids: Vec<u64> = results.iter().map(|result| result.sitting.id).collect();
        assert!(ids[0] == ids[2] && ids[0] != ids[1]);
        assert_eq!(results[0].sitting.alone_because, None);
        let reason = results[1].sitting.alone_because.clone();
        assert!(reason.is_some_and(|reason| reason.contains("no such scene")));
        assert!(results[1].outcome.is_err() && results[2].outcome.is_ok());
        // Without time, nothing is prepared.
        let limit = TimeLimit {
            deadline: Some(Instant::now()),
            ..limit
        };
        let results = sit(&cases, setup, &Awake::idle(), limit);
        assert!(results.len() == 3 && results.iter().all(Option::is_none));
    }

    #[test]
    fn few_samples_are_spread_over_all_rounds() {
        let all = |rounds, of_seat| -> Vec<usize> {
            let taken = (0..rounds).filter(|&round| turn(round, rounds, of_seat).is_some());
            taken.collect()
        };
        assert_eq!(all(4, 4), [0, 1, 2, 3]);
        assert_eq!(all(12, 3), [0, 4, 8]);
        assert_eq!(all(12, 0), Vec::<usize>::new());
        for (rounds, of_seat) in [(40, 7), (5, 5), (9, 2), (3, 1)] {
            let found: Vec<usize> = (0..rounds)
                .filter_map(|r| turn(r, rounds, of_seat))
                .collect();
            assert_eq!(found, (0..of_seat).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_panic_is_an_error() {
        let error = guarded::<()>(|| panic!("no room")).expect_err("a panic");
        assert!(format!("{error}").contains("no room"));
    }
}
