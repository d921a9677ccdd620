//! Programs that are built separately: the editor and the study.

use crate::args::Companion;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// The program was not found.
#[derive(Debug, thiserror::Error)]
#[error(
    "{0} is a separate program, and it is neither next to this one nor on the PATH: build it with `cargo build --release -p {0}` in Argil's folder"
)]
pub(crate) struct Missing(&'static str);

/// The command was built without something.
#[derive(Debug, thiserror::Error)]
#[error(
    "this program was built without `argil {0}`: build it with `cargo build --release -p argil-cli --features {0}` in Argil's folder, or with `--features cloud` for stores behind the network, too"
)]
#[cfg_attr(feature = "world", allow(dead_code, reason = "all commands are built"))]
pub(crate) struct NotBuilt(pub &'static str);

/// Starts a program with arguments, and exits with its exit code.
///
/// # Errors
/// If the program is not found.
pub(crate) fn run(name: &'static str, given: &Companion) -> anyhow::Result<ExitCode> {
    let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe()
        .ok()
        .and_then(|this| this.parent().map(|folder| folder.join(&file)))
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
