//! The `argil` command. What scripts can rely on: names, flags, keys of `--json`, exit codes; see the README.

mod args;
mod bake;
mod compare;
mod devices;
mod edit;
mod failure;
mod import;
mod info;
mod input;
mod mesh;
mod output;
mod recover;
mod render;
mod schema;
mod studio;
mod study;

use args::{Arguments, Command};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    // clap prints usage errors itself and exits with 2.
    let arguments = Arguments::parse();
    // Told to stop in the middle of writing, leave nothing behind. Without a handler the old file is whole all the same.
    let _ = ctrlc::set_handler(|| {
        argil::remove_unfinished_files();
        std::process::exit(130);
    });
    let result = match arguments.command {
        Command::Render(options) => render::run(&options),
        Command::Bake(options) => bake::run(&options),
        Command::Mesh(options) => mesh::run(&options),
        Command::Edit(options) => edit::run(&options),
        Command::Recover(options) => recover::run(&options),
        Command::Import(options) => import::run(&options),
        Command::Compare(options) => compare::run(&options),
        Command::Info(options) => info::run(&options),
        Command::Study(options) => study::run(&options),
        Command::Studio(options) => studio::run(&options),
        Command::Devices(options) => devices::run(&options),
        Command::Schema => schema::run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure::report(&error),
    }
}
