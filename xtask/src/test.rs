//! `cargo xtask test`.

use crate::debian::{install, quietly};
use crate::run as checked;
use anyhow::bail;

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
        "argil-mesh",
        "argil-metrics",
        "argil",
        "argil-studio",
        "argil-study",
    ] {
        checked(
            "cargo",
            &[
                "rustdoc", "-p", package, "--locked", "--lib", "--", "-D", "warnings",
            ],
        )?;
    }
    crate::web::build()?;
    crate::page::test()?;
    println!("\nAll checks passed.");
    Ok(())
}

/// GPU tests run on whatever there is, a software device where there is no other.
fn ensure_gpu() -> anyhow::Result<()> {
    if has_gpu() {
        return Ok(());
    }
    println!("\nNo GPU found: installing Mesa's software Vulkan device.");
    let installed = install(&["mesa-vulkan-drivers", "libvulkan1"]);
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
    quietly(
        "cargo",
        &["run", "--locked", "--package", "xtask", "--", "has-gpu"],
    )
}

fn ensure_nextest() -> anyhow::Result<()> {
    if quietly("cargo", &["nextest", "--version"]) {
        return Ok(());
    }
    checked("cargo", &["install", "cargo-nextest", "--locked"])
}
