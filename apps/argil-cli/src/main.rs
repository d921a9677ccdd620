//! The `argil` command. What scripts can rely on: names, flags, keys of `--json`, exit codes; see the README.

mod args;
mod bake;
mod companion;
mod compare;
mod devices;
mod edit;
mod failure;
mod import;
mod info;
mod input;
mod long_work;
mod mesh;
mod output;
mod progress;
mod recover;
mod render;
mod schema;

use args::{CliCommand, CommandLine};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    // clap prints usage errors itself and exits with 2.
    let arguments = CommandLine::parse();
    quiet_loaders();
    // Told to stop in the middle of writing, leave nothing behind. Without a handler the old file is whole all the same.
    let _ = ctrlc::set_handler(|| {
        argil::scene::remove_temp_files();
        std::process::exit(130);
    });
    let result = match arguments.command {
        CliCommand::Study(given) => return ended(companion::run("argil-study", &given)),
        CliCommand::Studio(given) => return ended(companion::run("argil-studio", &given)),
        CliCommand::Render(options) => render::run(&options),
        CliCommand::Bake(options) => bake::run(&options),
        CliCommand::Mesh(options) => mesh::run(&options),
        CliCommand::Edit(options) => edit::run(&options),
        CliCommand::Recover(options) => recover::run(&options),
        CliCommand::Import(options) => import::run(&options),
        CliCommand::Compare(options) => compare::run(&options),
        CliCommand::Info(options) => info::run(&options),
        CliCommand::Devices(options) => devices::run(&options),
        CliCommand::Schema => schema::run(),
    };
    ended(result.map(|()| ExitCode::SUCCESS))
}

fn ended(result: anyhow::Result<ExitCode>) -> ExitCode {
    result.unwrap_or_else(|error| failure::report(&error))
}

/// A Vulkan loader asks Wayland's library for a screen, which complains on stderr where there is no folder for it. Nobody
/// who runs this command wants to know.
fn quiet_loaders() {
    #[cfg(target_os = "linux")]
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: no other thread runs yet.
        unsafe { std::env::set_var("XDG_RUNTIME_DIR", std::env::temp_dir()) };
    }
}
