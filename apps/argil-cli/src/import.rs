//! `argil import`.

use crate::args::Import;
use crate::{input, output};
use anyhow::{Context, ensure};
use argil::{Brush, Format, LoadedMesh, Scene, Shape};
use serde_json::{Value, json};

pub fn run(options: &Import) -> anyhow::Result<()> {
    output::check_place(&options.output, &options.file)?;
    let is_mesh = Format::of(&options.file).is_some();
    ensure!(
        is_mesh || options.resolution.is_none(),
        "--resolution says how a mesh is sampled, and {} is none: leave it out",
        options.file.display()
    );
    let (mut scene, loaded) = if is_mesh {
        mesh(options)?
    } else {
        (Scene::import_tree(&options.file)?, None)
    };
    scene.name = options
        .file
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    // What cannot be lowered should be said now, not when it is drawn.
    argil::Program::lower(&scene).with_context(|| options.file.display().to_string())?;
    scene.save(&options.output)?;
    let brushes = scene.brush_count();
    let mut report = json!({ "scene": options.output.display().to_string(), "brushes": brushes });
    if let Some(loaded) = &loaded {
        output::extend(&mut report, about(loaded));
    }
    if options.json {
        output::json(&report);
        return Ok(());
    }
    output::line(&format!("{}: {brushes} brushes", options.output.display()));
    if let Some(loaded) = &loaded {
        for (key, value) in about(loaded).as_object().into_iter().flatten() {
            output::pair(key, value);
        }
    }
    Ok(())
}

/// A scene of one mesh.
fn mesh(options: &Import) -> anyhow::Result<(Scene, Option<LoadedMesh>)> {
    let path = input::from_folder(&options.file, &options.output)?;
    let mut shape = Shape::mesh(path);
    if let (Shape::Mesh { resolution, .. }, Some(wanted)) = (&mut shape, options.resolution) {
        *resolution = wanted;
    }
    let mut scene = Scene::new();
    scene
        .push(Brush::new(shape))
        .with_context(|| options.file.display().to_string())?;
    let mut loaded = input::load_meshes(&mut scene, &options.output, options.allow_outside)?;
    Ok((scene, loaded.pop()))
}

/// What a mesh is, and what was done to it.
fn about(loaded: &LoadedMesh) -> Value {
    let repairs = &loaded.repairs;
    let bounds = loaded.grid.solid();
    json!({
        "mesh": loaded.path,
        "mesh_resolution": loaded.resolution,
        "triangles": loaded.triangles,
        "box": [bounds.min.to_array(), bounds.max.to_array()],
        "parts": repairs.parts,
        "holes_closed": repairs.holes,
        "triangles_dropped": repairs.dropped,
        "triangles_turned": repairs.turned,
        "parts_turned": repairs.parts_turned,
        "corners_welded": repairs.welded,
        "sign": "winding number",
        "memory_bytes": size_of_val(loaded.grid.words()),
        "from_cache": loaded.was_kept,
    })
}
