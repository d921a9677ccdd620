//! Tests that long work does not keep a program's own work waiting.

use argil_field::in_background;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// How long work waits at most, if the test fails.
const LIMIT: Duration = Duration::from_secs(20);

#[test]
fn work_on_the_global_threads_does_not_wait() {
    let start = Instant::now();
    let (begun, is_over, is_late) = (
        AtomicBool::new(false),
        AtomicBool::new(false),
        AtomicBool::new(false),
    );
    let wait = |until: &AtomicBool| {
        while !until.load(Relaxed) && start.elapsed() < LIMIT {
            std::thread::sleep(Duration::from_millis(1));
        }
    };
    std::thread::scope(|threads| {
        threads.spawn(|| {
            in_background(|| {
                (0..256).into_par_iter().for_each(|_| {
                    begun.store(true, Relaxed);
                    wait(&is_over);
                    is_late.fetch_or(!is_over.load(Relaxed), Relaxed);
                });
            });
        });
        wait(&begun);
        // All threads that take such work have some now.
        std::thread::sleep(Duration::from_millis(100));
        let sum: u64 = (0..1000u64).into_par_iter().sum();
        is_over.store(true, Relaxed);
        assert_eq!(sum, 499_500);
    });
    assert!(begun.load(Relaxed) && !is_late.load(Relaxed));
}

#[test]
fn what_is_in_the_background_stays_there() {
    let name = || std::thread::current().name().map(str::to_owned);
    let [outer, inner] = in_background(|| [name(), in_background(name)]);
    assert!(outer.is_some_and(|name| name.starts_with("argil background")));
    assert!(inner.is_some_and(|name| name.starts_with("argil background")));
}
