//! What each experiment shows: sentences, plots, tables, pictures.

use super::plot::{Axes, Bar, Series, bars, lines};
use super::source::Source;
use super::table::{Column, column, megabytes, table, varied};
use crate::record::{Record, quantile};
use crate::shown::number;
use std::collections::BTreeMap;

/// A picture with what stands under it.
pub struct Shown<'a> {
    /// Whose it is.
    pub source: &'a Source,
    /// Which.
    pub name: &'static str,
    /// What is said of it.
    pub text: String,
}

const TIMES: &[Column] = &[
    column("frame, ms", "frame_ms"),
    column("steps a ray", "steps_mean"),
    column("95 % of rays", "steps_p95"),
    column("most", "steps_max"),
    column("samples", "samples_mean"),
    column("nodes", "descents_mean"),
    column("cells", "cells_mean"),
    megabytes("MB", "memory_bytes"),
    column("pixels hit", "hit_pixels"),
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
];

const LIKENESS: &[Column] = &[
    column("FLIP", "flip_mean"),
    column("PSNR, dB", "psnr_db"),
    column("SSIM", "ssim"),
    column("equal pixels (Laplacian)", "laplacian_equal_pixels"),
    column("Laplacian, of 255", "laplacian_mean_abs"),
    column("depth RMS, of the radius", "depth_rms"),
    column("missed pixels", "missed_pixels"),
    column("added pixels", "added_pixels"),
    column("triangles", "triangles"),
    megabytes("MB", "memory_bytes"),
];

const EDITS: &[Column] = &[
    column("edit, ms", "edit_ms"),
    column("bricks an edit", "edited_bricks"),
    column("dirty volume", "dirty_volume"),
    column("brushes", "brushes"),
    column("bricks", "bricks"),
    megabytes("MB", "memory_bytes"),
];

const ERRORS: &[Column] = &[
    column("RMS, voxels", "error_voxels_rms"),
    column("mean", "error_voxels_mean"),
    column("most", "error_voxels_max"),
    column("points", "points"),
    megabytes("MB", "memory_bytes"),
    column("FLIP", "flip_mean"),
    column("PSNR, dB", "psnr_db"),
];

const SURFACES: &[Column] = &[
    column("triangles", "triangles"),
    column("corners", "vertices"),
    megabytes("MB", "memory_bytes"),
    column("mesh, ms", "mesh_ms"),
    column("corners off, voxels RMS", "off_rms_voxels"),
    column("Hausdorff, voxels", "hausdorff_voxels"),
    column("Chamfer, voxels", "chamfer_voxels"),
    column("watertight", "watertight"),
];

const LOST: &[Column] = &[
    column("lost bricks", "lost_bricks"),
    column("bricks", "bricks"),
    column("nodes", "nodes"),
];

/// An experiment's table.
pub fn table_of(name: &str, records: &[&Record], several: bool) -> String {
    let columns = match name {
        "construction" | "dense-fill" | "memory" => BUILDS,
        "fidelity" | "normals" => LIKENESS,
        "strides" | "stored" => ERRORS,
        "edits" => EDITS,
        "triangles" => SURFACES,
        "lost" => LOST,
        _ => TIMES,
    };
    table(records, columns, several)
}

/// Devices in the order of their records.
fn devices<'a>(records: &[&'a Record]) -> Vec<&'a str> {
    let mut all: Vec<&str> = Vec::new();
    for record in records {
        if !all.contains(&record.machine.device.as_str()) {
            all.push(&record.machine.device);
        }
    }
    all
}

