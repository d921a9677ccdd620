//! `cargo xtask`: a small program, because it is compiled separately. Checks run Rust's tools. Other tasks are a
//! program that is built with the workspace and shares its compiled crates.

mod mitsuba;
mod python;
mod test;
mod tools;

use anyhow::bail;
use xtask::build_and_run;

const USAGE: &str = "usage: cargo xtask COMMAND

  test      check everything that CI checks: format, lints, spelling, licenses, tests, documentation, page; install what that needs where it can
  web       build the editor's page into target/page; with `serve [PORT]`, serve it on this machine; with `test`, drive one that compiles sooner in Chromium
  python    build a Python wheel into target/wheels, and test what it installs, in an environment of its own; with `release`, the small and fast one
  fuzz      try all readers of files on changed files for 20 s each; with `--seconds N`, for N; with TARGET…, only these
  compare-mitsuba  compare path-traced stills with those of Mitsuba 3, in an environment of its own; not a part of `test`
  shader-stats [GPU]  write the statistics that a hardware compiler has of every shader into docs/shader-stats.md, without that hardware;
            for another GPU than navi21, such as vangogh, renoir or gfx1100, print them; with `--check`, compare
  generate  write the files that come from code: the scene schema, the WGSL of shared structs, the README of each crate";

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_release = arguments.get(1).is_some_and(|word| word == "release");
    match arguments.first().map(String::as_str) {
        Some("test") => test::run_all(),
        Some("python") if is_release => python::run_all(&python::RELEASED),
        Some("python") => python::run_all(&python::TESTED),
        Some("fuzz") => build_and_run("argil-fuzz", &arguments[1..]),
        Some("compare-mitsuba") => mitsuba::run_all(),
        Some("web" | "generate" | "shader-stats") => build_and_run("argil-chores", &arguments),
        _ => bail!(USAGE),
    }
}
