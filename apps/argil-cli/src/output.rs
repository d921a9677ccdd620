//! Output of the commands.

use crate::args::RenderArgs;
use anyhow::Context;
use argil::mesh::MeshReport;
use argil::render::Percentiles;
use argil::volume::{FillStats, Levels, VolumeInfo, VoxelGrid};
use argil::{BuildTimings, Engine, Representation};
use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Prints a line to stdout. Ignores a closed pipe, but not a full disk.
pub(crate) fn line(text: &str) {
    if let Err(error) = writeln!(std::io::stdout(), "{text}")
        && error.kind() != std::io::ErrorKind::BrokenPipe
    {
        eprintln!("argil: stdout: {error}");
        std::process::exit(1);
    }
}

/// Keys of `--json` that got other names, with their former ones. Scripts may read either.
const FORMER_KEYS: &[(&str, &str)] = &[
    ("is_clipped", "is_cut_by_box"),
    ("max_bricks", "most_bricks"),
    ("parts_flipped", "parts_turned"),
    ("sheets_dropped", "sheets_left_out"),
    ("simplification_error", "simplified_by"),
    ("surface_error_voxels", "off_voxels"),
    ("triangles_flipped", "triangles_turned"),
    ("vertices_merged", "corners_welded"),
    ("welded_vertices", "places"),
];

/// Prints one JSON object. Values with a former key appear under both keys.
pub(crate) fn json(value: &Value) {
    line(&with_former_keys(value).to_string());
}

fn with_former_keys(value: &Value) -> Value {
    match value {
        Value::Object(members) => {
            let mut all = serde_json::Map::new();
            for (key, value) in members {
                let value = with_former_keys(value);
                if let Some((_, former)) = FORMER_KEYS.iter().find(|(now, _)| now == key) {
                    all.insert((*former).into(), value.clone());
                }
                all.insert(key.clone(), value);
            }
            Value::Object(all)
        }
        Value::Array(entries) => Value::Array(entries.iter().map(with_former_keys).collect()),
        other => other.clone(),
    }
}

pub(crate) fn spread(s: Percentiles) -> Value {
    json!({ "mean": s.mean, "p95": s.p95, "max": s.max })
}

/// Formats a number of things, such as `1 brush` or `2 brushes`.
pub(crate) fn count(number: impl std::fmt::Display, one: &str) -> String {
    let number = number.to_string();
    let ending = match one {
        _ if number == "1" => "",
        _ if one.ends_with("sh") => "es",
        _ => "s",
    };
    format!("{number} {one}{ending}")
}

/// Prints warnings about a file to standard error.
pub(crate) fn warn(path: &Path, warnings: &[String]) {
    for warning in warnings {
        eprintln!("warning: {}: {warning}", path.display());
    }
}

/// Prints a line of a human-readable report.
pub(crate) fn pair(key: &str, value: &Value) {
    let text = readable(value);
    if !text.is_empty() {
        line(&format!("{:18} {text}", key.replace('_', " ")));
    }
}

/// Formats a value: numbers with up to six significant digits, lists in brackets, and objects as names and values.
fn readable(value: &Value) -> String {
    let all = |texts: Vec<String>| texts.join(", ");
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => rounded(number.as_f64().unwrap_or_default()),
        Value::Array(values) => format!("[{}]", all(values.iter().map(readable).collect())),
        Value::Object(map) => {
            let pair = |(key, value): (&String, &Value)| {
                format!("{} {}", key.replace('_', " "), readable(value))
            };
            all(map.iter().map(pair).collect())
        }
        _ => value.to_string(),
    }
}

/// Formats a number with up to six significant digits.
fn rounded(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 5 - value.abs().log10().floor() as i32;
    let unit = 10f64.powi(digits);
    ((value * unit).round() / unit).to_string()
}

