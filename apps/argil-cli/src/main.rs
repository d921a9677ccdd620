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

use args::{Arguments, Command};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    // clap prints usage errors itself and exits with 2.
    let arguments = Arguments::parse();
    quiet_loaders();
    // Told to stop in the middle of writing, leave nothing behind. Without a handler the old file is whole all the same.
    let _ = ctrlc::set_handler(|| {
        argil::remove_unfinished_files();
        std::process::exit(130);
    });
    let result = match arguments.command {
        Command::Study(given) => return ended(companion::run("argil-study", &given)),
        Command::Studio(given) => return ended(companion::run("argil-studio", &given)),
        Command::Render(options) => render::run(&options),
        Command::Bake(options) => bake::run(&options),
        Command::Mesh(options) => mesh::run(&options),
        Command::Edit(options) => edit::run(&options),
        Command::Recover(options) => recover::run(&options),
        Command::Import(options) => import::run(&options),
        Command::Compare(options) => compare::run(&options),
        Command::Info(options) => info::run(&options),
        Command::Devices(options) => devices::run(&options),
        Command::Schema => schema::run(),
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
