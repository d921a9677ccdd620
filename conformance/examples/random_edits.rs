//! Runs sessions of 20 random edits, as many as the first argument says, from the seed in the second one.
//!
//! ```sh
//! cargo run --release -p argil-conformance --example random_edits -- 50000
//! ```

use rayon::prelude::*;
use std::time::Instant;

fn main() {
    let mut numbers = std::env::args()
        .skip(1)
        .filter_map(|text| text.parse().ok());
    let (sessions, first) = (numbers.next().unwrap_or(1000), numbers.next().unwrap_or(0));
    let results: Vec<Option<[usize; 2]>> = (first..first + sessions)
        .into_par_iter()
        .map(|seed| {
            let start = Instant::now();
            let result = std::panic::catch_unwind(|| argil_conformance::random_session(seed, 20));
            if start.elapsed().as_secs() >= 3 {
                println!("seed {seed} took {} s", start.elapsed().as_secs());
            }
            match result {
                Ok(Ok(counts)) => Some(counts),
                Ok(Err(difference)) => {
                    println!("{difference}");
                    None
                }
                Err(_) => {
                    println!("seed {seed} panicked");
                    None
                }
            }
        })
        .collect();
    let failed = results.iter().filter(|outcome| outcome.is_none()).count();
    let counts = results.into_iter().flatten();
    let [edits, rebuilds] = counts.fold([0, 0], |sum, counts| {
        [sum[0] + counts[0], sum[1] + counts[1]]
    });
    println!("{failed} of {sessions} sessions failed, {rebuilds} of {edits} edits rebuilt");
    std::process::exit(i32::from(failed > 0));
}