/// Describes a volume.
pub(crate) fn volume(via: Representation, info: &VolumeInfo) -> Value {
    let bounds = info.voxel_grid.aabb();
    let mut about = json!({
        "via": via.name(),
        "resolution": info.voxel_grid.size.to_array(),
        "box": [bounds.min.to_array(), bounds.max.to_array()],
        "voxel": info.voxel_grid.voxel_size,
        // An infinite solid ends at the box.
        "is_clipped": info.voxel_grid.is_clipped,
        "bits": 8 * info.encoding.format.bytes(),
        "band_voxels": info.encoding.band.voxels(),
        "memory_bytes": info.memory_bytes,
    });
    let more = match (&info.octree, &info.bricks) {
        (None, None) => json!({ "levels": info.levels }),
        (None, Some(sparse)) => {
            let cells = sparse.layout.size_cells().to_array().map(u64::from);
            json!({
                "brick": sparse.layout.brick_size_voxels(),
                "bricks": sparse.bricks,
                "max_bricks": cells.iter().product::<u64>(),
                "brick_bytes": sparse.bricks * sparse.layout.brick_bytes(),
            })
        }
        (Some(tree), _) => {
            let side = u64::from(tree.layout.brick_size_voxels);
            let texel = info.encoding.format.bytes() as u64;
            json!({
                "brick": side,
                "depth": tree.layout.depth,
                "bricks": tree.bricks,
                "max_bricks": tree.layout.capacity(),
                "nodes": tree.nodes,
                "brick_bytes": tree.bricks * side * side * side * texel,
            })
        }
    };
    extend(&mut about, more);
    about
}

/// Describes what levels of detail hold, and what a view brought.
pub(crate) fn levels(levels: &Levels, refined: &FillStats, coarse: &[f64]) -> Value {
    let mean = coarse.iter().sum::<f64>() / coarse.len().max(1) as f64;
    let mut sorted = coarse.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let grid = levels.layout().finest_grid();
    json!({
        "finest_voxels": grid.size.to_array(),
        "finest_voxel": grid.voxel_size,
        "pages": levels.page_count(),
        "resident_bricks": levels.resident_bricks(),
        "levels_bytes": levels.memory_bytes(),
        "bricks_baked": refined.bricks,
        "bricks_evicted": refined.evicted,
        "bricks_missing": refined.remaining,
        "is_full": refined.is_full,
        "pixel_error": levels.effective_pixel_error(),
        "coarse_share": json!({
            "mean": mean,
            "median": median,
            "max": coarse.iter().copied().fold(0.0, f64::max),
        }),
    })
}

/// Warns that an infinite solid ends at a box.
pub(crate) fn warn_if_clipped(grid: &VoxelGrid, path: &Path) {
    if grid.is_clipped {
        let bounds = grid.aabb();
        eprintln!(
            "warning: {}: the scene is infinite, and is clipped at {:.4?} to {:.4?}: set view.bounds to choose another box",
            path.display(),
            bounds.min.to_array(),
            bounds.max.to_array()
        );
    }
}

/// The part of a box's longest side within which its end is near.
const NEAR_END: f32 = 0.05;

/// Warns that an infinite solid ends at a box, if the camera is outside of it or near its end.
pub(crate) fn warn_if_clipped_near(grid: &VoxelGrid, eye: [f32; 3], path: &Path) {
    let bounds = grid.aabb();
    let within = bounds.grown(-NEAR_END * bounds.size().max_element());
    let around = [0, 2]
        .iter()
        .all(|&axis: &usize| within.min[axis] <= eye[axis] && eye[axis] <= within.max[axis]);
    if !around || bounds.size().max_element() < (1 << 20) as f32 * grid.voxel_size {
        warn_if_clipped(grid, path);
    }
}

/// Describes a mesh.
pub(crate) fn mesh(report: &MeshReport) -> Value {
    let bounds = report.aabb;
    json!({
        "triangles": report.triangles,
        "watertight": report.is_watertight(),
        "euler": report.euler_characteristic,
        "open_edges": report.open_edges,
        "non_manifold_edges": report.non_manifold_edges,
        "flipped_edges": report.flipped_edges,
        "degenerate_triangles": report.degenerate_triangles,
        "area": report.area,
        "enclosed_volume": report.volume,
        "box": (report.triangles > 0).then(|| [bounds.min.to_array(), bounds.max.to_array()]),
    })
}

