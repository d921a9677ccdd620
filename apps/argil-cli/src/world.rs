//! `argil world`: a world as tiles, baked by many workers.

use crate::output;
use crate::world_args::{
    OnPlan, WorldArgs, WorldBake, WorldCommand, WorldEdit, WorldExport, WorldFinish, WorldPlanArgs,
    WorldStatus,
};
use anyhow::{Context, ensure};
use argil::math::Control;
use argil::scene::Scene;
use argil::volume::{BrickSettings, Encoding};
use argil_world::{
    BakeReport, PlanOptions, Shard, Store, StoredWorld, TileCacheOptions, WorldPlan,
};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

pub(crate) fn run(options: &WorldArgs) -> anyhow::Result<()> {
    match &options.command {
        WorldCommand::Plan(options_of_command) => plan(options_of_command),
        WorldCommand::Bake(options_of_command) => bake(options_of_command),
        WorldCommand::Status(options_of_command) => status(options_of_command),
        WorldCommand::Finish(options_of_command) => finish(options_of_command),
        WorldCommand::Edit(options_of_command) => edit(options_of_command),
        WorldCommand::Export(options_of_command) => export(options_of_command),
    }
}

/// Sets the number of threads, and shows progress.
fn control(threads: Option<u16>) -> anyhow::Result<Control> {
    if let Some(threads) = threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        let built = pool.build_global();
        built.map_err(|error| argil::EngineError::Threads(error.to_string()))?;
    }
    Ok(crate::progress::control())
}

fn plan(options: &WorldPlanArgs) -> anyhow::Result<()> {
    let control = control(options.how.threads)?;
    let output = match &options.output {
        Some(path) => path.clone(),
        None => {
            let name = options.scene.file_stem();
            let name = name.context("the scene's path has no file name")?;
            Path::new(name).with_extension("world.json")
        }
    };
    output::check_place(&output, &options.scene)?;
    let scene = crate::input::scene(&options.scene, options.how.allow_external_meshes)?;
    // Without a folder, a name lies in this one.
    let folder = |path: &Path| Path::new(".").join(path.parent().unwrap_or(path));
    ensure!(
        scene.mesh_paths().is_empty()
            || std::path::absolute(folder(&output))?
                == std::path::absolute(folder(&options.scene))?,
        "{}: the scene names meshes by their place in its folder: write the plan beside it with -o",
        output.display()
    );
    let start = Instant::now();
    let plan_options = PlanOptions {
        voxel_size: options.voxel_size,
        encoding: Encoding {
            format: options
                .bits
                .unwrap_or(BrickSettings::default().encoding.format),
            ..BrickSettings::default().encoding
        },
    };
    let made = WorldPlan::with_control(&scene, &plan_options, &control)
        .with_context(|| options.scene.display().to_string())?;
    let plan_ms = start.elapsed().as_secs_f64() * 1e3;
    argil::scene::write_atomically(&output, |out| {
        std::io::Write::write_all(out, made.to_json().as_bytes())
    })
    .with_context(|| output.display().to_string())?;
    let report = json!({
        "plan": output,
        "hash": made.hash(),
        "size": made.size(),
        "levels": made.levels(),
        "tiles": made.tile_count(),
        "tiles_of_tiers": made.tiles(),
        "plan_ms": plan_ms,
    });
    if options.how.json {
        output::json(&report);
        return Ok(());
    }
    let [x, y, z] = made.size();
    output::line(&output.display().to_string());
    output::line(&format!(
        "{x} × {y} × {z} voxels, at most {} tiles, planned in {plan_ms:.0} ms; its folder in a store is {}",
        made.tile_count(),
        made.hash()
    ));
    Ok(())
}

/// Reads a plan, and its scene with meshes.
fn planned(on: &OnPlan) -> anyhow::Result<(WorldPlan, Scene)> {
    let plan = WorldPlan::open(&on.plan)?;
    let mut scene = plan.scene()?;
    crate::input::load_meshes(&mut scene, &on.plan, on.how.allow_external_meshes)?;
    Ok((plan, scene))
}

fn bake(options: &WorldBake) -> anyhow::Result<()> {
    let control = control(options.on.how.threads)?;
    let shard = match options.shard {
        Some(shard) => shard,
        None => Shard::from_environment(options.shards, |name| std::env::var(name).ok())
            .map_err(anyhow::Error::msg)?
            .unwrap_or(Shard::WHOLE),
    };
    let (plan, scene) = planned(&options.on)?;
    let store = Store::create(&options.on.store)?;
    let done = argil_world::bake(&plan, &scene, &store, shard, &control)?;
    let report = report(&done, &plan, shard)?;
    if options.on.how.json {
        output::json(&report);
        return Ok(());
    }
    output::line(&format!(
        "shard {}/{}: {} tiles, {} were there, {} baked, {} empty, {:.1} MB, in {:.1} s",
        shard.index,
        shard.count,
        done.tiles,
        done.present,
        done.baked,
        done.empty,
        done.bytes as f64 * 1e-6,
        1e-3 * (done.plan_ms + done.bake_ms)
    ));
    Ok(())
}

