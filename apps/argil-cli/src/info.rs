//! `argil info`.

use crate::args::Info;
use crate::output;
use anyhow::Context;
use argil::{Body, Engine, Scene};
use serde_json::{Value, json};

pub fn run(options: &Info) -> anyhow::Result<()> {
    let scene = Scene::open(&options.scene)?;
    let world = Engine::cpu()
        .build(&scene)
        .with_context(|| options.scene.display().to_string())?;
    let program = world.program();
    let groups = scene
        .walk()
        .filter(|&id| matches!(scene.node(id).entry().body, Body::Group))
        .count()
        - 1;
    let bounds = program.aabb();
    let corner = |v: argil::glam::Vec3| -> Value {
        // JSON has no infinity.
        v.to_array()
            .into_iter()
            .map(|c| if c.is_finite() { json!(c) } else { Value::Null })
            .collect()
    };
    let report = json!({
        "name": scene.name,
        "credit": scene.credit,
        "brushes": scene.brush_count(),
        "visible_brushes": program.brush_count(),
        "groups": groups,
        "materials": scene.materials().len(),
        "box": [corner(bounds.min), corner(bounds.max)],
        "lipschitz": program.lipschitz(),
        "instructions": program.instrs().len(),
        "stack_slots": program.stack_slots(),
        "memory_bytes": program.memory_bytes(),
    });
    if options.json {
        output::json(&report);
        return Ok(());
    }
    for (key, value) in report.as_object().into_iter().flatten() {
        let text = value
            .as_str()
            .map_or_else(|| value.to_string(), str::to_owned);
        if !text.is_empty() {
            output::line(&format!("{:17}{text}", key.replace('_', " ")));
        }
    }
    Ok(())
}
