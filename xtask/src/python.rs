//! `cargo xtask python`: builds the wheel of `bindings/python`, installs it into an environment of its own, and tests what is
//! installed there.

use anyhow::{Context, bail};
use std::fs;
use std::path::{Path, PathBuf};
use xtask::apt::{install, quietly};
use xtask::{LINT_WHILE_COMPILING, root, run, run_with};

/// The folder of the package.
const PACKAGE: &str = "bindings/python";
/// Where the environment and the wheels are.
const ENVIRONMENT: &str = "target/python";
const WHEELS: &str = "target/wheels";

/// What installs packages, and those that the tests need.
pub(crate) const PIP: &[&str] = &[
    "-m",
    "pip",
    "install",
    "--quiet",
    "--disable-pip-version-check",
];
const REQUIREMENTS: &[&str] = &["--requirement", "bindings/python/requirements.txt"];

/// How a wheel is compiled, and how large it may be.
pub(crate) struct Wheel {
    profile: &'static str,
    max_bytes: Option<u64>,
}

/// What people install: small and fast.
pub(crate) const RELEASED: Wheel = Wheel {
    profile: "release",
    max_bytes: Some(12 << 20),
};

/// What tests install: compiled soon.
pub(crate) const TESTED: Wheel = Wheel {
    profile: "wheel-test",
    max_bytes: None,
};

pub(crate) fn run_all(wheel: &Wheel) -> anyhow::Result<()> {
    let manifest = format!("{PACKAGE}/Cargo.toml");
    run("cargo", &["fmt", "--manifest-path", &manifest, "--check"])?;
    let python = environment(ENVIRONMENT)?;
    let pip = |arguments: &[&str]| run(&python, &[PIP, arguments].concat());
    pip(REQUIREMENTS)?;
    let wheel = built(&python, wheel)?;
    pip(&["--force-reinstall", "--no-deps", &wheel])?;
    let in_package = |arguments: &[&str]| {
        // What is installed is tested, and not the folder.
        let tests = root().join(PACKAGE).join("tests");
        let all = [&["-P"], arguments].concat();
        run_with(&[("PYTHONPATH", &tests.to_string_lossy())], &python, &all)
    };
    let config = format!("{PACKAGE}/pyproject.toml");
    let place = |name: &str| format!("{PACKAGE}/{name}");
    in_package(&["-m", "pytest", "-c", &config, &place("tests")])?;
    in_package(&[
        "-m",
        "pytest",
        "-c",
        &config,
        "--nbmake",
        &place("notebooks"),
    ])?;
    in_package(&[
        "-m",
        "pytest",
        "-c",
        &config,
        "--doctest-modules",
        "--pyargs",
        "argil",
    ])?;
    in_package(&["-m", "mypy", "--config-file", &config, "--package", "argil"])?;
    in_package(&["-m", "mypy.stubtest", "argil._native"])?;
    in_package(&[
        "-m",
        "mypy",
        "--config-file",
        &config,
        &place("examples/typed.py"),
    ])?;
    in_package(&[
        "-m",
        "pyright",
        "--project",
        &config,
        &place("examples/typed.py"),
    ])?;
    Ok(())
}

/// Installs what the tests need into their environment.
pub(crate) fn install_quietly() -> anyhow::Result<()> {
    let python = environment(ENVIRONMENT)?;
    let list = root().join(REQUIREMENTS[1]);
    let list = list.to_string_lossy();
    quietly(&python, &[PIP, &[REQUIREMENTS[0], &list]].concat());
    Ok(())
}

/// Builds a wheel, with lints, and checks its size. Returns its path.
fn built(python: &str, wheel: &Wheel) -> anyhow::Result<String> {
    let folder = root().join(WHEELS);
    // What earlier runs left would be found instead.
    let _ = fs::remove_dir_all(&folder);
    let manifest = format!("{PACKAGE}/Cargo.toml");
    let build = [
        "-m",
        "maturin",
        "build",
        "--profile",
        wheel.profile,
        "--locked",
        "--manifest-path",
        &manifest,
        "--out",
        WHEELS,
    ];
    run_with(LINT_WHILE_COMPILING, python, &build)?;
    let found = fs::read_dir(&folder)?.flatten().map(|entry| entry.path());
    let path = found
        .into_iter()
        .find(|path| path.extension().is_some_and(|ending| ending == "whl"))
        .context("maturin built no wheel")?;
    let size = fs::metadata(&path)?.len();
    if let Some(most) = wheel.max_bytes.filter(|&most| size > most) {
        bail!("{} has {size} bytes, more than {most}", path.display());
    }
    println!(
        "  {}: {:.1} MiB",
        path.display(),
        size as f64 / f64::from(1 << 20)
    );
    Ok(path.to_string_lossy().into_owned())
}

/// Returns the Python of an environment in a folder, which is created if it is missing.
pub(crate) fn environment(folder: &str) -> anyhow::Result<String> {
    let folder = root().join(folder);
    let python = python_of(&folder);
    if python.exists() {
        return Ok(python.to_string_lossy().into_owned());
    }
    let target = folder.to_string_lossy().into_owned();
    let create = || {
        let names = [
            "python3",
            "python3.13",
            "python3.12",
            "python3.11",
            "python",
        ];
        let is_recent = "import sys, ensurepip; sys.exit(sys.version_info < (3, 11))";
        let found = names.iter().find(|name| quietly(name, &["-c", is_recent]));
        found.is_some_and(|name| quietly(name, &["-m", "venv", &target]))
    };
    if create() {
        return Ok(python.to_string_lossy().into_owned());
    }
    println!("\nPython with environments is missing: installing it.");
    if !install(&["python3", "python3-venv"]) || !create() {
        bail!(
            "the tests of the Python package need Python 3.11 or later with venv. On Debian and Ubuntu: sudo apt-get install python3-venv"
        );
    }
    Ok(python.to_string_lossy().into_owned())
}

fn python_of(folder: &Path) -> PathBuf {
    if cfg!(windows) {
        folder.join("Scripts").join("python.exe")
    } else {
        folder.join("bin").join("python")
    }
}