fn report(done: &BakeReport, plan: &WorldPlan, shard: Shard) -> anyhow::Result<Value> {
    let mut report = serde_json::to_value(done)?;
    report["hash"] = plan.hash().into();
    report["shard"] = json!([shard.index, shard.count]);
    Ok(report)
}

fn status(options: &WorldStatus) -> anyhow::Result<()> {
    let control = control(options.on.how.threads)?;
    let (plan, scene) = planned(&options.on)?;
    let store = Store::open(&options.on.store)?;
    let found = argil_world::status(&plan, &scene, &store, options.verify, &control)?;
    let missing = found.tiles - found.present;
    if options.on.how.json {
        output::json(&json!({
            "hash": plan.hash(),
            "tiles": found.tiles,
            "present": found.present,
            "missing": missing,
            "damaged": found.damaged.iter().map(|(address, _)| address.to_string()).collect::<Vec<_>>(),
            "bytes": found.bytes,
            "finished": found.is_finished,
        }));
        return Ok(());
    }
    output::line(&format!(
        "{} of {} tiles are there ({:.1} MB), {missing} are missing{}; {}",
        found.present,
        found.tiles,
        found.bytes as f64 * 1e-6,
        if options.verify {
            format!(", {} are damaged", found.damaged.len())
        } else {
            String::new()
        },
        if found.is_finished {
            "finished"
        } else {
            "not finished"
        }
    ));
    for (address, reason) in found.damaged.iter().take(10) {
        output::line(&format!("damaged: {address}: {reason}"));
    }
    Ok(())
}

fn finish(options: &WorldFinish) -> anyhow::Result<()> {
    let control = control(options.on.how.threads)?;
    let (plan, scene) = planned(&options.on)?;
    let store = Store::open(&options.on.store)?;
    let done = argil_world::finish(&plan, &scene, &store, options.verify, &control)?;
    let place = format!("{}/manifest.json", store.within(plan.hash()).place());
    if options.on.how.json {
        output::json(&json!({
            "hash": plan.hash(),
            "manifest": place,
            "tiles": done.tiles,
            "bytes": done.bytes,
        }));
        return Ok(());
    }
    output::line(&format!(
        "{place}: {} tiles, {:.1} MB",
        done.tiles,
        done.bytes as f64 * 1e-6
    ));
    Ok(())
}

fn edit(options: &WorldEdit) -> anyhow::Result<()> {
    let place = options.edits.display().to_string();
    let lines = std::fs::read_to_string(&options.edits).with_context(|| place.clone())?;
    let mut world = StoredWorld::open(&options.world, &TileCacheOptions::default())?;
    let saved = world.save_edits(&lines, &place)?;
    let brushes = world.scene().brush_count();
    if options.json {
        output::json(&json!({
            "hash": world.plan().hash(),
            "saved": saved,
            "files_of_edits": world.deltas().len(),
            "brushes": brushes,
        }));
    } else {
        output::line(&format!("{saved}: the world has {brushes} brushes now"));
    }
    Ok(())
}

fn export(options: &WorldExport) -> anyhow::Result<()> {
    let control = control(options.threads)?;
    let world = StoredWorld::open(&options.world, &TileCacheOptions::from_environment())?;
    let (output, voxel_size) = (&options.output, options.voxel_size);
    let is_zarr = output
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("zarr"));
    let done = if is_zarr {
        zarr(&world, output, voxel_size, &control)?
    } else {
        world.export_3d_tiles(output, voxel_size, &control)?
    };
    if done.edits_left_out > 0 {
        eprintln!(
            "warning: {}: edits that were saved beside it are not part of its tiles, and not exported",
            options.world
        );
    }
    if done.missing > 0 {
        eprintln!(
            "warning: {}: the export is coarser where tiles are missing or damaged ({}): see `argil world status`",
            options.world, done.missing
        );
    }
    if options.json {
        output::json(&json!({
            "output": output,
            "format": if is_zarr { "ome-zarr" } else { "3d-tiles" },
            "levels": done.levels,
            "files": done.files,
            "bytes": done.bytes,
            "triangles": done.triangles,
            "missing": done.missing,
            "edits_left_out": done.edits_left_out,
        }));
        return Ok(());
    }
    output::line(&format!(
        "{}: {} levels, {} {}, {:.1} MB",
        output.display(),
        done.levels,
        done.files,
        if is_zarr { "shards" } else { "meshes" },
        done.bytes as f64 * 1e-6
    ));
    Ok(())
}

#[cfg(feature = "zarr")]
fn zarr(
    world: &StoredWorld,
    output: &Path,
    voxel_size: Option<f32>,
    control: &Control,
) -> anyhow::Result<argil_world::WorldExportReport> {
    Ok(world.export_zarr(output, voxel_size, control)?)
}

#[cfg(not(feature = "zarr"))]
fn zarr(
    _: &StoredWorld,
    output: &Path,
    _: Option<f32>,
    _: &Control,
) -> anyhow::Result<argil_world::WorldExportReport> {
    anyhow::bail!(
        "{}: this program was built without OME-Zarr: build it with `--features world,zarr`",
        output.display()
    )
}
