//! `argil mesh`.

use crate::args::{MeshArgs, MeshUnit};
use crate::{input, output};
use anyhow::{Context, ensure};
use argil::mesh::{MeshFormat, MeshReport, MeshWriteOptions, UpAxis};
use argil::scene::TempFolder;
use argil::{MeshOptions, MeshOutput, Representation, World, save_mesh};
use serde_json::json;
use std::path::{Path, PathBuf};

pub(crate) fn run(options: &MeshArgs) -> anyhow::Result<()> {
    // Check the request before any work.
    let format = options.output.as_ref();
    let format = format.map(|path| Ok::<_, anyhow::Error>((path, format_of(path)?)));
    let format = format.transpose()?;
    if let Some((path, _)) = format {
        output::check_place(path, &options.scene)?;
    }
    let how = write_options(options, format.map(|(_, format)| format))?;
    check_representation(options)?;
    let engine = input::engine(&options.on)?;
    // The field gets its resolution with the mesh, not with the build.
    let is_field = options.via.is_none_or(|via| via == Representation::Field)
        && !input::is_volume(&options.scene)?;
    let voxel = options.volume.voxel_size.filter(|_| is_field);
    let resolution = options.volume.resolution;
    let mut flags = options.volume.clone();
    if is_field {
        flags.resolution = None;
        flags.voxel_size = None;
        flags.method = None;
    }
    let about = (options.time, options.on.allow_external_meshes);
    let (scene, world) = input::world(&options.scene, &engine, options.via, &flags, about)?;
    let lods: Vec<PathBuf> = match format {
        Some((path, _)) => (1..=options.lods.unwrap_or(0))
            .map(|lod| lod_path(path, lod))
            .collect(),
        None => Vec::new(),
    };
    for path in &lods {
        output::check_place(path, &options.scene)?;
    }
    let outputs = options.output.iter().chain(&lods);
    input::spare_meshes(&scene, &options.scene, outputs.map(PathBuf::as_path))?;
    let settings = MeshOptions {
        method: options.volume.method.unwrap_or_default(),
        resolution: resolution.unwrap_or(256),
        voxel_size: voxel,
        iso: options.iso,
        normals: options.normals,
        max_triangles: options.max_triangles.map(|n| n as usize),
        materials: format.is_some_and(|(_, format)| format != MeshFormat::Stl),
        unindexed: options.unindexed,
        checks: true,
    };
    let place = || options.scene.display().to_string();
    let meshed = world.mesh(&settings).with_context(place)?;
    output::warn_if_clipped(&meshed.voxel_grid, &options.scene);
    let coarser = match format {
        Some((path, format)) => {
            ensure!(
                meshed.report.triangles > 0,
                "{}: {}; nothing was written",
                options.scene.display(),
                no_surface(options, &world, meshed.voxel_grid.voxel_size)
            );
            let files = MeshFiles::beside(path)?;
            let save = |mesh: &argil::mesh::Mesh, path: &Path| {
                Ok(save_mesh(mesh, format, &how, files.place_of(path))?)
            };
            save(&meshed.mesh, path)?;
            let coarser =
                save_coarser(&world, &settings, &meshed.report, &lods, save).with_context(place)?;
            files.finish(path, coarser.iter().map(|(path, _)| path.as_path()))?;
            for old in lods[coarser.len()..].iter().filter(|old| old.exists()) {
                let old = old.display();
                eprintln!("note: {old} is of an earlier mesh: this one has no such level");
            }
            coarser
        }
        None => Vec::new(),
    };
    print_report(options, &world, &meshed, &coarser);
    Ok(())
}

fn format_of(path: &Path) -> anyhow::Result<MeshFormat> {
    MeshFormat::from_path(path).with_context(|| {
        format!(
            "{}: unknown mesh format; name it {}",
            path.display(),
            MeshFormat::extensions("or")
        )
    })
}

