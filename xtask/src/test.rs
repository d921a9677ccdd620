//! `cargo xtask test`.

use anyhow::bail;
use std::fs;
use std::path::{Path, PathBuf};
use xtask::apt::{install, quietly, quietly_with};
use xtask::{LINT_WHILE_COMPILING, chore, root, run, run_with};

const TESTS: &[&str] = &["nextest", "run", "--workspace", "--locked", WORLD];

/// What is left out, unless it is asked for.
const WORLD: &str = "--features=argil-cli/world,argil/zarr";

/// Packages without public documentation: programs, and their tests and tasks.
const NOT_DOCUMENTED: &[&str] = &[
    "argil-chores",
    "argil-cli",
    "argil-conformance",
    "argil-studio",
    "argil-study",
    "xtask",
];

pub(crate) fn run_all() -> anyhow::Result<()> {
    run("cargo", &["fmt", "--all", "--check"])?;
    check_python_lock()?;
    ensure_typos()?;
    run("typos", &[])?;
    ensure_deny()?;
    run(
        "cargo",
        &[
            "deny",
            "check",
            "--hide-inclusion-graph",
            "licenses",
            "bans",
            "sources",
        ],
    )?;
    forget_packages();
    run("cargo", &packages())?;
    let compiled = |arguments: &[&str]| run_with(LINT_WHILE_COMPILING, "cargo", arguments);
    compiled(&["build", "--workspace", "--all-targets", "--locked", WORLD])?;
    compiled(&[
        "check",
        "--package",
        "argil",
        "--no-default-features",
        "--locked",
    ])?;
    ensure_nextest()?;
    ensure_gpu()?;
    ensure_openvdb()?;
    compiled(&[TESTS, &["--no-fail-fast"]].concat())?;
    compiled(&["test", "--workspace", "--locked", "--doc"])?;
    run("cargo", &documentation())?;
    chore(LINT_WHILE_COMPILING, &["web", "test"])?;
    crate::python::run_all()?;
    println!("\nAll checks passed.");
    Ok(())
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
    arguments.extend(NOT_DOCUMENTED.iter().flat_map(|name| ["--exclude", name]));
    arguments.extend(["--config", "build.rustdocflags=['-Dwarnings']"]);
    arguments
}

/// Packages every crate that others can use, and compiles each from its package.
fn packages() -> Vec<&'static str> {
    let mut arguments = vec!["package", "--workspace", "--locked", "--allow-dirty"];
    arguments.extend(["--target-dir", PACKAGE_TARGET]);
    arguments.extend(NOT_DOCUMENTED.iter().flat_map(|name| ["--exclude", name]));
    arguments
}

/// Where packages are compiled.
const PACKAGE_TARGET: &str = "target/packages";

/// Removes what earlier runs left of our packages. Cargo unpacks a package that another one depends on once per
/// version, and does not notice that its contents changed.
fn forget_packages() {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::home_dir().map(|own| own.join(".cargo")));
    let registry = home.unwrap_or_default().join("registry");
    let folders = ["src", "cache"].map(|name| registry.join(name));
    let registries = folders.iter().flat_map(entries);
    // The name of a local registry has no host.
    let local = registries.filter(|path| file_name(path).starts_with('-'));
    let built = root().join(PACKAGE_TARGET).join("debug/.fingerprint");
    for path in local.chain([built]).flat_map(entries) {
        if file_name(&path).starts_with("argil") {
            // What cannot be removed makes the check of packages fail, or is not used.
            let _ = fs::remove_dir_all(&path).or_else(|_| fs::remove_file(&path));
        }
    }
}

fn entries(folder: impl AsRef<Path>) -> Vec<PathBuf> {
    let found = fs::read_dir(folder).into_iter().flatten().flatten();
    found.map(|entry| entry.path()).collect()
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Packages with the programs that read our volumes.
const OPENVDB: &[&str] = &[
    "python3-openvdb",
    "python3-numpy",
    "libopenvdb-tools",
    "libnanovdb-tools",
];

/// Ensures that OpenVDB's programs are there, which tests compare with.
fn ensure_openvdb() -> anyhow::Result<()> {
    let look = "/usr/bin/python3 -c 'import pyopenvdb, numpy' && command -v vdb_print nanovdb_validate nanovdb_print";
    let are_there = || quietly("sh", &["-c", look]);
    if are_there() {
        return Ok(());
    }
    println!("\nOpenVDB's programs are missing: installing them.");
    let installed = install(OPENVDB);
    if !installed || !are_there() {
        bail!(
            "the tests of volume files need OpenVDB's and NanoVDB's programs. On Debian and Ubuntu: sudo apt-get install {}",
            OPENVDB.join(" ")
        );
    }
    Ok(())
}

/// Ensures that GPU tests have a device, a software one if there is no other.
fn ensure_gpu() -> anyhow::Result<()> {
    // A separate process, because a loader that finds no device remembers it.
    let ask = ["-E", "package(argil-conformance) & test(a_gpu_is_there)"];
    let has_gpu = || quietly_with(LINT_WHILE_COMPILING, "cargo", &[TESTS, &ask].concat());
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

/// Its wheel needs no compiler.
fn ensure_typos() -> anyhow::Result<()> {
    let is_there = || quietly("typos", &["--version"]);
    if is_there() || quietly("pip", &["install", "typos"]) && is_there() {
        return Ok(());
    }
    run("cargo", &["install", "typos-cli", "--locked"])
}

fn ensure_deny() -> anyhow::Result<()> {
    if quietly("cargo", &["deny", "--version"]) {
        return Ok(());
    }
    run("cargo", &["install", "cargo-deny", "--locked"])
}

fn ensure_nextest() -> anyhow::Result<()> {
    if quietly("cargo", &["nextest", "--version"]) {
        return Ok(());
    }
    run("cargo", &["install", "cargo-nextest", "--locked"])
}
