//! Tests that long work does not keep a program's own work waiting.

use argil_field::in_background;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

#[test]
fn work_on_the_global_threads_does_not_wait() {
    let (is_over, begun) = (AtomicBool::new(false), AtomicUsize::new(0));
    std::thread::scope(|threads| {
        threads.spawn(|| {
            in_background(|| {
                (0..256).into_par_iter().for_each(|_| {
                    begun.fetch_add(1, Ordering::Relaxed);
                    let start = Instant::now();
                    while !is_over.load(Ordering::Relaxed) {
                        assert!(
                            start.elapsed() < Duration::from_secs(60),
                            "the program's own work waits"
                        );
                        std::thread::sleep(Duration::from_millis(1));
                    }
                });
            });
        });
        while begun.load(Ordering::Relaxed) == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        let sum: u64 = (0..1000u64).into_par_iter().sum();
        assert_eq!(sum, 499_500);
        is_over.store(true, Ordering::Relaxed);
    });
}
