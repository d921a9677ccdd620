//! `argil info`.

use crate::args::Info;
use crate::output;
use anyhow::Context;
use argil::mesh::{MeshFormat, MeshReport};
use argil::scene::NodeKind;
use argil::volume::{VolumeFile, VolumeInfo};
use argil::{Engine, Representation};
use serde_json::{Value, json};

pub(crate) fn run(options: &Info) -> anyhow::Result<()> {
    if crate::input::is_volume(&options.scene)? {
        return of_volume(options);
    }
    if MeshFormat::from_path(&options.scene).is_some() {
        return of_mesh(options);
    }
    if argil::is_volume_file(&options.scene) {
        return of_other_volume(options);
    }
    let scene = crate::input::scene(&options.scene, options.allow_external_meshes)?;
    let world = Engine::cpu()
        .build(&scene)
        .with_context(|| options.scene.display().to_string())?;
    let program = world.program();
    let groups = scene
        .iter()
        .filter(|&id| matches!(scene.node(id).desc().kind, NodeKind::Group))
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
        "instructions": program.instructions().len(),
        "stack_slots": program.stack_slots(),
        "memory_bytes": program.memory_bytes(),
    });
    print(options, &report);
    Ok(())
}

/// Describes a mesh file: its triangles as they are, with vertices welded by position.
fn of_mesh(options: &Info) -> anyhow::Result<()> {
    let file = argil::mesh::read(&options.scene)?;
    let (mesh, mut warnings) = (file.mesh, file.warnings);
    let is_odd = |t: &&[u32; 3]| t.iter().any(|&i| !mesh.positions[i as usize].is_finite());
    let odd = mesh.triangles.iter().filter(is_odd).count();
    if odd > 0 {
        warnings.push(format!(
            "triangles with vertices that are not finite: {odd}; they are left out"
        ));
    }
    output::warn(&options.scene, &warnings);
    anyhow::ensure!(
        !mesh.triangles.is_empty(),
        "{}: it contains no triangle",
        options.scene.display()
    );
    let report = MeshReport::of(&mesh.welded());
    let mut about = output::mesh(&report);
    let counts = json!({
        "vertices": mesh.positions.len(),
        "welded_vertices": report.vertices,
        "warnings": warnings,
    });
    output::extend(&mut about, counts);
    print(options, &about);
    Ok(())
}

/// Describes a volume file: its contents, and the scene it was made from.
fn of_volume(options: &Info) -> anyhow::Result<()> {
    let stored = VolumeFile::open(&options.scene)?;
    let scene = crate::input::scene_of(&stored, &options.scene)?;
    let mut report = output::volume(
        Representation::of(&stored.volume),
        &VolumeInfo::of(&stored.volume),
    );
    if let Some(report) = report.as_object_mut() {
        report.insert("scene".into(), json!(scene.name));
        report.insert("brushes".into(), json!(scene.brush_count()));
        let bytes = std::fs::metadata(&options.scene).map(|m| m.len());
        report.insert("file_bytes".into(), json!(bytes.unwrap_or(0)));
    }
    print(options, &report);
    Ok(())
}

/// Describes a volume of another program: the first grid of single numbers, and the names of the others.
fn of_other_volume(options: &Info) -> anyhow::Result<()> {
    let read = argil::read_volume(&options.scene, &argil::VolumeReadOptions::default())?;
    let solid = read.grid.solid();
    let bytes = std::fs::metadata(&options.scene).map(|about| about.len());
    let report = json!({
        "grid": read.name,
        "other_grids": read.other_grids,
        "class": if read.is_fog { "fog" } else { "level-set" },
        "voxel": read.voxel_size,
        "voxels": read.voxels,
        "scale": read.scale,
        "box": [solid.min.to_array(), solid.max.to_array()],
        "file_bytes": bytes.unwrap_or(0),
    });
    print(options, &report);
    Ok(())
}

fn print(options: &Info, report: &Value) {
    if options.json {
        output::json(report);
        return;
    }
    for (key, value) in report.as_object().into_iter().flatten() {
        output::pair(key, value);
    }
}
