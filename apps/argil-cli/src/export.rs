//! `argil bake -o` for other programs.

use crate::args::BakeArgs;
use crate::{input, output};
use anyhow::{Context, ensure};
use argil::{ExportClass, ExportFormat, ExportOptions, ExportReport, World};
use serde_json::{Map, json};
use std::path::Path;

/// A format of other programs.
#[derive(Clone, Copy)]
pub(crate) enum OutputFormat {
    /// One file.
    File(ExportFormat),
    /// An OME-Zarr folder.
    Zarr,
}

impl OutputFormat {
    fn from_path(path: &Path) -> Option<Self> {
        let is_zarr = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("zarr"));
        let file = ExportFormat::from_path(path).map(Self::File);
        file.or(is_zarr.then_some(Self::Zarr))
    }

    fn extension(self) -> &'static str {
        match self {
            Self::File(format) => format.extension(),
            Self::Zarr => "zarr",
        }
    }
}

/// Returns the format of an output file for other programs. `None` for a volume of Argil.
pub(crate) fn format_of(options: &BakeArgs) -> anyhow::Result<Option<OutputFormat>> {
    let format = options.output.as_deref().and_then(OutputFormat::from_path);
    let flags = &options.export;
    ensure!(
        format.is_some()
            || (flags.class.is_none()
                && flags.codec.is_none()
                && !flags.colors
                && !flags.keep_bounds),
        "--class, --keep-bounds, --codec and --colors apply to volumes for other programs: write -o FILE.vdb, .nvdb, .npy, .nrrd, .raw or .zarr"
    );
    Ok(format)
}

/// Rejects flags that do not apply to the format.
fn check_flags(options: &BakeArgs, format: OutputFormat) -> anyhow::Result<()> {
    let ending = format.extension();
    let is_sparse = matches!(format, OutputFormat::File(file) if file.is_sparse());
    ensure!(
        is_sparse || !options.export.keep_bounds,
        "--keep-bounds: a .{ending} file has the field's values in any case; omit it"
    );
    let has_band = is_sparse
        || options.export.class == Some(ExportClass::Fog)
        || matches!(format, OutputFormat::File(ExportFormat::FlipBook));
    ensure!(
        has_band || options.volume.band.is_none(),
        "--band: a .{ending} file has distances everywhere; omit it"
    );
    let volume = &options.volume;
    let others = [
        (options.via.is_some(), "--via"),
        (volume.mips, "--mips"),
        (volume.stride.is_some(), "--stride"),
        (volume.brick.is_some(), "--brick"),
        (volume.memory_budget.is_some(), "--memory-budget"),
        (volume.pixel_error.is_some(), "--pixel-error"),
        (volume.depth.is_some(), "--depth"),
        (volume.keep.is_some(), "--keep"),
        (volume.descent.is_some(), "--descent"),
        (volume.sort.is_some(), "--sort"),
        (volume.method.is_some(), "--method"),
        (volume.flat, "--flat"),
        (volume.fill.is_some(), "--fill"),
        (options.repeat > 1, "--repeat"),
        (options.count_lost, "--count-lost"),
    ];
    for (is_given, flag) in others {
        ensure!(
            !is_given,
            "{flag}: a .{ending} file is sampled from the field; omit it"
        );
    }
    Ok(())
}

fn write(
    world: &World,
    path: &Path,
    format: OutputFormat,
    how: &ExportOptions,
) -> anyhow::Result<ExportReport> {
    match format {
        OutputFormat::File(_) => Ok(world.export(path, how)?),
        #[cfg(feature = "zarr")]
        OutputFormat::Zarr => Ok(world.export_zarr(path, how)?),
        #[cfg(not(feature = "zarr"))]
        OutputFormat::Zarr => anyhow::bail!(
            "this program was compiled without OME-Zarr: use `cargo run --release --features zarr -- bake …`"
        ),
    }
}

/// Returns the length of a file, or of all files in a folder.
fn bytes_of(path: &Path) -> u64 {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().map(|entry| bytes_of(&entry.path())).sum(),
        Err(_) => std::fs::metadata(path).map_or(0, |file| file.len()),
    }
}

pub(crate) fn run(options: &BakeArgs, path: &Path, format: OutputFormat) -> anyhow::Result<()> {
    // A folder may be replaced by another.
    if !(matches!(format, OutputFormat::Zarr) && path.is_dir()) {
        output::check_place(path, &options.scene)?;
    }
    if matches!(format, OutputFormat::File(ExportFormat::Raw)) {
        output::check_place(&path.with_extension("raw.json"), &options.scene)?;
    }
    check_flags(options, format)?;
    let volume = &options.volume;
    let default = ExportOptions::default();
    let how = ExportOptions {
        resolution: volume.resolution.unwrap_or(default.resolution),
        voxel_size: volume.voxel_size,
        class: options.export.class.unwrap_or_default(),
        half_width_voxels: volume.band.unwrap_or(default.half_width_voxels),
        keep_bounds: options.export.keep_bounds,
        bits: volume
            .bits
            .map_or(default.bits, |bits| 8 * bits.bytes() as u32),
        codec: options.export.codec.unwrap_or_default(),
        colors: options.export.colors,
    };
    let engine = input::engine(&options.on)?;
    let mut scene = input::scene(&options.scene, options.on.allow_external_meshes)?;
    input::set_time(&mut scene, options.time, &options.scene)?;
    input::spare_meshes(&scene, &options.scene, Some(path))?;
    let place = || options.scene.display().to_string();
    let world = engine.build(&scene).with_context(place)?.field();
    let report = write(&world, path, format, &how).with_context(place)?;
    if report.is_clipped {
        let box_text = "the scene is infinite, and is cut off at its box";
        eprintln!(
            "warning: {}: {box_text}: set view.bounds to choose another",
            place()
        );
    }
    let bytes = bytes_of(path);
    let stages: Map<_, _> = report
        .stages_ms
        .iter()
        .map(|(stage, ms)| (stage.to_string(), json!(ms)))
        .collect();
    let all = json!({
        "volume": path.display().to_string(),
        "device": world.engine().device(),
        "resolution": report.bounds.map(|[low, high]| [0, 1, 2].map(|axis| high[axis] - low[axis] + 1)),
        "brushes": world.program().brush_count(),
        "export_ms": report.duration_ms,
        "stages_ms": stages,
        "voxel": report.voxel_size,
        "first_voxel": report.bounds.map(|[low, _]| low),
        "last_voxel": report.bounds.map(|[_, high]| high),
        "tiles": report.tiles,
        "voxels": report.voxels,
        "file_bytes": bytes,
    });
    if options.json {
        output::json(&all);
        return Ok(());
    }
    output::line(&path.display().to_string());
    output::line(&format!(
        "{} voxels in {:.1} ms, {} bytes",
        report.voxels, report.duration_ms, bytes
    ));
    if report.tiles.is_some() {
        output::pair("tiles", &all["tiles"]);
    }
    for key in ["voxel", "first_voxel", "last_voxel", "stages_ms"] {
        output::pair(key, &all[key]);
    }
    Ok(())
}