/// Adds the keys of one report to another.
pub(crate) fn extend(report: &mut Value, more: Value) {
    if let (Some(report), Value::Object(more)) = (report.as_object_mut(), more) {
        report.extend(more);
    }
}

/// Describes what the GPU was asked to do, or returns null on the CPU.
pub(crate) fn gpu_counters(engine: &Engine) -> Value {
    engine.gpu_counters().map_or(Value::Null, |counters| {
        json!({
            "submissions": counters.submissions,
            "waits": counters.waits,
            "buffers": counters.buffers,
            "pipelines": counters.pipelines,
        })
    })
}

/// Describes the timings of a build's stages.
pub(crate) fn stages(times: &BuildTimings) -> Value {
    let stages = times.stages_ms.iter();
    Value::Object(
        stages
            .map(|(stage, ms)| (stage.to_string(), json!(ms)))
            .collect(),
    )
}

pub(crate) fn median(samples: &[f64]) -> f64 {
    times(samples)["median"].as_f64().unwrap_or(0.0)
}

/// Returns minimum, median, 95th percentile and maximum of durations.
pub(crate) fn times(samples: &[f64]) -> Value {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index =
            ((sorted.len() as f64 * share).ceil() as usize).clamp(1, sorted.len().max(1)) - 1;
        sorted.get(index).copied().unwrap_or(0.0)
    };
    json!({ "min": at(0.0), "median": at(0.5), "p95": at(0.95), "max": at(1.0) })
}

/// Returns true if two paths refer to one file, whether or not it exists.
pub(crate) fn is_same_place(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path
            .parent()
            .filter(|p| !p.as_os_str().is_empty())
            .unwrap_or(Path::new("."));
        Some((folder.canonicalize().ok()?, path.file_name()?.to_owned()))
    };
    place(a).is_some_and(|a| place(b) == Some(a))
}

/// Rejects an output path that cannot be written, or that is the input, before any work.
pub(crate) fn check_place(path: &Path, input: &Path) -> anyhow::Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let found = std::fs::metadata(folder)
        .with_context(|| format!("{}: cannot write into this folder", folder.display()))?;
    anyhow::ensure!(found.is_dir(), "{}: not a folder", folder.display());
    anyhow::ensure!(
        !path.is_dir(),
        "{}: this is a folder; name a file",
        path.display()
    );
    anyhow::ensure!(
        !path.exists() || path.is_file(),
        "{}: not a regular file, and writing would replace it; name another file",
        path.display()
    );
    let same = path
        .canonicalize()
        .is_ok_and(|p| input.canonicalize().is_ok_and(|i| i == p));
    anyhow::ensure!(
        !same,
        "{}: this is the input; name another file",
        path.display()
    );
    Ok(())
}

/// File extensions that name another format than the one written.
const KINDS: [&str; 17] = [
    "3mf", "argil", "gif", "glb", "gltf", "jpg", "json", "npy", "nrrd", "nvdb", "obj", "ply",
    "png", "stl", "vdb", "xyz", "zarr",
];

/// Rejects a path whose extension names another format than `what`, whose own extension is `own`.
pub(crate) fn check_ending(path: &Path, what: &str, expected: &str) -> anyhow::Result<()> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let ending = ending.to_lowercase();
    anyhow::ensure!(
        ending == expected || !KINDS.contains(&ending.as_str()),
        "{}: the output is {what}, not a .{ending} file: name it .{expected}",
        path.display()
    );
    Ok(())
}

/// Returns the path of the image, or `None` for an orbit without -o.
pub(crate) fn picture_path(options: &RenderArgs) -> anyhow::Result<Option<PathBuf>> {
    if let Some(path) = &options.output {
        let is_png = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("png"));
        anyhow::ensure!(
            is_png,
            "{}: images are written as PNG; name it .png",
            path.display()
        );
        return Ok(Some(path.clone()));
    }
    if options.frames.is_some() {
        return Ok(None);
    }
    let name = options
        .scene
        .file_stem()
        .context("the scene's path has no file name")?;
    Ok(Some(Path::new(name).with_extension("png")))
}

/// `pot.png` → `pot-0007.png`.
pub(crate) fn numbered(path: &Path, i: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{i:04}.png"))
}
