//! Runs fuzz targets for a while: `argil-fuzz [--seconds N] [TARGET…]`, or `argil-fuzz --file FILE TARGET` for one input.
//!
//! A panic, an input that takes more than 64 times its size in memory, or one that takes too long stops the program. The input
//! is saved then.

mod failure;
mod memory;
mod runner;

use anyhow::{Context, bail};
use std::process::Command;
use std::time::Duration;

#[global_allocator]
static MEMORY: memory::Counting = memory::Counting;

/// Time per target, unless another is asked for.
const SECONDS: f64 = 20.0;

struct Options {
    seconds: f64,
    file: Option<String>,
    names: Vec<String>,
}

fn options() -> anyhow::Result<Options> {
    let mut all = Options {
        seconds: SECONDS,
        file: None,
        names: Vec::new(),
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || {
            arguments
                .next()
                .with_context(|| format!("{argument} has no value"))
        };
        match argument.as_str() {
            "--seconds" => all.seconds = value()?.parse()?,
            "--file" => all.file = Some(value()?),
            _ => all.names.push(argument),
        }
    }
    Ok(all)
}

fn main() -> anyhow::Result<()> {
    let options = options()?;
    if let [name] = &options.names[..] {
        let target =
            argil_fuzz::find(name).with_context(|| format!("there is no target {name}"))?;
        return match &options.file {
            Some(path) => {
                runner::run_file(target, &std::fs::read(path).with_context(|| path.clone())?)
            }
            None => runner::run(target, Duration::from_secs_f64(options.seconds)),
        };
    }
    let names = match options.names.is_empty() {
        true => argil_fuzz::TARGETS
            .iter()
            .map(|target| target.name.to_owned())
            .collect(),
        false => options.names,
    };
    run_all(&names, options.seconds)
}

/// Runs each target in a process of its own, one per core at a time.
fn run_all(names: &[String], seconds: f64) -> anyhow::Result<()> {
    let program = std::env::current_exe()?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let next = std::sync::atomic::AtomicUsize::new(0);
    let failed = std::sync::Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..cores.min(names.len()) {
            scope.spawn(|| {
                while let Some(name) =
                    names.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed))
                {
                    let exit = Command::new(&program)
                        .args(["--seconds", &seconds.to_string(), name])
                        .status();
                    if !exit.is_ok_and(|status| status.success())
                        && let Ok(mut failed) = failed.lock()
                    {
                        failed.push(name.clone());
                    }
                }
            });
        }
    });
    let failed = failed.into_inner().unwrap_or_default();
    if !failed.is_empty() {
        bail!("failed: {}", failed.join(", "));
    }
    Ok(())
}
