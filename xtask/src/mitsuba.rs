//! `cargo xtask compare-mitsuba`: compares stills with those of Mitsuba 3. It is not a part of the tests, because it takes minutes
//! and 60 MB.

use crate::python::environment;
use xtask::{root, run};

/// Where the environment is, and what it needs.
const ENVIRONMENT: &str = "target/mitsuba";
const PACKAGES: [&str; 2] = ["mitsuba==3.9.1", "numpy>=2"];

pub(crate) fn run_all() -> anyhow::Result<()> {
    let python = environment(ENVIRONMENT)?;
    let install = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
    ];
    run(&python, &[&install[..], &PACKAGES].concat())?;
    run(
        "cargo",
        &["build", "--release", "--locked", "--package", "argil-cli"],
    )?;
    let argil = root().join("target/release/argil");
    let pictures = root().join(ENVIRONMENT).join("pictures");
    run(
        &python,
        &[
            "conformance/mitsuba/compare.py",
            &argil.to_string_lossy(),
            "scenes",
            &pictures.to_string_lossy(),
        ],
    )
}