/// An experiment's plots.
pub fn plots(name: &str, records: &[&Record]) -> Vec<String> {
    let mut all = Vec::new();
    for device in devices(records) {
        let own: Vec<&Record> = records
            .iter()
            .copied()
            .filter(|r| r.machine.device == device && r.error.is_none())
            .collect();
        match name {
            "construction" => all.extend(construction(&own, device)),
            "dense-fill" => all.push(by_scene(
                &own,
                "build_ms",
                "ms",
                &format!("Building, {device}"),
                true,
            )),
            "frames" | "cameras" => all.push(by_scene(
                &own,
                "frame_ms",
                "ms",
                &format!("Frames, {device}"),
                true,
            )),
            "heat" => all.push(by_scene(
                &own,
                "steps_mean",
                "steps a ray",
                &format!("Mean steps, {device}"),
                false,
            )),
            "fidelity" => {
                all.push(by_scene(
                    &own,
                    "flip_mean",
                    "FLIP",
                    &format!("Error as a viewer sees it, {device}"),
                    false,
                ));
                all.push(histograms(&own, device));
            }
            "strides" => {
                let points = along(&own, "stride", "error_voxels_rms");
                if points.iter().any(|(_, p)| !p.is_empty()) {
                    all.push(lines(
                        axes(
                            "Error within four voxels, 8 bits",
                            "texture stride",
                            "voxels, RMS",
                            true,
                            true,
                        ),
                        &points,
                    ));
                }
                let points = along(&own, "stride", "flip_mean");
                all.push(lines(
                    axes(
                        &format!("Error of the picture, {device}"),
                        "texture stride",
                        "FLIP",
                        true,
                        false,
                    ),
                    &points,
                ));
            }
            "sweep" => all.push(sweep(&own, device)),
            "edits" => all.extend(edits(&own, device)),
            "memory" => {
                let title = format!("Memory, {device}");
                all.push(grouped(
                    &own,
                    |r| format!("{} {}³", r.scene, r.parameter("resolution").unwrap_or(0.0)),
                    "memory_bytes",
                    axes(&title, "", "bytes", false, true),
                ));
            }
            "triangles" => {
                let points = along(&own, "resolution", "chamfer_voxels");
                all.push(lines(
                    axes(
                        "Chamfer distance",
                        "voxels along the longest side",
                        "voxels",
                        true,
                        true,
                    ),
                    &points,
                ));
            }
            _ => {}
        }
    }
    all
}

fn axes<'a>(title: &'a str, x: &'a str, y: &'a str, log_x: bool, log_y: bool) -> Axes<'a> {
    Axes {
        title,
        x,
        y,
        log_y,
        log_x,
    }
}

fn construction(records: &[&Record], device: &str) -> Vec<String> {
    let plain = |r: &&&Record| !r.parameters.contains_key("sort");
    let mut series: Vec<Series> = Vec::new();
    let octree: Vec<&Record> = records
        .iter()
        .copied()
        .filter(|r| r.via == "octree" && plain(&r))
        .collect();
    let points = |own: &[&Record], value: &str| -> Vec<(f64, f64)> {
        let mut all: Vec<(f64, f64)> = own
            .iter()
            .filter_map(|r| Some((r.value("bricks")?, r.value(value)?)))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    };
    for (name, value) in [
        ("octree, all", "build_ms"),
        ("select", "select_ms"),
        ("sort", "sort_ms"),
        ("fill", "fill_ms"),
        ("tree", "tree_ms"),
    ] {
        let own = points(&octree, value);
        if !own.is_empty() {
            series.push((name.into(), own));
        }
    }
    let sorted: Vec<&Record> = records
        .iter()
        .copied()
        .filter(|r| r.via == "octree" && !plain(&r))
        .collect();
    if !sorted.is_empty() {
        series.push(("all, the study's sort".into(), points(&sorted, "build_ms")));
    }
    let title = format!("Building an octree, {device} (the study's figure 21)");
    let line = lines(axes(&title, "bricks", "ms", false, false), &series);
    let mut groups = Vec::new();
    let stages = ["select", "sort", "fill", "tree"];
    let mut stacks: Vec<(String, Vec<Option<Bar>>)> =
        stages.map(|s| (s.to_owned(), Vec::new())).to_vec();
    let mut ordered = octree;
    ordered.sort_by_key(|r| r.value("bricks").unwrap_or(0.0) as u64);
    for record in ordered {
        groups.push(number(record.value("bricks").unwrap_or(0.0)));
        for (stage, (_, own)) in stages.iter().zip(&mut stacks) {
            let value = record.value(&format!("{stage}_ms"));
            own.push(value.map(|value| Bar {
                value,
                reach: (value, value),
            }));
        }
    }
    stacks.retain(|(_, own)| own.iter().any(Option::is_some));
    let title = format!("The same by stage, {device} (figure 22)");
    vec![
        line,
        bars(
            axes(&title, "bricks", "ms", false, false),
            &groups,
            &stacks,
            true,
        ),
    ]
}

