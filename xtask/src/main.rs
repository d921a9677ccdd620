//! `cargo xtask`: small, since it is compiled apart from all else. The checks run the tools of Rust; other chores are a program
//! that is built with the whole workspace, with whose crates it shares what was compiled.

mod test;

use anyhow::bail;
use xtask::chore;

const USAGE: &str = "usage: cargo xtask COMMAND

  test      format, lint, test, document: everything that CI checks; installs what GPU tests and the page need where it can
  web       build the editor's page into target/page; with `serve [PORT]`, hand it out on this machine; with `test`, drive it in Chromium
  generate  write the files that are made from code: the schema of scenes, the WGSL of shared structs";

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.first().map(String::as_str) {
        Some("test") => test::run_all(),
        Some("web" | "generate") => chore(&[], &arguments),
        _ => bail!(USAGE),
    }
}