/// Checks that the representation can be meshed, with the other flags.
fn check_representation(options: &MeshArgs) -> anyhow::Result<()> {
    ensure!(
        !matches!(options.via, Some(Representation::Mesh(_))) && !options.volume.flat,
        "--via mesh, --flat: these control rendering; omit them, or use --normals face"
    );
    ensure!(
        !matches!(options.via, Some(Representation::Octree(_))),
        "--via octree: an octree cannot be meshed; use field, dense or bricks"
    );
    if matches!(options.via, Some(Representation::Levels(_))) {
        ensure!(
            options.lods.is_none(),
            "--lods: levels have triangles of several sizes already; use a larger --pixel-error"
        );
        ensure!(
            options.volume.memory_budget.is_none(),
            "--memory-budget: it limits what an image keeps; a mesh needs all of its bricks, so use a larger --pixel-error"
        );
    }
    Ok(())
}

/// Describes why there is no triangle, and what helps.
fn no_surface(options: &MeshArgs, world: &World, voxel_size: f32) -> String {
    let remedy = format!(
        "parts thinner than a voxel, {voxel_size} here, can be lost: raise --resolution, or choose a smaller --voxel-size"
    );
    match options.iso {
        _ if world.program().aabb().is_empty() => "the scene has no solid".to_owned(),
        0.0 => format!("no surface was found; {remedy}"),
        iso => format!("no surface at the iso level {iso} was found in its box; {remedy}"),
    }
}

/// Files of one mesh, which appear together: they are made in a folder beside their places, and renamed when all are there.
struct MeshFiles(TempFolder);

impl MeshFiles {
    fn beside(path: &Path) -> anyhow::Result<Self> {
        let made = TempFolder::beside(path);
        made.map(Self).with_context(|| path.display().to_string())
    }

    /// Returns where a file is made.
    fn place_of(&self, path: &Path) -> PathBuf {
        self.0.path().join(path.file_name().unwrap_or_default())
    }

    /// Gives the files their names.
    fn finish<'a>(
        self,
        path: &'a Path,
        coarser: impl Iterator<Item = &'a Path>,
    ) -> anyhow::Result<()> {
        for path in std::iter::once(path).chain(coarser) {
            std::fs::rename(self.place_of(path), path)
                .with_context(|| path.display().to_string())?;
        }
        Ok(())
    }
}

/// Makes and saves coarser meshes at the given paths, each with a quarter of the triangles of the one before.
fn save_coarser(
    world: &World,
    settings: &MeshOptions,
    report: &MeshReport,
    places: &[PathBuf],
    save: impl Fn(&argil::mesh::Mesh, &Path) -> anyhow::Result<()>,
) -> anyhow::Result<Vec<(PathBuf, MeshOutput)>> {
    let mut coarser = Vec::new();
    let mut before = report.triangles;
    for (lod, beside) in (1u32..).zip(places) {
        let most = report.triangles as usize >> (2 * lod).min(60);
        let fewer = MeshOptions {
            max_triangles: Some(most.max(4)),
            ..*settings
        };
        let fewer = match world.mesh(&fewer) {
            // The surface cannot stay closed with so few triangles.
            Err(argil::MeshError::Simplify(_)) if lod > 1 => break,
            made => made?,
        };
        // The mesh cannot be simplified further, or nothing would be left.
        if fewer.report.triangles == before || fewer.report.triangles == 0 {
            break;
        }
        before = fewer.report.triangles;
        save(&fewer.mesh, beside)?;
        coarser.push((beside.clone(), fewer));
    }
    Ok(coarser)
}

/// `pot.glb` → `pot-2.glb`.
fn lod_path(path: &Path, lod: u32) -> PathBuf {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{name}-{lod}.{ending}"))
}

/// Describes in words whether a surface is closed and manifold.
fn kind(report: &MeshReport) -> &'static str {
    if report.is_watertight() {
        "watertight"
    } else if report.open_edges == 0 {
        "closed, not manifold"
    } else {
        "not watertight"
    }
}

