//! `argil edit`.

use crate::args::EditArgs;
use crate::{input, output};
use anyhow::{Context, ensure};
use argil::math::Aabb;
use argil::scene::{Action, Journal, JournalError, Scene};
use argil::volume::EditStats;
use argil::{BricksOptions, EditReport, Representation, World};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) fn run(options: &EditArgs) -> anyhow::Result<()> {
    let outputs = [&options.output, &options.scene_output, &options.journal];
    let outputs: Vec<&Path> = outputs
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    check_outputs(options, &outputs)?;
    let engine = input::engine(&options.on)?;
    ensure!(
        !matches!(options.via, Some(Representation::Mesh(_))),
        "--via mesh: edits are replayed on volumes; use bricks, dense or octree, and run `argil mesh` on the result"
    );
    // A volume file is edited as it is; a scene is baked first.
    let via = (!input::is_volume(&options.scene)?)
        .then_some(options.via.unwrap_or(BricksOptions::default().into()));
    // If two processes begin the same journal, only the one that creates the file continues.
    let begin = |scene: &Scene| match &options.journal {
        Some(path) => Journal::create_new(path, scene).map(Some),
        None => Ok(None),
    };
    // A bake takes a while, and can be killed: the journal is whole before it.
    let mut journal = match via {
        Some(_) => begin(&Scene::open(&options.scene)?)?,
        None => None,
    };
    let about = (None, options.on.allow_external_meshes);
    let built = input::world(&options.scene, &engine, via, &options.volume, about)
        .and_then(|built| input::spare_meshes(&built.0, &options.scene, outputs).map(|()| built));
    let (mut scene, mut world) = match built {
        Ok(built) => built,
        Err(error) => {
            // Nothing is in it yet.
            journal.map_or(Ok(()), Journal::remove)?;
            return Err(error);
        }
    };
    if via.is_none() {
        journal = begin(&scene)?;
    }
    let build_ms = world.build_timings().duration_ms;
    let applied = replay(options, &mut scene, &mut world, journal.as_mut());
    if let (Err(_), Some(path)) = (&applied, &options.journal) {
        let path = path.display();
        eprintln!(
            "note: the edits before that are in {path}: recover them with `argil recover {path} -o SCENE`"
        );
    }
    let applied = applied?;

    let differing = if options.check {
        let count = world.diff_from_rebuild()?;
        Some(count.context("--check compares sparse bricks: use --via bricks")?)
    } else {
        None
    };
    if let Some(path) = &options.scene_output {
        let mut moved = scene.snapshot();
        moved.rename_meshes(&input::moved_meshes(&scene, &options.scene, path)?);
        moved.save(path)?;
        if let Some(journal) = journal {
            journal.remove()?;
        }
    }
    if let Some(path) = &options.output {
        world.rename_meshes(&input::moved_meshes(&scene, &options.scene, path)?);
        world.save(path)?;
    }
    report(options, &scene, &world, build_ms, &applied, differing);
    ensure!(
        differing.is_none_or(|count| count == 0),
        "{} cells differ from a fresh bake",
        differing.unwrap_or(0)
    );
    Ok(())
}

/// Checks the outputs before any work.
fn check_outputs(options: &EditArgs, outputs: &[&Path]) -> anyhow::Result<()> {
    for (index, path) in outputs.iter().enumerate() {
        output::check_place(path, &options.edits)?;
        // A scene can be written back to its own file; other outputs cannot replace the input.
        if options.scene_output.as_deref() != Some(*path) {
            output::check_place(path, &options.scene)?;
        }
        for other in &outputs[..index] {
            ensure!(
                !output::is_same_place(path, other),
                "{}: two outputs would be written to this file: name another",
                path.display()
            );
        }
    }
    if let Some(path) = &options.output {
        output::check_ending(path, "a volume", "argil")?;
    }
    if let Some(path) = &options.scene_output {
        output::check_ending(path, "a scene", "json")?;
    }
    if let Some(path) = &options.journal
        && std::fs::metadata(path).is_ok_and(|about| !about.is_file() || about.len() > 0)
    {
        return Err(JournalError::Exists(path.clone()).into());
    }
    Ok(())
}

/// An applied edit and its timing.
struct EditRecord {
    applied: EditReport,
    counts: EditStats,
    duration_ms: f64,
}