/// Bars of a value, a group for each scene (and place of the eye), a colour for each representation.
fn by_scene(records: &[&Record], value: &str, unit: &str, title: &str, log: bool) -> String {
    let group = |r: &Record| {
        let eye = r.parameters.get("eye").and_then(|v| v.as_str());
        match eye.filter(|eye| *eye != "outside") {
            Some(eye) => format!("{}, {eye}", r.scene),
            None => r.scene.clone(),
        }
    };
    grouped(records, group, value, axes(title, "", unit, false, log))
}

fn grouped(
    records: &[&Record],
    group: impl Fn(&Record) -> String,
    value: &str,
    axes: Axes<'_>,
) -> String {
    let mut groups: Vec<String> = Vec::new();
    let mut series: Vec<(String, Vec<Option<Bar>>)> = Vec::new();
    for record in records {
        let Some(median) = record.value(value) else {
            continue;
        };
        let samples = record.samples.get(value);
        let reach = |part| samples.and_then(|s| quantile(s, part)).unwrap_or(median);
        let bar = Bar {
            value: median,
            reach: (reach(0.05), reach(0.95)),
        };
        let own = group(record);
        let at = groups.iter().position(|g| *g == own).unwrap_or_else(|| {
            groups.push(own.clone());
            groups.len() - 1
        });
        let mut name = record.via.clone();
        for key in ["bits", "fill", "normals"] {
            if let Some(value) = record.parameters.get(key) {
                name += &format!(" {}", value.to_string().trim_matches('"'));
            }
        }
        if record.parameters.contains_key("normals") && record.via == "mesh" {
            name += &format!(" {}³", record.parameter("resolution").unwrap_or(0.0));
        }
        let nth = series
            .iter()
            .position(|(n, _)| *n == name)
            .unwrap_or_else(|| {
                series.push((name.clone(), Vec::new()));
                series.len() - 1
            });
        let bars = &mut series[nth].1;
        if bars.len() <= at {
            bars.resize(at + 1, None);
        }
        bars[at] = Some(bar);
    }
    for (_, bars) in &mut series {
        bars.resize(groups.len(), None);
    }
    bars(axes, &groups, &series, false)
}

/// A value along a parameter, a line for each representation (and scene, where there are several).
fn along(records: &[&Record], parameter: &str, value: &str) -> Vec<Series> {
    let mut all: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
    let scenes = records.iter().map(|r| &r.scene);
    let several = scenes.clone().any(|s| Some(s) != scenes.clone().next());
    for record in records {
        if let (Some(x), Some(y)) = (record.parameter(parameter), record.value(value)) {
            let mut name = record.via.clone();
            if record.parameters.contains_key("normals") {
                name += " faces";
            }
            if several {
                name = format!("{}, {name}", record.scene);
            }
            all.entry(name).or_default().push((x, y));
        }
    }
    all.into_iter()
        .map(|(name, mut points)| {
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            (name, points)
        })
        .collect()
}

/// The red channel of the Laplacians' difference, zeros left out, as the study's figure 31 has it.
fn histograms(records: &[&Record], device: &str) -> String {
    let mut series = Vec::new();
    for record in records.iter().filter(|r| r.scene == "teapot") {
        if let Some(counts) = record.samples.get("laplacian_histogram") {
            let points = counts.iter().enumerate().skip(1).filter(|(_, n)| **n > 0.0);
            let points = points.map(|(i, n)| (i as f64, *n)).collect();
            series.push((format!("{} {}", record.via, varied(record)), points));
        }
    }
    // As many as there are colours.
    series.truncate(7);
    let title = format!(
        "Teapot: difference of Laplacians, red, without zeros, {device} (figures 29 to 31)"
    );
    lines(axes(&title, "value", "pixels", false, true), &series)
}

