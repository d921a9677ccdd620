//! The `argil` command. Scripts can rely on its names, flags, `--json` keys and exit codes.

mod arg_values;
mod args;
mod bake;
mod companion;
mod compare;
mod devices;
mod edit;
mod export;
mod failure;
mod heat_legend;
mod import;
mod info;
mod input;
mod long_work;
mod mesh;
mod output;
mod progress;
mod recover;
mod render;
mod representation_parser;
mod schema;
mod single_image;
mod still;
mod still_args;
mod still_plan;
#[cfg(feature = "world")]
mod stored;
#[cfg(feature = "world")]
mod world;
#[cfg(feature = "world")]
mod world_args;

use args::{CliCommand, CommandLine};
use clap::Parser;
use std::process::ExitCode;
use still_args::Integrator;

fn main() -> ExitCode {
    // clap prints usage errors itself and exits with 2.
    let arguments = CommandLine::parse();
    // Other programs get the environment as it is.
    let is_own = !matches!(
        arguments.command,
        CliCommand::Study(_) | CliCommand::Studio(_)
    );
    if is_own {
        quiet_loaders();
    }
    // When interrupted while writing, remove the temporary file. The previous file stays intact in any case. A still that is
    // interrupted is written as far as it is.
    let _ = ctrlc::set_handler(|| {
        if still::interrupt() {
            return;
        }
        argil::scene::remove_temp_files();
        std::process::exit(130);
    });
    let result = match arguments.command {
        CliCommand::Study(given) => return ended(companion::run("argil-study", &given)),
        CliCommand::Studio(given) => return ended(companion::run("argil-studio", &given)),
        CliCommand::Render(options) => {
            still::check(&options).and_then(|()| match options.still.integrator {
                Integrator::Direct => render::run(&options),
                Integrator::Path => still::run(&options),
            })
        }
        CliCommand::Bake(options) => bake::run(&options),
        CliCommand::Mesh(options) => mesh::run(&options),
        CliCommand::Edit(options) => edit::run(&options),
        CliCommand::Recover(options) => recover::run(&options),
        CliCommand::Import(options) => import::run(&options),
        CliCommand::Compare(options) => compare::run(&options),
        CliCommand::Info(options) => info::run(&options),
        CliCommand::Devices(options) => devices::run(&options),
        #[cfg(feature = "world")]
        CliCommand::World(options) => world::run(&options),
        #[cfg(not(feature = "world"))]
        CliCommand::World(_) => Err(companion::NotBuilt("world").into()),
        CliCommand::Schema => schema::run(),
    };
    ended(result.map(|()| ExitCode::SUCCESS))
}

fn ended(result: anyhow::Result<ExitCode>) -> ExitCode {
    result.unwrap_or_else(|error| failure::report(&error))
}

/// Silences the Vulkan loader. Wayland's library complains on stderr if its folder is missing, which does not
/// matter here.
fn quiet_loaders() {
    #[cfg(target_os = "linux")]
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: no other thread is running yet.
        unsafe { std::env::set_var("XDG_RUNTIME_DIR", std::env::temp_dir()) };
    }
}
