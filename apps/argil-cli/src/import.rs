//! `argil import`.

use crate::args::Import;
use crate::{input, output};
use anyhow::{Context, ensure};
use argil::mesh::{MeshFormat, MeshWriteOptions};
use argil::scene::{Brush, Scene, Shape};
use argil::{ExportClass, LoadedMesh, RawLayout, VolumeReadOptions};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

pub(crate) fn run(options: &Import) -> anyhow::Result<()> {
    output::check_place(&options.output, &options.file)?;
    output::check_ending(&options.output, "a scene", "json")?;
    let is_volume = argil::is_volume_file(&options.file);
    check_volume_flags(options, is_volume)?;
    if is_volume {
        return volume(options);
    }
    let is_mesh = MeshFormat::from_path(&options.file).is_some();
    let is_sampled = is_mesh || argil::scene::is_image(&options.file.to_string_lossy());
    if !is_sampled {
        input::refuse_unknown(&options.file)?;
    }
    ensure!(
        is_sampled || options.resolution.is_none(),
        "--resolution applies to meshes and heightmaps, and {} is neither: omit it",
        options.file.display()
    );
    ensure!(
        is_mesh || options.thickness.is_none(),
        "--thickness applies to meshes, and {} is not one: omit it",
        options.file.display()
    );
    let (mut scene, loaded) = if is_sampled {
        from_file(options)?
    } else {
        refuse_scenes(&options.file)?;
        (Scene::import_tree(&options.file)?, None)
    };
    scene.name = options
        .file
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    // Report a scene that cannot be lowered now, not when it is rendered.
    argil::field::Program::lower(&scene).with_context(|| options.file.display().to_string())?;
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
    output::line(&format!(
        "{}: {}",
        options.output.display(),
        output::count(brushes, "brush")
    ));
    if let Some(loaded) = &loaded {
        for (key, value) in about(loaded).as_object().into_iter().flatten() {
            output::pair(key, value);
        }
    }
    Ok(())
}

