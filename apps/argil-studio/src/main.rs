//! The editor as a program, which `argil studio` starts.

#[cfg(not(target_arch = "wasm32"))]
mod native {
    use argil::Backend;
    use clap::Parser;
    use std::path::PathBuf;
    use std::process::ExitCode;

    /// Argil Studio, the editor
    #[derive(Parser)]
    #[command(name = "argil-studio", version)]
    struct Arguments {
        /// The scene to open, or a finished world: its folder, manifest.json or address [default: a sample]
        scene: Option<PathBuf>,
        /// Device: auto selects a hardware GPU if there is one, else the CPU
        #[arg(long, default_value = "auto", value_parser = ["auto", "cpu", "gpu"])]
        device: String,
        /// Load meshes from outside the scene's folder
        #[arg(long, alias = "allow-outside")]
        allow_external_meshes: bool,
        /// Threads of the CPU path [default: all cores]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
        threads: Option<u16>,
    }

    pub(crate) fn run() -> ExitCode {
        let arguments = Arguments::parse();
        let begun = || -> anyhow::Result<()> {
            // Report a faulty file on the command line, before a window opens.
            if let Some(path) = &arguments.scene
                && !argil_studio::is_world(path)
            {
                argil::scene::Scene::open(path)?;
            }
            if let Some(threads) = arguments.threads {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
                pool.build_global()
                    .map_err(|e| argil::EngineError::Threads(e.to_string()))?;
            }
            let backend = match &*arguments.device {
                "cpu" => Backend::Cpu,
                "gpu" => Backend::Gpu,
                _ => Backend::Auto,
            };
            let (scene, outside) = (arguments.scene.clone(), arguments.allow_external_meshes);
            Ok(argil_studio::run(backend, scene, outside)?)
        };
        match begun() {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("argil-studio: {error:#}");
                let of_machine = error.chain().any(|cause| {
                    cause.is::<argil::EngineError>() || cause.is::<argil_studio::NoWindow>()
                });
                ExitCode::from(if of_machine { 3 } else { 1 })
            }
        }
    }
}

fn main() -> std::process::ExitCode {
    #[cfg(not(target_arch = "wasm32"))]
    return native::run();
    #[cfg(target_arch = "wasm32")]
    std::process::ExitCode::SUCCESS
}
