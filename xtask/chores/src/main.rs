//! The tasks `web`, `generate` and `shader-stats`, which `cargo xtask` builds and runs.

mod city;
mod pictures;
mod readme;
mod shader_stats;
mod valley;
mod web;
mod web_test;
mod world_parts;
mod worlds;

use anyhow::{Context, bail};
use xtask::root;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["web"] => web::build(&web::RELEASED),
        ["web", "test"] => {
            web_test::check_shaders()?;
            web::build(&web::TESTED)?;
            web_test::test()
        }
        ["web", "serve"] => serve(8080),
        ["web", "serve", port] => serve(port.parse().context("a port is a number up to 65535")?),
        ["generate"] => generate(),
        ["shader-stats"] => shader_stats::write(None),
        ["shader-stats", "--check"] => shader_stats::check(),
        ["shader-stats", family] => shader_stats::write(Some(family)),
        _ => bail!(
            "usage: cargo xtask web [serve [PORT] | test], cargo xtask generate, cargo xtask shader-stats [GPU | --check]"
        ),
    }
}

fn serve(port: u16) -> anyhow::Result<()> {
    web::build(&web::RELEASED)?;
    web::serve(&web::RELEASED, port)
}

fn generate() -> anyhow::Result<()> {
    for (path, text) in [
        ("scenes/argil.schema.json", argil_scene::schema()),
        ("crates/argil-abi/src/abi.wgsl", argil_abi::wgsl()),
    ] {
        std::fs::write(root().join(path), text).with_context(|| path.to_owned())?;
        println!("{path}");
    }
    for (path, text) in [
        readme::readmes()?,
        pictures::pictures()?,
        pictures::crate_pictures()?,
        worlds::worlds()?,
    ]
    .concat()
    {
        std::fs::write(&path, text).with_context(|| path.display().to_string())?;
        println!("{}", path.display());
    }
    Ok(())
}
