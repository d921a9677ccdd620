//! The project's chores, one command each: `cargo xtask test`, `cargo xtask web`, `cargo xtask generate`.

mod debian;
mod page;
mod test;
mod web;

use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

const USAGE: &str = "usage: cargo xtask COMMAND

  test      format, lint, test, document: everything that CI checks; installs what GPU tests and the page need where it can
  web       build the editor's page into target/page; with `serve [PORT]`, hand it out on this machine; with `test`, drive it in Chromium
  generate  write the files that are made from code: the schema of scenes, the WGSL of shared structs";

fn main() -> anyhow::Result<()> {
    match std::env::args().nth(1).as_deref() {
        Some("test") => test::run(),
        Some("web") => {
            web::build()?;
            match std::env::args().nth(2).as_deref() {
                None => Ok(()),
                Some("serve") => {
                    let port = std::env::args().nth(3).map_or(Ok(8080), |p| p.parse());
                    web::serve(port.context("a port is a number up to 65535")?)
                }
                Some("test") => page::test(),
                _ => bail!(USAGE),
            }
        }
        Some("generate") => generate(),
        Some("has-gpu") => {
            // For `test`: a question to a fresh process.
            if pollster::block_on(argil_gpu::devices()).is_empty() {
                bail!("no GPU")
            } else {
                Ok(())
            }
        }
        _ => bail!(USAGE),
    }
}

/// The workspace's folder.
fn root() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own).to_owned()
}

fn generate() -> anyhow::Result<()> {
    for (path, text) in [
        ("scenes/argil.schema.json", argil_scene::schema()),
        ("crates/argil-abi/src/abi.wgsl", argil_abi::wgsl()),
    ] {
        std::fs::write(root().join(path), text).with_context(|| path.to_owned())?;
        println!("{path}");
    }
    Ok(())
}

/// Run a program in the workspace's folder; an error unless it succeeds.
fn run(program: &str, arguments: &[&str]) -> anyhow::Result<()> {
    println!("\n> {program} {}", arguments.join(" "));
    let status = Command::new(program)
        .args(arguments)
        .current_dir(root())
        .status();
    let status = status.with_context(|| format!("{program} could not be started"))?;
    if !status.success() {
        bail!("{program} {} failed", arguments.join(" "));
    }
    Ok(())
}