fn write_options(
    options: &MeshArgs,
    format: Option<MeshFormat>,
) -> anyhow::Result<MeshWriteOptions> {
    let axes = options.axes.unwrap_or_default();
    let scale = match options.unit {
        None | Some(MeshUnit::M) => 1.0,
        Some(MeshUnit::Cm) => 100.0,
        Some(MeshUnit::Mm) => 1000.0,
        Some(MeshUnit::In) => 1.0 / 0.0254,
    };
    if format.is_some_and(MeshFormat::is_gltf) {
        ensure!(
            axes == UpAxis::YUp && scale == 1.0,
            "--axes, --unit: glTF is always right-handed, y up and in meters, and importers convert it; omit them, or write .obj, .ply or .stl"
        );
    }
    ensure!(
        format != Some(MeshFormat::ThreeMf) || options.axes.is_none(),
        "--axes: 3MF is always right-handed with z up, and importers convert it; omit it"
    );
    ensure!(
        format.is_some() || (options.axes.is_none() && options.unit.is_none()),
        "--axes and --unit control how a file is written: add -o"
    );
    Ok(MeshWriteOptions { axes, scale })
}

fn print_report(
    options: &MeshArgs,
    world: &World,
    meshed: &MeshOutput,
    lods: &[(PathBuf, MeshOutput)],
) {
    let report = &meshed.report;
    let stages = meshed.stages_ms.iter();
    let stages: serde_json::Map<_, _> = stages
        .map(|(stage, ms)| (stage.to_string(), json!(ms)))
        .collect();
    let build_ms = world.build_timings().duration_ms;
    let mut whole = json!({
        "device": world.engine().device(),
        "via": world.representation().name(),
        "resolution": meshed.voxel_grid.size.to_array(),
        "voxel": meshed.voxel_grid.voxel_size,
        "brushes": world.program().brush_count(),
        "build_ms": build_ms,
        "mesh_ms": meshed.duration_ms,
        "stages_ms": stages,
        "vertices": meshed.mesh.positions.len(),
        "surface_error_voxels": { "rms": meshed.surface_error.rms_voxels, "max": meshed.surface_error.max_voxels },
        "simplification_error": meshed.simplification_error,
        "lods": lods.iter().map(|(path, lod)| json!({
            "mesh": path.display().to_string(),
            "triangles": lod.report.triangles,
            "vertices": lod.mesh.positions.len(),
            "watertight": lod.report.is_watertight(),
            "open_edges": lod.report.open_edges,
            "non_manifold_edges": lod.report.non_manifold_edges,
            "simplification_error": lod.simplification_error,
            "surface_error_voxels": { "rms": lod.surface_error.rms_voxels, "max": lod.surface_error.max_voxels },
        })).collect::<Vec<_>>(),
        "memory_bytes": meshed.mesh.memory_bytes(),
        "gpu": output::gpu_counters(world.engine()),
        "mesh": options.output.as_ref().map(|p| p.display().to_string()),
    });
    output::extend(&mut whole, output::mesh(report));
    if options.json {
        output::json(&whole);
        return;
    }
    if let Some(path) = &options.output {
        output::line(&path.display().to_string());
    }
    output::line(&format!(
        "{} triangles, {} vertices, {}, in {:.1} ms",
        report.triangles,
        meshed.mesh.positions.len(),
        if meshed.voxel_grid.is_clipped && report.open_edges > 0 {
            "open where it is clipped (to close it, intersect the scene with a box)"
        } else {
            kind(report)
        },
        build_ms + meshed.duration_ms
    ));
    for key in [
        "resolution",
        "euler",
        "open_edges",
        "non_manifold_edges",
        "flipped_edges",
        "area",
        "enclosed_volume",
        "surface_error_voxels",
        "memory_bytes",
    ] {
        output::pair(key, &whole[key]);
    }
    for (path, lod) in lods {
        output::line(&format!(
            "{}: {} triangles, surface error at most {:.4}, {}",
            path.display(),
            lod.report.triangles,
            lod.simplification_error,
            kind(&lod.report),
        ));
    }
}
