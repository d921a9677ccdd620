//! `cargo xtask web`: the editor as a web page.

use anyhow::{Context, bail};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use wasm_bindgen_cli_support::Bindgen;
use xtask::apt::{WEB_RUST, install, quietly};
use xtask::root;

const TARGET: &str = "wasm32-unknown-unknown";

/// How this machine compiles Rust for browsers.
enum Toolchain {
    /// With rustup's target.
    Rustup,
    /// With Debian's compiler, which comes without a compiled standard library, and the path of a linker.
    Debian(PathBuf),
}

/// How a page is compiled, where it is, and how large it may be.
pub(crate) struct Page {
    profile: &'static str,
    folder: &'static str,
    most_bytes: Option<usize>,
}

/// What people load: small and fast.
pub(crate) const RELEASED: Page = Page {
    profile: "page",
    folder: "target/page",
    most_bytes: Some(65 << 16),
};

/// What tests drive: compiled soon.
pub(crate) const TESTED: Page = Page {
    profile: "page-test",
    folder: "target/page-test/page",
    most_bytes: None,
};

/// Builds a page, and prints its size.
pub(crate) fn build(page: &Page) -> anyhow::Result<()> {
    let toolchain = toolchain()?;
    let compiled = root().join("target").join("web");
    let mut arguments = vec![
        "rustc",
        "--package",
        "argil-studio",
        "--lib",
        "--crate-type",
        "cdylib",
        "--profile",
        page.profile,
        "--locked",
        "--target",
        TARGET,
        "--target-dir",
        "target/web",
    ];
    let mut command = match &toolchain {
        Toolchain::Rustup => Command::new("cargo"),
        Toolchain::Debian(linker) => {
            arguments.push("-Zbuild-std=std,panic_abort");
            let mut command = Command::new("/usr/bin/cargo");
            // Cargo runs the first compiler on the PATH. The standard library comes as source, which requires
            // unstable flags.
            command
                .env("PATH", "/usr/bin:/bin")
                .env("RUSTC_BOOTSTRAP", "1")
                .env("RUSTFLAGS", format!("-Clinker={}", linker.display()))
                .env_remove("RUSTC")
                .env_remove("RUSTUP_TOOLCHAIN")
                .env_remove("CARGO");
            command
        }
    };
    println!("\n> cargo {}", arguments.join(" "));
    let status = command.args(&arguments).current_dir(root()).status();
    if !status.context("cargo could not be started")?.success() {
        bail!("the editor could not be compiled for the browser");
    }
    let wasm = compiled.join(TARGET).join(page.profile);
    let wasm = wasm.join("argil_studio.wasm");
    let out = root().join(page.folder);
    Bindgen::new()
        .input_path(&wasm)
        .out_name("argil")
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true)
        .omit_default_module_path(false)
        .web(true)?
        .generate(&out)
        .with_context(|| wasm.display().to_string())?;
    let index = root().join("apps/argil-studio/page/index.html");
    std::fs::copy(&index, out.join("index.html")).with_context(|| index.display().to_string())?;
    weigh(&out, page.most_bytes)
}

/// Prints the size of each file. Fails if the compressed total is too large.
fn weigh(out: &Path, most_bytes: Option<usize>) -> anyhow::Result<()> {
    let mut total = 0;
    println!("\n{}", out.display());
    for name in ["index.html", "argil.js", "argil_bg.wasm"] {
        let path = out.join(name);
        let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packed.write_all(&bytes)?;
        let packed = packed.finish()?.len();
        total += packed;
        println!("  {name:14} {:>9} bytes, {packed:>9} gzipped", bytes.len());
    }
    println!(
        "  all: {:.2} MiB gzipped",
        total as f64 / f64::from(1 << 20)
    );
    if let Some(most) = most_bytes.filter(|&most| total > most) {
        bail!("the page is to be no more than {most} bytes, gzipped");
    }
    Ok(())
}

/// Returns the toolchain for browsers. Installs it if it is missing and can be installed.
fn toolchain() -> anyhow::Result<Toolchain> {
    if has_target() || quietly("rustup", &["target", "add", TARGET]) && has_target() {
        return Ok(Toolchain::Rustup);
    }
    if let Some(linker) = debian() {
        return Ok(Toolchain::Debian(linker));
    }
    println!("\nNo Rust for browsers found: installing Debian's.");
    install(WEB_RUST.packages);
    match debian() {
        Some(linker) => Ok(Toolchain::Debian(linker)),
        None => bail!(
            "Rust cannot compile for browsers here: rustup target add {TARGET}; or on Debian, apt-get install {}",
            WEB_RUST.packages.join(" ")
        ),
    }
}

/// Returns true if the compiler has the standard library for browsers.
fn has_target() -> bool {
    let found = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", TARGET])
        .output();
    found.is_ok_and(|out| {
        let path = String::from_utf8_lossy(&out.stdout).trim().to_owned();
        out.status.success() && Path::new(&path).is_dir()
    })
}

/// Returns the linker of Debian's compiler for browsers, if both are installed with the library's source.
fn debian() -> Option<PathBuf> {
    let source = Path::new("/usr/lib/rustlib/src/rust/library/std/Cargo.toml");
    let is_there = source.is_file() && Path::new("/usr/bin/cargo").is_file();
    let linkers = std::fs::read_dir("/usr/bin").ok()?.flatten();
    let mut linkers: Vec<(u32, PathBuf)> = linkers
        .filter_map(|file| {
            let name = file.file_name();
            let version = name.to_str()?.strip_prefix("wasm-ld-")?.parse().ok()?;
            Some((version, file.path()))
        })
        .collect();
    linkers.sort();
    let (_, newest) = linkers.pop()?;
    is_there.then_some(newest)
}

/// Serves a page on this machine until the program ends.
pub(crate) fn serve(page: &Page, port: u16) -> anyhow::Result<()> {
    let server = server(port)?;
    println!("\nhttp://{}/ until Ctrl-C", server.server_addr());
    answer(page, &server);
    Ok(())
}

/// Creates the server; port 0 selects any port.
pub(crate) fn server(port: u16) -> anyhow::Result<tiny_http::Server> {
    let place = format!("127.0.0.1:{port}");
    tiny_http::Server::http(&place).map_err(|error| anyhow::anyhow!("{place}: {error}"))
}

/// Answers requests for a page.
pub(crate) fn answer(page: &Page, server: &tiny_http::Server) {
    for request in server.incoming_requests() {
        let path = request.url().split('?').next().unwrap_or("/");
        let kind = match path {
            "/" | "/index.html" => ("index.html", "text/html; charset=utf-8"),
            "/argil.js" => ("argil.js", "text/javascript"),
            "/argil_bg.wasm" => ("argil_bg.wasm", "application/wasm"),
            _ => ("", ""),
        };
        let header = tiny_http::Header::from_bytes("Content-Type", kind.1);
        let file = std::fs::File::open(root().join(page.folder).join(kind.0));
        // The client may be gone.
        let _ = match (file, header) {
            (Ok(file), Ok(header)) if !kind.0.is_empty() => {
                request.respond(tiny_http::Response::from_file(file).with_header(header))
            }
            _ => request.respond(tiny_http::Response::empty(404)),
        };
    }
}