fn sweep(records: &[&Record], device: &str) -> String {
    let group = |r: &Record| {
        let root = if r.parameters.contains_key("descent") {
            ", path"
        } else {
            ""
        };
        format!("{}³{root}", r.parameter("brick").unwrap_or(0.0))
    };
    let most = records
        .iter()
        .filter_map(|r| r.parameter("resolution"))
        .fold(0.0, f64::max);
    let own: Vec<&Record> = records
        .iter()
        .copied()
        .filter(|r| r.parameter("resolution") == Some(most))
        .collect();
    let title = format!("Frames by brick size at {most}³, {device}");
    grouped(
        &own,
        group,
        "frame_ms",
        axes(&title, "voxels along a brick's side", "ms", false, false),
    )
}

fn edits(records: &[&Record], device: &str) -> Vec<String> {
    let bricks: Vec<&Record> = records
        .iter()
        .copied()
        .filter(|r| r.via == "bricks")
        .collect();
    let both = |own: &[&Record], x: &dyn Fn(&Record) -> Option<f64>| -> Vec<Series> {
        let of = |part: f64| {
            let mut points: Vec<(f64, f64)> = own
                .iter()
                .filter_map(|r| Some((x(r)?, quantile(r.samples.get("edit_ms")?, part)?)))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points
        };
        vec![
            ("median".into(), of(0.5)),
            ("99 % of edits".into(), of(0.99)),
        ]
    };
    let crowds: Vec<&Record> = bricks
        .iter()
        .copied()
        .filter(|r| r.scene.starts_with("crowd"))
        .collect();
    let others: Vec<&Record> = bricks
        .iter()
        .copied()
        .filter(|r| !r.scene.starts_with("crowd"))
        .collect();
    let radius = |r: &Record| r.parameter("radius");
    let resolutions: Vec<&Record> = others
        .iter()
        .copied()
        .filter(|r| radius(r) == Some(0.02))
        .collect();
    let most = others
        .iter()
        .filter(|r| radius(r) != Some(0.02))
        .filter_map(|r| r.parameter("resolution"))
        .next();
    let sizes: Vec<&Record> = others
        .iter()
        .copied()
        .filter(|r| r.parameter("resolution") == most)
        .collect();
    let title = |what: &str| format!("{what}, {device}");
    vec![
        lines(
            axes(
                &title("An edit against the number of brushes"),
                "brushes",
                "ms",
                true,
                true,
            ),
            &both(&crowds, &|r| r.value("brushes")),
        ),
        lines(
            axes(
                &title("An edit against the resolution"),
                "voxels along a side",
                "ms",
                true,
                true,
            ),
            &both(&resolutions, &|r| r.parameter("resolution")),
        ),
        lines(
            axes(
                &title("An edit against the volume that it touches"),
                "dirty box, cubic units",
                "ms",
                true,
                true,
            ),
            &both(&sizes, &|r| r.value("dirty_volume")),
        ),
    ]
}

/// What the records say, in words.
pub fn sentences(name: &str, records: &[&Record]) -> Vec<String> {
    let mut all = Vec::new();
    for device in devices(records) {
        let own: Vec<&Record> = records
            .iter()
            .copied()
            .filter(|r| r.machine.device == device && r.error.is_none())
            .collect();
        all.extend(sentence(name, &own).map(|text| format!("On {device}: {text}")));
    }
    let failed = records.iter().filter(|r| r.error.is_some()).count();
    if failed > 0 {
        all.push(format!("{failed} cases failed; their rows say why."));
    }
    all
}

/// The least and the greatest of a value over some records, as text.
fn spread<'a>(records: impl Iterator<Item = &'a &'a Record>, value: &str) -> Option<String> {
    let all: Vec<f64> = records.filter_map(|r| r.value(value)).collect();
    let (least, most) = all
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| {
            (a.min(v), b.max(v))
        });
    (!all.is_empty()).then(|| {
        if least == most {
            number(least)
        } else {
            format!("{} to {}", number(least), number(most))
        }
    })
}

