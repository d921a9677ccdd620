//! Counts of what the GPU was given: submissions, waits, buffers and pipelines.

use argil::Engine;

/// Counts by name, since the engine was opened.
pub(crate) type Counts = Vec<(&'static str, u64)>;

/// Returns an engine's counts. It is empty where nothing is counted.
pub(crate) fn counts(engine: &Engine) -> Counts {
    engine.gpu_counters().map_or_else(Counts::new, |counters| {
        vec![
            ("submissions", counters.submissions),
            ("waits", counters.waits),
            ("buffers", counters.buffers),
            ("pipelines", counters.pipelines),
        ]
    })
}

/// Returns what was counted since an earlier time.
pub(crate) fn since(before: &Counts, now: &Counts) -> Counts {
    let pairs = before.iter().zip(now);
    pairs
        .map(|((name, before), (_, now))| (*name, now.saturating_sub(*before)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_since_a_time_are_differences() {
        let before = vec![("submissions", 3), ("waits", 2)];
        let now = vec![("submissions", 7), ("waits", 2)];
        assert_eq!(since(&before, &now), [("submissions", 4), ("waits", 0)]);
        assert_eq!(since(&Counts::new(), &Counts::new()), []);
    }
}
