//! `cargo xtask test`.

use crate::python;
use crate::tools::{DENY, NEXTEST, TYPOS};
use anyhow::{Context, bail};
use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, Command};
use std::thread::JoinHandle;
use xtask::apt::{CHROMIUM, MESA, NODE, OPENVDB, WEB_RUST};
use xtask::apt::{Needed, install, install_quietly, quietly, quietly_with};
use xtask::{LINT_WHILE_COMPILING, built, packages, root, run, run_built, run_with};

const TESTS: &[&str] = &["nextest", "run", "--workspace", "--locked", WORLD];

/// What is left out, unless it is asked for. With the same features everywhere, nothing is compiled twice.
const WORLD: &str = "--features=argil-cli/world,argil/zarr";

/// Seconds per fuzz target, of which each core runs one at a time. `cargo xtask fuzz` runs them for longer.
const FUZZ_SECONDS: &str = "8";

/// Crates that nobody else can use: programs, and their tests and tasks.
const PRIVATE: &[&str] = &[
    "argil-chores",
    "argil-cli",
    "argil-conformance",
    "argil-fuzz",
    "argil-studio",
    "argil-study",
    "xtask",
];

pub(crate) fn run_all() -> anyhow::Result<()> {
    run("cargo", &["fmt", "--all", "--check"])?;
    check_python_lock()?;
    run(&TYPOS.find()?, &[])?;
    let rules = ["licenses", "bans", "sources"];
    let check = ["check", "--hide-inclusion-graph"];
    run(&DENY.find()?, &[&check[..], &rules].concat())?;
    // Workspaces of their own, with locks of their own.
    for folder in ["bindings/python", "fuzz"] {
        let manifest = format!("{folder}/Cargo.toml");
        let place = ["--manifest-path", &manifest, "--config", "deny.toml"];
        run(&DENY.find()?, &[&place[..], &check, &rules].concat())?;
    }
    packages::check(PRIVATE)?;
    let installed = install_in_background();
    let compiled = |arguments: &[&str]| run_with(LINT_WHILE_COMPILING, "cargo", arguments);
    compiled(&["build", "--workspace", "--all-targets", "--locked", WORLD])?;
    compiled(&[
        "check",
        "--package",
        "argil",
        "--no-default-features",
        "--locked",
    ])?;
    let _ = installed.join();
    let nextest = NEXTEST.find()?;
    ensure_gpu(&nextest)?;
    ensure(
        MESA,
        "the statistics of shaders need Mesa's driver of AMD's GPUs, even where there is none",
    )?;
    ensure(
        OPENVDB,
        "the tests of volume files need OpenVDB's and NanoVDB's programs",
    )?;
    run_with(
        LINT_WHILE_COMPILING,
        &nextest,
        &[TESTS, &["--no-fail-fast"]].concat(),
    )?;
    let seconds = ["--seconds", FUZZ_SECONDS];
    // Those that are there: alone, they would be built again, with the features that only tests need left out.
    run_built("argil-fuzz", &seconds)?;
    compiled(&["test", "--workspace", "--locked", "--doc", WORLD])?;
    run("cargo", &documentation())?;
    // Both are mostly one program at a time: together, they use two cores.
    let package = PythonTests::start()?;
    let page = run_built("argil-chores", &["web", "test"]);
    package.finish()?;
    page?;
    println!("\nAll checks passed.");
    Ok(())
}

/// The tests of the Python package, in a process of their own.
struct PythonTests {
    process: Child,
    log: PathBuf,
}

impl PythonTests {
    fn start() -> anyhow::Result<Self> {
        let log = root().join("target/python-test.log");
        let file = File::create(&log).with_context(|| log.display().to_string())?;
        let tasks = built("xtask")?;
        // The page's tests wait for pictures, and no longer than some minutes.
        let mut command = if cfg!(unix) {
            let mut nice = Command::new("nice");
            nice.args(["-n", "10"]).arg(&tasks);
            nice
        } else {
            Command::new(&tasks)
        };
        let process = command
            .arg("python")
            .current_dir(root())
            .stdout(file.try_clone()?)
            .stderr(file)
            .spawn()
            .context("the tests of the Python package could not be started")?;
        Ok(Self { process, log })
    }

    /// Waits for the end, and prints what the tests printed.
    fn finish(mut self) -> anyhow::Result<()> {
        let status = self.process.wait()?;
        print!("{}", String::from_utf8_lossy(&std::fs::read(&self.log)?));
        if !status.success() {
            bail!("the tests of the Python package failed");
        }
        Ok(())
    }
}

/// Checks that the Python package's lock file has all that our crates need, which its build would notice last.
fn check_python_lock() -> anyhow::Result<()> {
    let manifest = "bindings/python/Cargo.toml";
    let locked = ["metadata", "--locked", "--format-version", "1"];
    let ask = [&locked[..], &["--manifest-path", manifest]].concat();
    if !quietly("cargo", &ask) {
        bail!("bindings/python/Cargo.lock is old: cargo metadata --manifest-path {manifest}");
    }
    Ok(())
}

fn documentation() -> Vec<&'static str> {
    let mut arguments = vec!["doc", "--workspace", "--lib", "--no-deps", "--locked"];
    arguments.extend(PRIVATE.iter().flat_map(|name| ["--exclude", name]));
    arguments.extend(["--config", "build.rustdocflags=['-Dwarnings']"]);
    arguments
}

/// Ensures that packages are there. `reason` says what needs them.
fn ensure(needed: Needed, reason: &str) -> anyhow::Result<()> {
    if needed.is_there() || install(needed.packages) && needed.is_there() {
        return Ok(());
    }
    bail!(
        "{reason}. On Debian and Ubuntu: sudo apt-get install {}",
        needed.packages.join(" ")
    )
}

/// Installs what later steps need, without output, while crates compile. What cannot be installed is asked for again by the
/// step that needs it, with an error that says so.
fn install_in_background() -> JoinHandle<()> {
    std::thread::spawn(|| {
        let needed = [MESA, OPENVDB, CHROMIUM, NODE, WEB_RUST];
        let missing = needed.iter().filter(|needed| !needed.is_there());
        let missing: Vec<&str> = missing
            .flat_map(|needed| needed.packages)
            .copied()
            .collect();
        if !missing.is_empty() {
            println!("\nInstalling meanwhile: {}", missing.join(" "));
            install_quietly(&missing);
        }
        let _ = python::install_quietly();
    })
}

/// Ensures that GPU tests have a device, a software one if there is no other.
fn ensure_gpu(nextest: &str) -> anyhow::Result<()> {
    // A separate process, because a loader that finds no device remembers it.
    let ask = ["-E", "package(argil-conformance) & test(a_gpu_is_there)"];
    let has_gpu = || quietly_with(LINT_WHILE_COMPILING, nextest, &[TESTS, &ask].concat());
    if has_gpu() {
        return Ok(());
    }
    println!("\nNo GPU found: installing Mesa's software Vulkan device.");
    let installed = install(MESA.packages);
    if !installed || !has_gpu() {
        bail!(
            "the GPU tests need a Vulkan, Metal or Direct3D 12 device. On Debian and Ubuntu: \
             sudo apt-get install mesa-vulkan-drivers libvulkan1. On Fedora: sudo dnf install mesa-vulkan-drivers. \
             On Arch: sudo pacman -S vulkan-swrast. macOS and Windows bring one."
        );
    }
    Ok(())
}
