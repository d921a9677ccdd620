//! Plots of each experiment.

use super::devices::done_by_device;
use super::plot::{PlotAxes, PlotBar, Series, bars, lines};
use super::table::varied;
use crate::formatting::number;
use crate::record::{Record, quantile};
use std::collections::{BTreeMap, BTreeSet};

/// Returns an experiment's plots.
pub(super) fn plots(name: &str, records: &[&Record]) -> Vec<String> {
    let mut all = Vec::new();
    for (device, of_device) in done_by_device(records) {
        match name {
            "construction" => all.extend(construction(&of_device, device)),
            "dense-fill" | "bakes" => {
                let title = format!("Build time, {device}");
                all.push(by_scene(&of_device, "build_ms", "ms", &title, true));
            }
            "frames" | "cameras" => {
                let title = format!("Frame time, {device}");
                all.push(by_scene(&of_device, "frame_ms", "ms", &title, true));
            }
            "heat" => {
                let title = format!("Mean steps, {device}");
                all.push(by_scene(
                    &of_device,
                    "steps_mean",
                    "steps per ray",
                    &title,
                    false,
                ));
            }
            "fidelity" => {
                let title = format!("FLIP error, {device}");
                all.push(by_scene(&of_device, "flip_mean", "FLIP", &title, false));
                all.push(histograms(&of_device, device));
            }
            "convergence" => all.extend(convergence(&of_device, device)),
            "strides" => all.extend(strides(&of_device, device)),
            "sweep" => all.push(sweep(&of_device, device)),
            "edits" => all.extend(edits(&of_device, device)),
            "memory" => all.push(memory(&of_device, device)),
            "triangles" => all.push(triangles(&of_device)),
            _ => {}
        }
    }
    all.retain(|plot| !plot.is_empty());
    all
}

