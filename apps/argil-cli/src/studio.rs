//! `argil studio`.

use crate::args::Studio;
use crate::input;

pub fn run(options: &Studio) -> anyhow::Result<()> {
    let engine = input::engine(&options.on)?;
    argil_studio::run(engine, options.scene.clone())
}
