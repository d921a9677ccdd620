//! `argil import`.

use crate::args::Import;
use crate::output;
use anyhow::Context;
use argil::Scene;
use serde_json::json;

pub fn run(options: &Import) -> anyhow::Result<()> {
    output::check_place(&options.output, &options.tree)?;
    let mut scene = Scene::import_tree(&options.tree)?;
    scene.name = options
        .tree
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    // What cannot be lowered should be said now, not when it is drawn.
    argil::Program::lower(&scene).with_context(|| options.tree.display().to_string())?;
    scene.save(&options.output)?;
    let brushes = scene.brush_count();
    if options.json {
        output::json(&json!({ "scene": options.output.display().to_string(), "brushes": brushes }));
    } else {
        output::line(&format!("{}: {brushes} brushes", options.output.display()));
    }
    Ok(())
}
