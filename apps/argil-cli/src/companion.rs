//! Programs beside this one, which few need and take long to compile: the editor and the study.

use crate::args::Companion;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// One that is not there.
#[derive(Debug, thiserror::Error)]
#[error(
    "{0} is a program of its own, and is neither beside this one nor on the PATH: `cargo build --release -p {0}` in Argil's folder builds it"
)]
pub(crate) struct Missing(&'static str);

/// Starts a program with arguments, and ends as it does.
///
/// # Errors
/// If it is not there.
pub(crate) fn run(name: &'static str, given: &Companion) -> anyhow::Result<ExitCode> {
    let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe()
        .ok()
        .and_then(|own| own.parent().map(|folder| folder.join(&file)))
        .filter(|path| path.is_file());
    let program = beside.or_else(|| on_path(&file)).ok_or(Missing(name))?;
    let status = Command::new(&program)
        .args(&given.arguments)
        .status()
        .map_err(|e| anyhow::anyhow!("{}: {e}", program.display()))?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(ExitCode::from(code.unwrap_or(1)))
}

fn on_path(file: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let found = |folder: PathBuf| folder.join(Path::new(file));
    std::env::split_paths(&path)
        .map(found)
        .find(|path| path.is_file())
}
