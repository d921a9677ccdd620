//! `cargo xtask test`.

use crate::run as checked;
use anyhow::bail;
use std::process::{Command, Stdio};

fn run_quietly(program: &str, arguments: &[&str]) -> bool {
    let command = Command::new(program)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    command.is_ok_and(|status| status.success())
}

pub fn run() -> anyhow::Result<()> {
    checked("cargo", &["fmt", "--all", "--check"])?;
    checked(
        "cargo",
        &[
            "clippy",
            "--workspace",
            "--all-targets",
            "--locked",
            "--",
            "-D",
            "warnings",
        ],
    )?;
    ensure_gpu()?;
    ensure_nextest()?;
    checked(
        "cargo",
        &[
            "nextest",
            "run",
            "--workspace",
            "--locked",
            "--no-fail-fast",
        ],
    )?;
    checked("cargo", &["test", "--workspace", "--locked", "--doc"])?;
    // Warnings are errors here, without changing the flags that everything else was compiled with.
    for package in [
        "argil-abi",
        "argil-math",
        "argil-scene",
        "argil-field",
        "argil-volume",
        "argil-march",
        "argil-gpu",
        "argil",
    ] {
        checked(
            "cargo",
            &[
                "rustdoc", "-p", package, "--locked", "--lib", "--", "-D", "warnings",
            ],
        )?;
    }
    println!("\nAll checks passed.");
    Ok(())
}

/// GPU tests run on whatever there is, a software device where there is no other.
fn ensure_gpu() -> anyhow::Result<()> {
    if has_gpu() {
        return Ok(());
    }
    println!("\nNo GPU found: installing Mesa's software Vulkan device.");
    let install = [
        "install",
        "-y",
        "--no-install-recommends",
        "mesa-vulkan-drivers",
        "libvulkan1",
    ];
    let is_root = run_quietly("sh", &["-c", "[ \"$(id -u)\" = 0 ]"]);
    let installed = if is_root {
        run_quietly("apt-get", &["update"]) && checked("apt-get", &install).is_ok()
    } else if run_quietly("sudo", &["-n", "true"]) {
        run_quietly("sudo", &["apt-get", "update"])
            && checked("sudo", &[&["apt-get"][..], &install].concat()).is_ok()
    } else {
        false
    };
    if !installed || !has_gpu() {
        bail!(
            "the GPU tests need a Vulkan, Metal or Direct3D 12 device. On Debian and Ubuntu: \
             sudo apt-get install mesa-vulkan-drivers libvulkan1. On Fedora: sudo dnf install mesa-vulkan-drivers. \
             On Arch: sudo pacman -S vulkan-swrast. macOS and Windows bring one."
        );
    }
    Ok(())
}

fn has_gpu() -> bool {
    // A process of its own: a loader that finds nothing remembers it.
    run_quietly(
        "cargo",
        &["run", "--locked", "--package", "xtask", "--", "has-gpu"],
    )
}

fn ensure_nextest() -> anyhow::Result<()> {
    if run_quietly("cargo", &["nextest", "--version"]) {
        return Ok(());
    }
    checked("cargo", &["install", "cargo-nextest", "--locked"])
}
