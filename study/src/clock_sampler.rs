//! Reads a GPU's clock while cases run.
//!
//! *Practice.* A thread stores readings with their times. For NVIDIA it reads the lines of one `nvidia-smi` that prints
//! every 50 ms. If none arrives, because its output is held back, a process is started for each reading.

use crate::clock::{self, ClockReading, ClockSource, NVIDIA_QUERY};
use crate::clock_range::{ClockMeter, ClockRange, Interval, Stamped, has_settled};
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// NVIDIA's program that prints clocks.
const NVIDIA_SMI: &str = "nvidia-smi";

/// The time between readings.
const PERIOD: Duration = Duration::from_millis(50);

/// How long a source may take until its first reading.
const PATIENCE: Duration = Duration::from_secs(2);

/// Readings that a thread adds to.
#[derive(Clone, Debug, Default)]
struct Readings {
    all: Arc<Mutex<Vec<Stamped>>>,
    has_ended: Arc<AtomicBool>,
}

impl Readings {
    fn add(&self, reading: ClockReading) {
        let mut all = self.all.lock().unwrap_or_else(PoisonError::into_inner);
        all.push((Instant::now(), reading));
    }

    fn with<T>(&self, read: impl FnOnce(&[Stamped]) -> T) -> T {
        read(&self.all.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn are_wanted(&self) -> bool {
        !self.has_ended.load(Ordering::Relaxed)
    }

    /// Waits for the first reading. Returns false if none arrives in time.
    fn wait(&self) -> bool {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if self.with(|all| !all.is_empty()) {
                return true;
            }
            std::thread::sleep(PERIOD / 10);
        }
        false
    }
}

/// Samples a device's clock until it is dropped.
#[derive(Debug)]
pub(crate) struct ClockSampler {
    readings: Readings,
    child: Option<Child>,
    thread: Option<JoinHandle<()>>,
    /// Why the clock is unknown.
    reason: Option<String>,
}

impl ClockSampler {
    /// Starts to sample a device. If its clock cannot be read, the sampler has no readings, and a reason.
    pub(crate) fn start(device: &str) -> Self {
        let found = clock::source(device).and_then(|source| Self::follow(source, NVIDIA_SMI));
        found.unwrap_or_else(Self::unknown)
    }

    /// Creates a sampler of an unknown clock.
    pub(crate) fn unknown(reason: impl Into<String>) -> Self {
        Self {
            readings: Readings::default(),
            child: None,
            thread: None,
            reason: Some(reason.into()),
        }
    }

    fn follow(source: ClockSource, nvidia_smi: &str) -> Result<Self, String> {
        if let ClockSource::Nvidia(device) = &source {
            let count = matching(device, nvidia_smi)?;
            if count != 1 {
                return Err(format!("nvidia-smi lists {count} GPUs with this name"));
            }
            let streamed = Self::stream(device, nvidia_smi)?;
            if streamed.readings.wait() {
                return Ok(streamed);
            }
        }
        let polled = Self::poll(source, nvidia_smi);
        if polled.readings.wait() {
            return Ok(polled);
        }
        Err("the source of the clock gives no number".into())
    }

    /// Reads the lines of one process.
    fn stream(device: &str, nvidia_smi: &str) -> Result<Self, String> {
        let period = format!("--loop-ms={}", PERIOD.as_millis());
        let mut child = Command::new(nvidia_smi)
            .args(NVIDIA_QUERY)
            .arg(period)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("nvidia-smi: {error}"))?;
        let output = child.stdout.take().ok_or("nvidia-smi has no output")?;
        let readings = Readings::default();
        let (shared, device) = (readings.clone(), device.to_owned());
        let thread = std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                if let Some(reading) = clock::nvidia(&line, &device) {
                    shared.add(reading);
                }
            }
        });
        Ok(Self {
            readings,
            child: Some(child),
            thread: Some(thread),
            reason: None,
        })
    }

    /// Reads a file, or starts a process, for each reading.
    fn poll(source: ClockSource, nvidia_smi: &str) -> Self {
        let readings = Readings::default();
        let (shared, nvidia_smi) = (readings.clone(), nvidia_smi.to_owned());
        let thread = std::thread::spawn(move || {
            while shared.are_wanted() {
                if let Some(reading) = read(&source, &nvidia_smi) {
                    shared.add(reading);
                }
                std::thread::sleep(PERIOD);
            }
        });
        Self {
            readings,
            child: None,
            thread: Some(thread),
            reason: None,
        }
    }
}

impl ClockMeter for ClockSampler {
    fn range(&self, intervals: &[Interval]) -> Option<ClockRange> {
        self.readings.with(|all| ClockRange::within(all, intervals))
    }

    fn has_settled(&self, since: Instant) -> Option<bool> {
        let is_known = self.reason.is_none();
        is_known.then(|| self.readings.with(|all| has_settled(all, since)))
    }

    fn unknown_because(&self) -> Option<&str> {
        self.reason.as_deref()
    }
}

