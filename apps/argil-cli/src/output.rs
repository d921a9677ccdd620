//! What the commands print.

use anyhow::Context;
use argil::Spread;
use serde_json::{Value, json};
use std::io::Write;

/// One line on stdout. A reader that went away is no fault of ours; a full disk is.
pub fn line(text: &str) {
    if let Err(error) = writeln!(std::io::stdout(), "{text}")
        && error.kind() != std::io::ErrorKind::BrokenPipe
    {
        eprintln!("argil: stdout: {error}");
        std::process::exit(1);
    }
}

pub fn json(value: &Value) {
    line(&value.to_string());
}

pub fn spread(s: Spread) -> Value {
    json!({ "mean": s.mean, "p95": s.p95, "max": s.max })
}

/// Least, median, 95th percentile and greatest of some durations.
pub fn times(samples: &[f64]) -> Value {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index =
            ((sorted.len() as f64 * share).ceil() as usize).clamp(1, sorted.len().max(1)) - 1;
        sorted.get(index).copied().unwrap_or(0.0)
    };
    json!({ "min": at(0.0), "median": at(0.5), "p95": at(0.95), "max": at(1.0) })
}

/// Refuse a place that cannot be written before hours are spent on what goes there.
/// Nor may the output be the input.
pub fn check_place(path: &std::path::Path, input: &std::path::Path) -> anyhow::Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(std::path::Path::new("."));
    let found =
        std::fs::metadata(folder).with_context(|| format!("{}: the folder", folder.display()))?;
    anyhow::ensure!(found.is_dir(), "{}: not a folder", folder.display());
    anyhow::ensure!(
        !path.is_dir(),
        "{}: is a folder; name a file",
        path.display()
    );
    let same = path
        .canonicalize()
        .is_ok_and(|p| input.canonicalize().is_ok_and(|i| i == p));
    anyhow::ensure!(
        !same,
        "{}: this is the input; name another file",
        path.display()
    );
    Ok(())
}