fn replay(
    options: &EditArgs,
    scene: &mut Scene,
    world: &mut World,
    mut journal: Option<&mut Journal>,
) -> anyhow::Result<Vec<EditRecord>> {
    let path = options.edits.display();
    let file = std::fs::File::open(&options.edits).with_context(|| path.to_string())?;
    let mut applied = Vec::new();
    let mut file = BufReader::new(file);
    for index in 1.. {
        let place = || format!("{path}:{index}");
        let Some(line) = next_line(&mut file).with_context(place)? else {
            break;
        };
        // Some editors write a byte order mark.
        let line = match line.strip_prefix('\u{feff}') {
            Some(rest) if index == 1 => rest.to_owned(),
            _ => line,
        };
        if line.trim().is_empty() {
            continue;
        }
        let record = |journal: &mut Option<&mut Journal>| match journal {
            Some(journal) => journal.record(&line).with_context(place),
            None => Ok(()),
        };
        let action = scene.read_action(&line).with_context(place)?;
        // Not an edit, but saved worlds contain the new paths.
        if let Action::RenameMeshes(paths) = &action {
            world.rename_meshes(paths);
        }
        if scene.perform(&action).with_context(place)?.is_none() {
            record(&mut journal)?;
            continue;
        }
        // A mesh that an edit brings is found next to the scene, like the others.
        if !scene.missing_meshes().is_empty() {
            input::load_meshes(scene, &options.scene, options.on.allow_external_meshes)
                .with_context(place)?;
        }
        if !scene.missing_images().is_empty() {
            let folder = options.scene.parent().unwrap_or(Path::new("."));
            argil::load_images(scene, folder, options.on.allow_external_meshes)
                .with_context(place)?;
        }
        let start = Instant::now();
        let applied_edit = world.apply(scene).with_context(place)?;
        // Wait for the GPU, so that the time includes its work.
        let finished = world.flush().with_context(place)?;
        // Record the edit only after the world accepted it.
        record(&mut journal)?;
        applied.push(EditRecord {
            applied: applied_edit,
            counts: finished,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
        });
    }
    Ok(applied)
}

/// Maximum length of a line in an edit log, in bytes.
const MAX_LINE_BYTES: u64 = 64 << 20;

/// Reads the next line, without its line end.
fn next_line(file: &mut impl BufRead) -> anyhow::Result<Option<String>> {
    let mut line = Vec::new();
    file.take(MAX_LINE_BYTES + 1).read_until(b'\n', &mut line)?;
    if line.is_empty() {
        return Ok(None);
    }
    ensure!(
        line.len() as u64 <= MAX_LINE_BYTES,
        "this line is longer than the limit, {MAX_LINE_BYTES} bytes"
    );
    let line = String::from_utf8(line).context("this line is not UTF-8")?;
    Ok(Some(line.trim_end_matches(['\r', '\n']).to_owned()))
}

fn report(
    options: &EditArgs,
    scene: &Scene,
    world: &World,
    build_ms: f64,
    done: &[EditRecord],
    differing: Option<u64>,
) {
    let mut sorted: Vec<f64> = done.iter().map(|d| d.duration_ms).collect();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let last = sorted.len().saturating_sub(1) as f64;
        sorted.get((share * last).round() as usize).copied()
    };
    let rebuilt = done.iter().filter(|d| d.applied.rebuilt).count();
    let bricks: u64 = done.iter().map(|d| d.counts.filled).sum();
    if options.json {
        let edits: Vec<Value> = done.iter().map(edit).collect();
        output::json(&json!({
            "device": world.engine().device(),
            "device_reason": world.engine().selection_reason(),
            "resolution": world.resolution(),
            "brushes": scene.brush_count(),
            "build_ms": build_ms,
            "edits": edits,
            "edit_ms": { "median": at(0.5), "p99": at(0.99), "max": at(1.0) },
            "rebuilt": rebuilt,
            "memory_bytes": world.memory_bytes(),
        "gpu": output::gpu_counters(world.engine()),
            "differing_cells": differing,
        }));
        return;
    }
    let engine = world.engine();
    output::line(&format!(
        "on {}: {}",
        engine.device(),
        engine.selection_reason()
    ));
    output::line(&format!("built in {build_ms:.2} ms"));
    output::line(&format!(
        "{}: median {:.3} ms, p99 {:.3}, max {:.3}; {} sampled",
        output::count(done.len(), "edit"),
        at(0.5).unwrap_or(0.0),
        at(0.99).unwrap_or(0.0),
        at(1.0).unwrap_or(0.0),
        output::count(bricks, "brick")
    ));
    if rebuilt > 0 {
        output::line(&format!(
            "{} caused a rebuild:",
            output::count(rebuilt, "edit")
        ));
        let mut reasons: Vec<String> = done
            .iter()
            .filter_map(|d| d.applied.reason)
            .map(|reason| reason.to_string())
            .collect();
        reasons.sort_unstable();
        for same in reasons.chunk_by(|a, b| a == b) {
            output::line(&format!("  {}: {}", same.len(), same[0]));
        }
    }
    if differing == Some(0) {
        output::line("identical to a fresh bake");
    }
}

fn edit(done: &EditRecord) -> Value {
    let dirty_box = done.applied.dirty_box;
    let Aabb { min, max } = dirty_box;
    // JSON has no number for values that are not finite.
    let held = dirty_box.is_finite() && !dirty_box.is_empty();
    json!({
        "duration_ms": done.duration_ms,
        "bricks": done.counts.filled,
        "added": done.counts.added,
        "removed": done.counts.removed,
        "rebuilt": done.applied.rebuilt,
        "reason": done.applied.reason.map(|reason| reason.to_string()),
        "dirty_box": held.then(|| [min.to_array(), max.to_array()]),
    })
}
