//! `cargo xtask test`.

use anyhow::bail;
use xtask::debian::{install, quietly};
use xtask::run as checked;

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
    ensure_nextest()?;
    let tests = ["nextest", "run", "--workspace", "--locked"];
    checked("cargo", &[&tests[..], &["--no-run"]].concat())?;
    ensure_gpu(&tests)?;
    checked("cargo", &[&tests[..], &["--no-fail-fast"]].concat())?;
    checked("cargo", &["test", "--workspace", "--locked", "--doc"])?;
    checked(
        "cargo",
        &[
            "doc",
            "--workspace",
            "--lib",
            "--no-deps",
            "--locked",
            "--config",
            "build.rustdocflags=['-Dwarnings']",
        ],
    )?;
    crate::chore(&["web", "test"])?;
    println!("\nAll checks passed.");
    Ok(())
}

/// GPU tests run on whatever there is, a software device where there is no other.
fn ensure_gpu(tests: &[&str]) -> anyhow::Result<()> {
    // A process of its own: a loader that finds nothing remembers it.
    let ask = ["-E", "package(argil-conformance) & test(a_gpu_is_there)"];
    let has_gpu = || quietly("cargo", &[tests, &ask].concat());
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

fn ensure_nextest() -> anyhow::Result<()> {
    if quietly("cargo", &["nextest", "--version"]) {
        return Ok(());
    }
    checked("cargo", &["install", "cargo-nextest", "--locked"])
}
