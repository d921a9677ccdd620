//! What all chores stand on: the workspace's folder, programs that are run there, packages that are installed.

pub mod debian;

use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The workspace's folder.
pub fn root() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own).to_owned()
}

/// Run a program in the workspace's folder, and say how long it took; an error unless it succeeds.
pub fn run(program: &str, arguments: &[&str]) -> anyhow::Result<()> {
    println!("\n> {program} {}", arguments.join(" "));
    let start = std::time::Instant::now();
    let status = Command::new(program)
        .args(arguments)
        .current_dir(root())
        .status();
    let status = status.with_context(|| format!("{program} could not be started"))?;
    if !status.success() {
        bail!("{program} {} failed", arguments.join(" "));
    }
    println!("  {:.0} s", start.elapsed().as_secs_f64());
    Ok(())
}
