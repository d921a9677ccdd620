//! Tables and images of each experiment.

use super::source::StoredRecord;
use super::table::{Column, column, megabytes, table, varied};
use crate::formatting::number;
use crate::record::Record;

/// An image with a caption.
pub(super) struct Figure<'a> {
    /// The record of the image.
    pub source: &'a StoredRecord,
    /// Name of the image.
    pub name: &'static str,
    /// The caption.
    pub text: String,
}

const TIMES: &[Column] = &[
    column("frame, ms", "frame_ms"),
    column("steps per ray", "steps_mean"),
    column("95th percentile", "steps_p95"),
    column("max", "steps_max"),
    column("samples", "samples_mean"),
    column("nodes", "descents_mean"),
    column("cells", "cells_mean"),
    megabytes("MB", "memory_bytes"),
    column("pixels hit", "hit_pixels"),
    column("with read-back, ms", "frame_wall_ms"),
    column("edit and frame, ms", "edit_and_frame_ms"),
    CLOCK,
    SUBMISSIONS,
    WAITS,
];

/// The clock of a GPU while a case was measured.
const CLOCK: Column = column("GPU clock, MHz", "gpu_clock_mhz");
const SUBMISSIONS: Column = column("submissions", "submissions");
const WAITS: Column = column("waits", "waits");

const FIRST_USES: &[Column] = &[
    column("open, ms", "open_ms"),
    column("first use, ms", "first_ms"),
    column("second use, ms", "second_ms"),
    column("pipelines", "pipelines_first"),
    column("submissions", "submissions_second"),
    column("waits", "waits_second"),
    column("buffers", "buffers_second"),
];

const BUILDS: &[Column] = &[
    column("bricks", "bricks"),
    column("nodes", "nodes"),
    column("build, ms", "build_ms"),
    column("select", "select_ms"),
    column("sort", "sort_ms"),
    column("prune", "prune_ms"),
    column("fill", "fill_ms"),
    column("tree", "tree_ms"),
    megabytes("MB", "memory_bytes"),
    CLOCK,
    SUBMISSIONS,
    WAITS,
];

const IMAGE_ERROR_COLUMNS: &[Column] = &[
    column("FLIP", "flip_mean"),
    column("PSNR, dB", "psnr_db"),
    column("SSIM", "ssim"),
    column("equal pixels (Laplacian)", "laplacian_equal_pixels"),
    column("Laplacian difference (of 255)", "laplacian_mean_abs"),
    column("depth RMS / radius", "depth_rms"),
    column("missed pixels", "missed_pixels"),
    column("added pixels", "added_pixels"),
    column("triangles", "triangles"),
    megabytes("MB", "memory_bytes"),
];

const EDITS: &[Column] = &[
    column("edit, ms", "edit_ms"),
    column("bricks per edit", "edited_bricks"),
    column("dirty volume", "dirty_volume"),
    column("brushes", "brushes"),
    column("bricks", "bricks"),
    megabytes("MB", "memory_bytes"),
    CLOCK,
    SUBMISSIONS,
    WAITS,
];

const ERRORS: &[Column] = &[
    column("RMS, voxels", "error_voxels_rms"),
    column("mean", "error_voxels_mean"),
    column("max", "error_voxels_max"),
    column("points", "points"),
    megabytes("MB", "memory_bytes"),
    column("FLIP", "flip_mean"),
    column("PSNR, dB", "psnr_db"),
];

const SURFACES: &[Column] = &[
    column("triangles", "triangles"),
    column("vertices", "vertices"),
    megabytes("MB", "memory_bytes"),
    column("mesh, ms", "mesh_ms"),
    column("vertex error, voxels RMS", "off_rms_voxels"),
    column("Hausdorff, voxels", "hausdorff_voxels"),
    column("Chamfer, voxels", "chamfer_voxels"),
    column("watertight", "watertight"),
    CLOCK,
    SUBMISSIONS,
    WAITS,
];

const LOST: &[Column] = &[
    column("lost bricks", "lost_bricks"),
    column("bricks", "bricks"),
    column("nodes", "nodes"),
];

/// Returns an experiment's table.
pub(super) fn table_of(name: &str, records: &[&Record], several: bool) -> String {
    let columns = match name {
        "construction" | "dense-fill" | "bakes" | "memory" => BUILDS,
        "pipelines" => FIRST_USES,
        "fidelity" | "convergence" | "normals" => IMAGE_ERROR_COLUMNS,
        "strides" | "stored" => ERRORS,
        "edits" => EDITS,
        "triangles" => SURFACES,
        "lost" => LOST,
        _ => TIMES,
    };
    table(records, columns, several)
}

/// Returns true if a record's image is shown.
pub(crate) fn is_shown(record: &Record, part: &str) -> bool {
    match record.experiment.as_str() {
        "fidelity" if part == "laplacian" => record.scene == "teapot",
        "fidelity" => ["teapot", "edgy-cube"].contains(&record.scene.as_str()),
        "heat" | "normals" | "strides" | "center" | "cameras" => part == "picture",
        _ => false,
    }
}

/// Returns the images to show.
pub(super) fn pictures<'a>(name: &str, sources: &[&'a StoredRecord]) -> Vec<Figure<'a>> {
    let mut all = Vec::new();
    for source in sources {
        let record = &source.record;
        for part in ["picture", "laplacian"] {
            if is_shown(record, part) && record.pictures.contains_key(part) {
                let mut text = format!("{}, {}", record.scene, record.via);
                let more = varied(record);
                if !more.is_empty() {
                    text += &format!(", {more}");
                }
                if part == "laplacian" {
                    text += if record.via == "field" {
                        ": its Laplacian, the difference from a blank image"
                    } else {
                        ": difference of Laplacians"
                    };
                }
                if let Some(steps) = record.value("steps_mean").filter(|_| name == "heat") {
                    text += &format!(": {} steps per ray", number(steps));
                }
                all.push(Figure {
                    source,
                    name: part,
                    text,
                });
            }
        }
    }
    all
}
