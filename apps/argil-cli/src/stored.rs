//! Worlds that are read from a store.

use crate::args::{RenderArgs, VolumeArgs};
use crate::input;
use anyhow::{Context, ensure};
use argil::scene::Scene;
use argil::{Engine, LevelsOptions, Representation, World};
use argil_world::{PlanOptions, ReadMode, Store, StoredWorld, TileCacheOptions, WorldPlan};
use serde_json::{Value, json};
use std::path::Path;

/// Problems that are printed.
const PRINTED: usize = 5;

/// Opens what is rendered: a scene, a volume, or a world in a store.
pub(crate) fn opened(
    options: &RenderArgs,
    engine: &Engine,
) -> anyhow::Result<(Scene, World, Option<StoredWorld>)> {
    let outside = options.on.allow_external_meshes;
    let stored = match &options.store {
        Some(address) => {
            let how = (options.via, &options.volume);
            of_scene(&options.scene, engine, how, address, outside)?
        }
        None if input::is_stored_world(&options.scene) => {
            open(&options.scene, engine, options.via, &options.volume)?
        }
        None => {
            let (scene, world) = input::world(
                &options.scene,
                engine,
                options.via,
                &options.volume,
                (options.time, outside),
            )?;
            return Ok((scene, world, None));
        }
    };
    let (mut scene, mut world, stored) = stored;
    if options.time.is_some() {
        input::set_time(&mut scene, options.time, &options.scene)?;
        world.apply(&scene)?;
    }
    Ok((scene, world, Some(stored)))
}

/// Opens a world whose pages all come from a store. What the store lacks stays coarse.
fn open(
    place: &Path,
    engine: &Engine,
    via: Option<Representation>,
    flags: &VolumeArgs,
) -> anyhow::Result<(Scene, World, StoredWorld)> {
    let address = place.to_str().context("the address is no text")?;
    ensure!(
        via.is_none_or(|via| matches!(via, Representation::Levels(_)))
            && flags.resolution.is_none()
            && flags.voxel_size.is_none()
            && flags.bits.is_none(),
        "{address}: a stored world has levels of detail and voxels of its own: omit --via, --resolution, --voxel-size and --bits"
    );
    let stored = StoredWorld::open(address, &TileCacheOptions::from_environment())?;
    let options = options(&stored, engine, flags)?;
    let (scene, world) = stored.build(engine, options, ReadMode::Wait)?;
    Ok((scene, world, stored))
}

/// Opens the world of a scene, whose pages come from a store as far as that has them, and else from the field.
fn of_scene(
    path: &Path,
    engine: &Engine,
    (via, flags): (Option<Representation>, &VolumeArgs),
    address: &str,
    outside: bool,
) -> anyhow::Result<(Scene, World, StoredWorld)> {
    let voxel_size = flags.voxel_size.with_context(
        || "--store needs the voxels of the plan: add --via levels --voxel-size LENGTH",
    )?;
    ensure!(
        via.is_some_and(|via| matches!(via, Representation::Levels(_))),
        "--store has pages of levels of detail: add --via levels"
    );
    let scene = input::scene(path, outside)?;
    let wanted = input::representation(via.unwrap_or_default(), flags, engine)?;
    let encoding = match wanted {
        Representation::Levels(options) => options.settings.encoding,
        _ => LevelsOptions::default().settings.encoding,
    };
    let place = || path.display().to_string();
    let plan = WorldPlan::without_tiles(
        &scene,
        &PlanOptions {
            voxel_size,
            encoding,
        },
    );
    let plan = plan.with_context(place)?;
    let store = Store::open(address)?;
    let stored =
        StoredWorld::of_scene(&plan, &scene, &store, &TileCacheOptions::from_environment())?;
    if !stored.is_begun()? {
        eprintln!(
            "warning: {address}: there is no world of this scene with these voxels ({}): all is baked",
            plan.hash()
        );
    }
    let options = options(&stored, engine, flags)?;
    let (scene, world) = stored.build(engine, options, ReadMode::WaitOrBake)?;
    Ok((scene, world, stored))
}

fn options(
    stored: &StoredWorld,
    engine: &Engine,
    flags: &VolumeArgs,
) -> anyhow::Result<LevelsOptions> {
    let stored_options = stored.levels_options();
    let asked = input::representation(stored_options.into(), flags, engine)?;
    let Representation::Levels(asked) = asked else {
        return Ok(stored_options);
    };
    Ok(LevelsOptions {
        pixel_error: asked.pixel_error,
        memory_budget: asked.memory_budget,
        ..stored_options
    })
}

/// Warns of tiles that were missing or damaged.
pub(crate) fn warn(stored: &StoredWorld, bakes_missing: bool) {
    let problems = stored.problems();
    let instead = if bakes_missing {
        "it was baked"
    } else {
        "the picture is coarser there"
    };
    for (address, reason) in problems.iter().take(PRINTED) {
        if !bakes_missing || !reason.contains("does not have it") {
            eprintln!("warning: tile {address}: {reason}: {instead}");
        }
    }
    if !bakes_missing && problems.len() > PRINTED {
        eprintln!(
            "warning: {} more tiles are missing",
            problems.len() - PRINTED
        );
    }
}

/// Describes what came from the store.
pub(crate) fn report(stored: &StoredWorld) -> Value {
    let [tiles, bytes] = stored.fetched();
    json!({
        "tile_requests": tiles,
        "tile_bytes_fetched": bytes,
        "tiles_missing": stored.problems().len(),
    })
}