fn sentence(name: &str, own: &[&Record]) -> Option<String> {
    let via = |word: &'static str| own.iter().filter(move |r| r.via == word);
    Some(match name {
        "construction" => {
            let plain = || via("octree").filter(|r| !r.parameters.contains_key("sort"));
            let count = |r: &&&Record| r.value("bricks").unwrap_or(0.0) as u64;
            let (few, many) = (plain().min_by_key(count)?, plain().max_by_key(count)?);
            let all = many.value("build_ms")?;
            let dense = via("dense").find_map(|r| r.value("build_ms"))?;
            let filled = many.value("bricks")? * many.parameter("brick")?.powi(3);
            let times = 1024.0 * 1024.0 * 512.0 / filled;
            format!(
                "an octree of {} brick takes {} ms, one of {} bricks {} ms, of which filling is {} %. Extrapolated to 1024×1024×512 voxels, all of them filled, {} times as many, {} ms. The same volume filled as a dense one takes {} ms.",
                number(few.value("bricks")?),
                number(few.value("build_ms")?),
                number(many.value("bricks")?),
                number(all),
                number(100.0 * many.value("fill_ms")? / all),
                number(times),
                number(times * all),
                number(dense)
            )
        }
        "dense-fill" => {
            let tiled = spread(
                via("dense").filter(|r| !r.parameters.contains_key("fill")),
                "build_ms",
            )?;
            match spread(
                via("dense").filter(|r| r.parameters.contains_key("fill")),
                "build_ms",
            ) {
                Some(naive) => format!(
                    "by tiles a dense volume takes {tiled} ms, a thread a group {naive} ms."
                ),
                None => format!(
                    "a dense volume takes {tiled} ms, an octree {} ms, sparse bricks {} ms.",
                    spread(via("octree"), "build_ms")?,
                    spread(via("bricks"), "build_ms")?
                ),
            }
        }
        "frames" | "cameras" => format!(
            "medians of frames go from {} ms through the field, {} through a dense volume with mips, {} through the octree and {} through sparse bricks.",
            spread(via("field"), "frame_ms")?,
            spread(via("dense, mips"), "frame_ms")?,
            spread(via("octree"), "frame_ms")?,
            spread(via("bricks"), "frame_ms")?
        ),
        "heat" => format!(
            "a ray takes {} steps on average through a dense volume, {} with mips, {} through the octree (nodes and cells counted), {} through sparse bricks.",
            spread(via("dense"), "steps_mean")?,
            spread(via("dense, mips"), "steps_mean")?,
            spread(via("octree"), "steps_mean")?,
            spread(via("bricks"), "steps_mean")?
        ),
        "fidelity" => {
            let faces = spread(
                via("mesh").filter(|r| r.parameters.contains_key("normals")),
                "flip_mean",
            )?;
            let smooth = spread(
                via("mesh").filter(|r| !r.parameters.contains_key("normals")),
                "flip_mean",
            )?;
            format!(
                "FLIP errors against the field's normals are {} for dense volumes, {} for sparse bricks, {faces} for triangles with their own normals and {smooth} for triangles with the field's.",
                spread(via("dense"), "flip_mean")?,
                spread(via("bricks"), "flip_mean")?
            )
        }
        "normals" => format!(
            "differences of Laplacians are {} of 255 {}, {} over the normals of sparse bricks.",
            spread(via("dense"), "laplacian_mean_abs")?,
            if via("dense").count() > 1 {
                "over the biases of a dense volume"
            } else {
                "for a dense volume with a bias of a voxel"
            },
            spread(via("bricks"), "laplacian_mean_abs")?
        ),
        "strides" => {
            let by_flip =
                |r: &&&Record| (1e6 * r.value("flip_mean").unwrap_or(f64::INFINITY)) as u64;
            let best = via("dense")
                .filter(|r| r.value("flip_mean").is_some())
                .min_by_key(by_flip)?;
            format!(
                "of 8 bits, the picture nearest to the field's is that of stride {}, a band of {} voxels; errors go over {}.",
                best.parameter("stride")?,
                number(256.0 / best.parameter("stride")?),
                spread(via("dense"), "flip_mean")?
            )
        }
        "center" => format!(
            "{} bricks are there, those in the middle.",
            spread(via("octree"), "bricks")?
        ),
        "sweep" => {
            let of = |word: &'static str, brick: f64| {
                via(word).filter(move |r| r.parameter("brick") == Some(brick))
            };
            format!(
                "medians of frames through the octree are {} ms with bricks of 8³, {} with 16³, {} with 32³; through sparse bricks {} with 4³, {} with 8³, {} with 16³.",
                spread(of("octree", 8.0), "frame_ms")?,
                spread(of("octree", 16.0), "frame_ms")?,
                spread(of("octree", 32.0), "frame_ms")?,
                spread(of("bricks", 4.0), "frame_ms")?,
                spread(of("bricks", 8.0), "frame_ms")?,
                spread(of("bricks", 16.0), "frame_ms")?
            )
        }
        "edits" => {
            let others = own.iter().filter(|r| r.via != "bricks");
            format!(
                "medians of an edit of sparse bricks are {} ms; the other volumes, which are made again, take {} ms.",
                spread(via("bricks"), "edit_ms")?,
                spread(others, "edit_ms")?
            )
        }
        "memory" => {
            let most = own
                .iter()
                .filter_map(|r| r.parameter("resolution"))
                .fold(0.0, f64::max);
            let of = |word: &'static str| {
                via(word)
                    .filter(move |r| r.parameter("resolution") == Some(most))
                    .filter(|r| !r.parameters.contains_key("bits"))
            };
            let mb = |word| spread(of(word), "memory_bytes");
            format!(
                "at {most}³, bytes are {} for a dense volume, {} with mips, {} for the octree and {} for sparse bricks with 16 bits and materials.",
                mb("dense")?,
                mb("dense, mips")?,
                mb("octree")?,
                mb("bricks")?
            )
        }
        "stored" => {
            let of = |word: &'static str, bits: f64| {
                via(word).filter(move |r| r.parameter("bits") == Some(bits))
            };
            format!(
                "root mean squares are {} voxels for dense volumes of 8 bits, {} of 16; {} for sparse bricks of 8 bits and {} of 16.",
                spread(of("dense", 8.0), "error_voxels_rms")?,
                spread(of("dense", 16.0), "error_voxels_rms")?,
                spread(of("bricks", 8.0), "error_voxels_rms")?,
                spread(of("bricks", 16.0), "error_voxels_rms")?
            )
        }
        "triangles" => {
            let teapot = |faces: bool| {
                let own = via("mesh")
                    .filter(|r| r.scene == "teapot" && r.parameter("resolution") == Some(100.0));
                own.clone()
                    .find(|r| r.parameters.contains_key("normals") == faces)
            };
            let (shared, faces) = (teapot(false)?, teapot(true)?);
            format!(
                "the teapot at 100³ is {} triangles with {} corners ({} MB), or {} where none are shared ({} MB), made in {} ms.",
                number(shared.value("triangles")?),
                number(shared.value("vertices")?),
                number(shared.value("memory_bytes")? / 1e6),
                number(faces.value("vertices")?),
                number(faces.value("memory_bytes")? / 1e6),
                number(shared.value("mesh_ms")?)
            )
        }
        "lost" => {
            let by_center = via("octree").filter(|r| r.parameters.contains_key("keep"));
            let others = own.iter().filter(|r| !r.parameters.contains_key("keep"));
            format!(
                "the study's test, that a brick's centre is within ±4 voxels of the surface, loses {} bricks of 32³ a scene that hold surface, the conservative one and sparse bricks {}.",
                spread(by_center, "lost_bricks")?,
                spread(others, "lost_bricks")?
            )
        }
        _ => return None,
    })
}

/// Whether a record's picture is shown.
pub fn is_shown(record: &Record, part: &str) -> bool {
    match record.experiment.as_str() {
        "fidelity" if part == "laplacian" => record.scene == "teapot",
        "fidelity" => ["teapot", "edgy-cube"].contains(&record.scene.as_str()),
        "heat" | "normals" | "strides" | "center" | "cameras" => part == "picture",
        _ => false,
    }
}

/// Pictures that are shown.
pub fn pictures<'a>(name: &str, sources: &[&'a Source]) -> Vec<Shown<'a>> {
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
                        ": its Laplacian, the difference from a blank picture"
                    } else {
                        ": difference of Laplacians"
                    };
                }
                if let Some(steps) = record.value("steps_mean").filter(|_| name == "heat") {
                    text += &format!(": {} steps a ray", number(steps));
                }
                all.push(Shown {
                    source,
                    name: part,
                    text,
                });
            }
        }
    }
    all
}
