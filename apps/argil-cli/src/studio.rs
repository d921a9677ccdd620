//! `argil studio`.

use crate::args::Studio;
use crate::input;
use argil::Scene;

pub fn run(options: &Studio) -> anyhow::Result<()> {
    // What is at fault in a file is told here, and not in a window that shows something else.
    if let Some(path) = &options.scene {
        Scene::open(path)?;
    }
    let engine = input::engine(&options.on)?;
    Ok(argil_studio::run(
        engine,
        options.scene.clone(),
        options.on.allow_outside,
    )?)
}