impl Drop for ClockSampler {
    fn drop(&mut self) {
        self.readings.has_ended.store(true, Ordering::Relaxed);
        if let Some(child) = &mut self.child {
            // A process that has ended cannot be killed.
            let _ = child.kill();
            let _ = child.wait();
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Returns the output of one `nvidia-smi`.
fn nvidia_lines(nvidia_smi: &str) -> Result<String, String> {
    let output = Command::new(nvidia_smi)
        .args(NVIDIA_QUERY)
        .output()
        .map_err(|error| format!("nvidia-smi: {error}"))?;
    String::from_utf8(output.stdout).map_err(|error| format!("nvidia-smi: {error}"))
}

/// Counts the GPUs with a clock and a device's name.
fn matching(device: &str, nvidia_smi: &str) -> Result<usize, String> {
    let lines = nvidia_lines(nvidia_smi)?;
    let readings = lines.lines().filter_map(|line| clock::nvidia(line, device));
    Ok(readings.count())
}

fn read(source: &ClockSource, nvidia_smi: &str) -> Option<ClockReading> {
    let text = |path| std::fs::read_to_string(path).ok();
    match source {
        ClockSource::Nvidia(device) => {
            let lines = nvidia_lines(nvidia_smi).ok()?;
            lines.lines().find_map(|line| clock::nvidia(line, device))
        }
        ClockSource::AmdLevels(path) => clock::amd(&text(path)?),
        ClockSource::IntelNumber(path) => clock::intel(&text(path)?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_sampled_while_it_changes() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("pp_dpm_sclk");
        std::fs::write(&path, "0: 500Mhz *\n1: 2575Mhz\n").expect("a file");
        let start = Instant::now();
        let sampler =
            ClockSampler::follow(ClockSource::AmdLevels(path.clone()), NVIDIA_SMI).expect("clocks");
        std::fs::write(&path, "0: 500Mhz\n1: 2575Mhz *\n").expect("a file");
        let range = || sampler.range(&[(start, Instant::now())]).expect("a range");
        while range().max < 2575.0 {
            std::thread::sleep(PERIOD);
        }
        assert_eq!((range().min, range().limit), (500.0, Some(2575.0)));
    }

    /// Samples a device named `NVIDIA H100` with a script in place of `nvidia-smi`.
    #[cfg(unix)]
    fn sampled(script: &str) -> Result<ClockSampler, String> {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let program = folder.path().join("nvidia-smi");
        std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).expect("a program");
        std::fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).expect("a program");
        let source = ClockSource::Nvidia("NVIDIA H100".into());
        ClockSampler::follow(source, &program.to_string_lossy())
    }

    #[test]
    #[cfg(unix)]
    fn one_process_prints_many_readings() {
        let start = Instant::now();
        let script = "echo 'NVIDIA H100, 345, 1980'; case $* in *loop*) ;; *) exit;; esac
            for i in 1 2 3 4 5 6 7 8 9; do echo 'NVIDIA H100, 1980, 1980'; sleep 0.02; done";
        let sampler = sampled(script).expect("clocks");
        let range = || sampler.range(&[(start, Instant::now())]).expect("a range");
        while range().median < 1980.0 {
            std::thread::sleep(PERIOD);
        }
        assert_eq!((range().min, range().max), (345.0, 1980.0));
        assert_eq!(range().limit, Some(1980.0));
    }

    /// Processes are started one after another if one holds its lines back.
    #[test]
    #[cfg(unix)]
    fn held_back_lines_are_polled() {
        let start = Instant::now();
        let script = "case $* in *loop*) exec sleep 60;; esac; echo 'NVIDIA H100, 1755, [N/A]'";
        let sampler = sampled(script).expect("clocks");
        let range = sampler.range(&[(start, Instant::now())]).expect("a range");
        assert_eq!((range.median, range.limit), (1755.0, None));
    }

    #[test]
    #[cfg(unix)]
    fn clocks_that_cannot_be_told_are_refused() {
        let error = |script: &str| sampled(script).map(|_| ()).expect_err("no clock");
        let line = "echo 'NVIDIA H100, 345, 1980'";
        assert!(error(&format!("{line}; {line}")).contains("lists 2 GPUs"));
        assert!(error("echo 'NVIDIA T4, 345, 1980'").contains("lists 0 GPUs"));
        assert!(error("echo 'NVIDIA H100, [N/A], [N/A]'").contains("lists 0 GPUs"));
        let source = ClockSource::Nvidia("NVIDIA H100".into());
        assert!(ClockSampler::follow(source, "/nowhere/nvidia-smi").is_err());
    }

    #[test]
    fn an_unknown_clock_has_no_range() {
        let sampler = ClockSampler::start("llvmpipe (LLVM 15.0.6, 256 bits)");
        let now = Instant::now();
        assert_eq!(sampler.range(&[(now, now)]), None);
        assert_eq!(sampler.has_settled(now), None);
        assert!(sampler.unknown_because().is_some());
    }
}
