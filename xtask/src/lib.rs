//! Shared parts of all tasks: the workspace's folder, running programs, installing and checking packages.

pub mod apt;
pub mod packages;

use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Returns the workspace's folder.
pub fn root() -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    folder.parent().unwrap_or(folder).to_owned()
}

/// Environment variables that make cargo compile and lint the workspace's crates in one pass, with warnings denied.
///
/// `cargo clippy` sets the same two, but only checks: all dependencies would be analyzed once for it and compiled
/// once for the tests.
pub const LINT_WHILE_COMPILING: &[(&str, &str)] = &[
    ("RUSTC_WORKSPACE_WRAPPER", "clippy-driver"),
    ("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__"),
];

/// Runs a program in the workspace's folder, and prints its duration.
///
/// # Errors
/// If the program cannot be started, or fails.
pub fn run(program: &str, arguments: &[&str]) -> anyhow::Result<()> {
    run_with(&[], program, arguments)
}

/// Runs a program as [`run`] does, with environment variables.
///
/// # Errors
/// If the program cannot be started, or fails.
pub fn run_with(
    environment: &[(&str, &str)],
    program: &str,
    arguments: &[&str],
) -> anyhow::Result<()> {
    println!("\n> {program} {}", arguments.join(" "));
    let start = std::time::Instant::now();
    let status = Command::new(program)
        .args(arguments)
        .envs(environment.iter().copied())
        .current_dir(root())
        .status();
    let status = status.with_context(|| format!("{program} could not be started"))?;
    if !status.success() {
        bail!("{program} {} failed", arguments.join(" "));
    }
    println!("  {:.0} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// Builds a program of the workspace, and runs it.
///
/// # Errors
/// If the build or the program fails.
pub fn build_and_run(name: &str, arguments: &[impl AsRef<str>]) -> anyhow::Result<()> {
    let build = ["build", "--workspace", "--bin", name, "--locked"];
    run("cargo", &build)?;
    run_built(name, arguments)
}

/// Runs a program of the workspace that is built.
///
/// # Errors
/// If the program is missing or fails.
pub fn run_built(name: &str, arguments: &[impl AsRef<str>]) -> anyhow::Result<()> {
    let arguments: Vec<&str> = arguments.iter().map(AsRef::as_ref).collect();
    run(&built(name)?.display().to_string(), &arguments)
}

/// Returns the file of a program of the workspace that is built, beside this one, so in the same profile.
///
/// Also of this one: where cargo built it again meanwhile, the file of this process is deleted.
///
/// # Errors
/// If the folder of this program is unknown.
pub fn built(name: &str) -> anyhow::Result<PathBuf> {
    let this = std::env::current_exe()?;
    Ok(this.with_file_name(format!("{name}{}", std::env::consts::EXE_SUFFIX)))
}