/// Rejects flags of volumes for other files, and the other way round.
fn check_volume_flags(options: &Import, is_volume: bool) -> anyhow::Result<()> {
    let given = &options.volume;
    let flags = [
        (given.grid.is_some(), "--grid"),
        (given.class.is_some(), "--class"),
        (given.iso.is_some(), "--iso"),
        (given.shape.is_some(), "--shape"),
        (given.r#type.is_some(), "--type"),
        (given.voxel_size.is_some(), "--voxel-size"),
        (given.origin.is_some(), "--origin"),
    ];
    for (is_given, flag) in flags {
        ensure!(
            is_volume || !is_given,
            "{flag} applies to volumes, and {} is not one: omit it",
            options.file.display()
        );
    }
    Ok(())
}

/// Rejects flags that do not fit a volume's format.
fn check_flags_of_volume(options: &Import) -> anyhow::Result<()> {
    let flag = [
        (options.resolution.is_some(), "--resolution"),
        (options.thickness.is_some(), "--thickness"),
    ];
    for (is_given, flag) in flag {
        ensure!(
            !is_given,
            "{flag} applies to meshes, and {} is a volume: omit it",
            options.file.display()
        );
    }
    let given = &options.volume;
    let ending = options.file.extension().unwrap_or_default();
    let is = |names: &[&str]| names.iter().any(|name| ending.eq_ignore_ascii_case(name));
    for (is_given, flag, fits) in [
        (given.shape.is_some(), "--shape", is(&["raw"])),
        (given.r#type.is_some(), "--type", is(&["raw"])),
        (
            given.voxel_size.is_some(),
            "--voxel-size",
            !is(&["vdb", "nvdb"]),
        ),
        (given.origin.is_some(), "--origin", !is(&["vdb", "nvdb"])),
    ] {
        ensure!(
            fits || !is_given,
            "{flag}: {} says that itself; omit it",
            options.file.display()
        );
    }
    Ok(())
}

/// Creates a scene that contains the solid of a volume. Its samples go next to the scene, as a .grid file.
fn volume(options: &Import) -> anyhow::Result<()> {
    check_flags_of_volume(options)?;
    let given = &options.volume;
    ensure!(
        given.iso.is_none_or(f32::is_finite),
        "--iso: the value must be a number"
    );
    let how = VolumeReadOptions {
        grid: given.grid.clone(),
        is_fog: given.class.map(|class| class == ExportClass::Fog),
        iso: given.iso,
        raw: RawLayout {
            shape: given.shape,
            number: given.r#type.unwrap_or_default(),
            voxel_size: given.voxel_size,
            origin: given.origin,
        },
    };
    let read = argil::read_volume(&options.file, &how)?;
    let stem = |path: &Path| {
        path.file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let others: Vec<&str> = read
        .other_grids
        .iter()
        .map(String::as_str)
        .filter(|_| given.grid.is_none())
        .collect();
    if !others.is_empty() {
        eprintln!(
            "note: {}: only the grid {:?} is read, and not {}: colors of voxels are left out, and --grid reads another one",
            options.file.display(),
            read.name,
            others.join(", ")
        );
    }
    let name = stem(&options.file);
    let solid = read.grid.solid();
    let memory = size_of_val(read.grid.words());
    let mut scene = Scene::new();
    scene.name = name;
    scene
        .push(Brush::new(Shape::sampled(stem(&options.output), read.grid)))
        .with_context(|| options.file.display().to_string())?;
    argil::field::Program::lower(&scene).with_context(|| options.file.display().to_string())?;
    scene.save(&options.output)?;
    let all = json!({
        "scene": options.output.display().to_string(),
        "brushes": 1,
        "grid": read.name,
        "other_grids": read.other_grids,
        "class": if read.is_fog { "fog" } else { "level-set" },
        "voxel": read.voxel_size,
        "voxels": read.voxels,
        "scale": read.scale,
        "box": [solid.min.to_array(), solid.max.to_array()],
        "memory_bytes": memory,
    });
    if options.json {
        output::json(&all);
        return Ok(());
    }
    output::line(&format!("{}: 1 brush", options.output.display()));
    for key in ["grid", "class", "voxel", "voxels", "box", "memory_bytes"] {
        output::pair(key, &all[key]);
    }
    if read.scale != 1.0 {
        output::pair("scale", &all["scale"]);
    }
    Ok(())
}

/// Rejects a file that is already a scene before it is parsed as a tree.
fn refuse_scenes(path: &Path) -> anyhow::Result<()> {
    // A file that is not regular, such as a pipe, can be read only once.
    if !path.is_file() {
        return Ok(());
    }
    let text = std::fs::read(path).with_context(|| path.display().to_string())?;
    let object: Option<serde_json::Map<String, Value>> = serde_json::from_slice(&text).ok();
    ensure!(
        !object.is_some_and(|object| object.contains_key("argil")),
        "{}: this is already a scene; render it directly",
        path.display()
    );
    Ok(())
}

/// Writes the mesh with its open parts turned into walls, and returns the new file's path.
fn thickened(options: &Import, thickness: f32) -> anyhow::Result<PathBuf> {
    let read = argil::mesh::read(&options.file)?;
    output::warn(&options.file, &read.warnings);
    let (mesh, parts) = argil::mesh::thicken(&read.mesh, thickness);
    ensure!(
        parts > 0,
        "--thickness: {} has no open edges: omit it",
        options.file.display()
    );
    let stem = options.output.file_stem().unwrap_or_default();
    let name = format!("{}-thick.ply", stem.to_string_lossy());
    let place = options.output.with_file_name(name);
    output::check_place(&place, &options.file)?;
    argil::save_mesh(&mesh, MeshFormat::Ply, &MeshWriteOptions::default(), &place)?;
    Ok(place)
}

/// Creates a scene that contains one mesh or heightmap.
fn from_file(options: &Import) -> anyhow::Result<(Scene, Option<LoadedMesh>)> {
    let file = match options.thickness {
        Some(thickness) => thickened(options, thickness)?,
        None => options.file.clone(),
    };
    let path = input::from_folder(&file, &options.output)?;
    let mut shape = Shape::from_file(path);
    if let (Some((_, resolution, _)), Some(wanted)) = (shape.file_mut(), options.resolution) {
        *resolution = wanted;
    }
    let mut scene = Scene::new();
    scene
        .push(Brush::new(shape))
        .with_context(|| options.file.display().to_string())?;
    let folder = options.output.parent().unwrap_or(Path::new("."));
    let mut loaded = argil::load_meshes(&mut scene, folder, options.allow_external_meshes)?;
    let loaded = loaded.pop();
    if let Some(heights) = loaded.as_ref().filter(|loaded| loaded.grid.has_heights()) {
        // The ground keeps the aspect ratio of the image.
        scene = Scene::new();
        scene.push(Brush::new(heights.shape()))?;
    }
    if let Some(loaded) = &loaded {
        output::warn(&options.file, &loaded.warnings());
    }
    Ok((scene, loaded))
}

/// Describes a mesh and its repairs.
fn about(loaded: &LoadedMesh) -> Value {
    if loaded.grid.has_heights() {
        return json!({"heightmap": loaded.path, "posts": loaded.grid.posts(), "warnings": loaded.warnings()});
    }
    let repairs = &loaded.repairs;
    let bounds = loaded.grid.solid();
    json!({
        "mesh": loaded.path,
        "mesh_resolution": loaded.resolution,
        "triangles": loaded.triangles,
        "box": [bounds.min.to_array(), bounds.max.to_array()],
        "parts": repairs.parts,
        "holes_closed": repairs.holes,
        "sheets_dropped": repairs.sheets,
        "warnings": loaded.warnings(),
        "triangles_dropped": repairs.dropped,
        "triangles_flipped": repairs.flipped,
        "parts_flipped": repairs.parts_flipped,
        "vertices_merged": repairs.welded,
        "sign": "winding number",
        "memory_bytes": size_of_val(loaded.grid.words()),
        "from_cache": loaded.from_cache,
    })
}