fn axes<'a>(title: &'a str, x: &'a str, y: &'a str, log_x: bool, log_y: bool) -> PlotAxes<'a> {
    PlotAxes {
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
    let points = |some: &[&Record], value: &str| -> Vec<(f64, f64)> {
        let mut all: Vec<(f64, f64)> = some
            .iter()
            .filter_map(|r| Some((r.value("bricks")?, r.value(value)?)))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    };
    for (name, value) in [
        ("octree, total", "build_ms"),
        ("select", "select_ms"),
        ("sort", "sort_ms"),
        ("fill", "fill_ms"),
        ("tree", "tree_ms"),
    ] {
        let curve = points(&octree, value);
        if !curve.is_empty() {
            series.push((name.into(), curve));
        }
    }
    let sorted: Vec<&Record> = records
        .iter()
        .copied()
        .filter(|r| r.via == "octree" && !plain(&r))
        .collect();
    if !sorted.is_empty() {
        series.push((
            "total, the study's sort".into(),
            points(&sorted, "build_ms"),
        ));
    }
    let title = format!("Octree build time, {device} (the study's figure 21)");
    let line = lines(axes(&title, "bricks", "ms", false, false), &series);
    let mut groups = Vec::new();
    let stages = ["select", "sort", "fill", "tree"];
    let mut stacks: Vec<(String, Vec<Option<PlotBar>>)> =
        stages.map(|s| (s.to_owned(), Vec::new())).to_vec();
    let mut ordered = octree;
    ordered.sort_by_key(|r| r.value("bricks").unwrap_or(0.0) as u64);
    for record in ordered {
        groups.push(number(record.value("bricks").unwrap_or(0.0)));
        for (stage, (_, stack)) in stages.iter().zip(&mut stacks) {
            let value = record.value(&format!("{stage}_ms"));
            stack.push(value.map(|value| PlotBar {
                value,
                reach: (value, value),
            }));
        }
    }
    stacks.retain(|(_, bars)| bars.iter().any(Option::is_some));
    let title = format!("Octree build time by stage, {device} (the study's figure 22)");
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

/// Plots bars of a value: a group per scene and camera, a color per representation.
fn by_scene(records: &[&Record], value: &str, unit: &str, title: &str, log: bool) -> String {
    let resolutions: BTreeSet<u64> = records
        .iter()
        .filter_map(|r| Some(r.parameter("resolution")? as u64))
        .collect();
    let group = |r: &Record| {
        let mut name = r.scene.clone();
        if let Some(resolution) = r.parameter("resolution").filter(|_| resolutions.len() > 1) {
            name += &format!(" {resolution}³");
        }
        let eye = r.parameters.get("eye").and_then(|v| v.as_str());
        if let Some(eye) = eye.filter(|eye| *eye != "outside") {
            name += &format!(", {eye}");
        }
        if r.parameters.contains_key("light") {
            name += ", lit";
        }
        name
    };
    grouped(records, group, value, axes(title, "", unit, false, log))
}

fn grouped(
    records: &[&Record],
    group: impl Fn(&Record) -> String,
    value: &str,
    axes: PlotAxes<'_>,
) -> String {
    let mut groups: Vec<String> = Vec::new();
    let mut series: Vec<(String, Vec<Option<PlotBar>>)> = Vec::new();
    for record in records {
        let Some(median) = record.value(value) else {
            continue;
        };
        let samples = record.samples.get(value);
        let reach = |part| samples.and_then(|s| quantile(s, part)).unwrap_or(median);
        let bar = PlotBar {
            value: median,
            reach: (reach(0.05), reach(0.95)),
        };
        let group_name = group(record);
        let at = groups
            .iter()
            .position(|g| *g == group_name)
            .unwrap_or_else(|| {
                groups.push(group_name.clone());
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
        let index = series
            .iter()
            .position(|(n, _)| *n == name)
            .unwrap_or_else(|| {
                series.push((name.clone(), Vec::new()));
                series.len() - 1
            });
        let bars = &mut series[index].1;
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

/// Plots a value over a parameter: a line per representation, and per scene if there are several.
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

/// Plots the red channel of the Laplacians' difference without zeros, as the study's figure 31.
fn histograms(records: &[&Record], device: &str) -> String {
    let mut series = Vec::new();
    for record in records.iter().filter(|r| r.scene == "teapot") {
        if let Some(counts) = record.samples.get("laplacian_histogram") {
            let points = counts.iter().enumerate().skip(1).filter(|(_, n)| **n > 0.0);
            let points = points.map(|(i, n)| (i as f64, *n)).collect();
            series.push((format!("{} {}", record.via, varied(record)), points));
        }
    }
    // There are seven colors.
    series.truncate(7);
    let title = format!(
        "Teapot: difference of Laplacians, red, nonzero, {device} (the study's figures 29 to 31)"
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
    let some: Vec<&Record> = records
        .iter()
        .copied()
        .filter(|r| r.parameter("resolution") == Some(most))
        .collect();
    let title = format!("Frame time by brick size at {most}³, {device}");
    grouped(
        &some,
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
    let both = |some: &[&Record], x: &dyn Fn(&Record) -> Option<f64>| -> Vec<Series> {
        let of = |part: f64| {
            let mut points: Vec<(f64, f64)> = some
                .iter()
                .filter_map(|r| Some((x(r)?, quantile(r.samples.get("edit_ms")?, part)?)))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points
        };
        vec![
            ("median".into(), of(0.5)),
            ("99th percentile".into(), of(0.99)),
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
                &title("Edit time by number of brushes"),
                "brushes",
                "ms",
                true,
                true,
            ),
            &both(&crowds, &|r| r.value("brushes")),
        ),
        lines(
            axes(
                &title("Edit time by resolution"),
                "voxels along a side",
                "ms",
                true,
                true,
            ),
            &both(&resolutions, &|r| r.parameter("resolution")),
        ),
        lines(
            axes(
                &title("Edit time by touched volume"),
                "volume of the dirty box, cubic units",
                "ms",
                true,
                true,
            ),
            &both(&sizes, &|r| r.value("dirty_volume")),
        ),
    ]
}

fn strides(records: &[&Record], device: &str) -> Vec<String> {
    let mut all = Vec::new();
    let points = along(records, "stride", "error_voxels_rms");
    if points.iter().any(|(_, p)| !p.is_empty()) {
        let title = "Error within four voxels, 8 bits";
        let axes = axes(title, "texture stride", "voxels, RMS", true, true);
        all.push(lines(axes, &points));
    }
    let points = along(records, "stride", "flip_mean");
    let title = format!("Image error, {device}");
    let axes = axes(&title, "texture stride", "FLIP", true, false);
    all.push(lines(axes, &points));
    all
}

/// Plots the error of images over the resolution: a plot per render mode, a line per scene.
fn convergence(records: &[&Record], device: &str) -> Vec<String> {
    let modes = [("shaded", "with light"), ("normal", "normals")];
    let plot = |(mode, words): (&str, &str)| {
        let of_mode = |r: &&&Record| r.parameters.get("show").is_some_and(|v| v == mode);
        let of_mode_only: Vec<&Record> = records.iter().filter(of_mode).copied().collect();
        let title = format!("Image error, {words}, {device}");
        let x = "voxels along the longest side";
        lines(
            axes(&title, x, "FLIP", true, true),
            &along(&of_mode_only, "resolution", "flip_mean"),
        )
    };
    modes.map(plot).to_vec()
}

fn memory(records: &[&Record], device: &str) -> String {
    let title = format!("Memory, {device}");
    let group = |r: &Record| format!("{} {}³", r.scene, r.parameter("resolution").unwrap_or(0.0));
    let axes = axes(&title, "", "bytes", false, true);
    grouped(records, group, "memory_bytes", axes)
}

fn triangles(records: &[&Record]) -> String {
    let points = along(records, "resolution", "chamfer_voxels");
    let along = "voxels along the longest side";
    lines(
        axes("Chamfer distance", along, "voxels", true, true),
        &points,
    )
}
