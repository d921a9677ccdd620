//! Runs a target on changed seeds, and saves the input that it fails on.

use crate::failure::{CURRENT, Current, fail};
use crate::memory;
use argil_fuzz::{Mutator, Target};
use std::time::{Duration, Instant};

/// Bytes of memory per byte of input.
const MEMORY_PER_BYTE: usize = 64;
/// Time per input of at most 64 KiB. Readers take 2 s for 10 MB, and dependencies without optimization much longer.
const MAX_TIME: Duration = Duration::from_secs(5);
/// Time after which an input counts as endless.
const ENDLESS: Duration = Duration::from_secs(10);

/// Makes panics and endless inputs end the program.
fn watch() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |about| {
        memory::unlimit();
        usual(about);
        fail("it panics");
    }));
    std::thread::spawn(|| {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let start = CURRENT
                .lock()
                .ok()
                .and_then(|run| run.as_ref().map(|run| run.start));
            if start.is_some_and(|start| start.elapsed() > ENDLESS) {
                fail("it does not end");
            }
        }
    });
}

/// The most that inputs took.
#[derive(Default)]
struct Most {
    memory: usize,
    time: Duration,
}

fn one(target: &Target, input: Vec<u8>, most: &mut Most) {
    let limit = target.floor_bytes + MEMORY_PER_BYTE * input.len();
    let start = Instant::now();
    if let Ok(mut current) = CURRENT.lock() {
        *current = Some(Current {
            name: target.name,
            input: input.clone(),
            start,
        });
    }
    let memory = memory::limited(limit, || (target.run)(&input));
    let time = start.elapsed();
    if time > MAX_TIME {
        fail(&format!("it takes {} ms", time.as_millis()));
    }
    most.memory = most.memory.max(memory);
    most.time = most.time.max(time);
}

/// Runs a target for a while, on its seeds first.
pub(crate) fn run(target: &Target, time: Duration) -> anyhow::Result<()> {
    let seeds = (target.seeds)();
    watch();
    let mut most = Most::default();
    let start = Instant::now();
    for seed in &seeds {
        one(target, seed.clone(), &mut most);
    }
    let mut mutator = Mutator::new(target.name, seeds);
    let mut count = 0;
    while start.elapsed() < time {
        one(target, mutator.next_input(), &mut most);
        count += 1;
    }
    println!(
        "{:12} {count} inputs, at most {} KiB and {} ms",
        target.name,
        most.memory >> 10,
        most.time.as_millis()
    );
    Ok(())
}

/// Runs a target on one input.
pub(crate) fn run_file(target: &Target, input: &[u8]) -> anyhow::Result<()> {
    watch();
    let mut most = Most::default();
    one(target, input.to_vec(), &mut most);
    println!(
        "{}: {} KiB, {} ms",
        target.name,
        most.memory >> 10,
        most.time.as_millis()
    );
    Ok(())
}
