//! `argil bake`.

use crate::args::BakeArgs;
use crate::{input, output};
use anyhow::{Context, ensure};
use argil::volume::Volume;
use argil::{BricksOptions, DenseOptions, Representation, World};
use serde_json::{Map, Value, json};

pub(crate) fn run(options: &BakeArgs) -> anyhow::Result<()> {
    if let (Some(format), Some(path)) = (crate::export::format_of(options)?, &options.output) {
        return crate::export::run(options, path, format);
    }
    let dense = options.volume.mips || options.volume.fill.is_some();
    let via = options.via.unwrap_or(if dense {
        DenseOptions::default().into()
    } else {
        BricksOptions::default().into()
    });
    // Check the request before any work.
    ensure!(
        via != Representation::Field,
        "--via field: volumes are baked from the field; use dense, octree or bricks"
    );
    ensure!(
        !matches!(via, Representation::Mesh(_)),
        "--via mesh: use `argil mesh` to make triangles, or bake dense, octree or bricks"
    );
    ensure!(
        !matches!(via, Representation::Levels(_)),
        "--via levels: use `argil render`, which bakes what its view needs, or bake dense, octree or bricks"
    );
    ensure!(
        !options.count_lost || matches!(via, Representation::Octree(_)),
        "--count-lost counts bricks: add --via octree"
    );
    if let Some(path) = &options.output {
        output::check_place(path, &options.scene)?;
        output::check_ending(path, "a volume", "argil")?;
    }
    ensure!(
        options.volume.descent.is_none(),
        "--descent controls how an octree is marched: use it with `argil render`"
    );
    let engine = input::engine(&options.on)?;
    let via = input::representation(via, &options.volume, &engine)?;
    let mut scene = input::scene(&options.scene, options.on.allow_external_meshes)?;
    input::set_time(&mut scene, options.time, &options.scene)?;
    let outputs = options.output.as_deref();
    input::spare_meshes(&scene, &options.scene, outputs)?;

    let place = || options.scene.display().to_string();
    let mut world = engine.build(&scene).with_context(place)?.field();
    crate::long_work::warn(world.program(), via, &options.scene);
    let mut samples = Vec::new();
    let mut stages: Vec<(&str, Vec<f64>)> = Vec::new();
    for _ in 0..options.repeat {
        world = world.rebuilt_as(&scene, via).with_context(place)?;
        let times = world.build_timings();
        samples.push(times.duration_ms);
        for &(stage, ms) in &times.stages_ms {
            match stages.iter_mut().find(|(known, _)| *known == stage) {
                Some((_, all)) => all.push(ms),
                None => stages.push((stage, vec![ms])),
            }
        }
    }
    if let Some(path) = &options.output {
        world.rename_meshes(&input::moved_meshes(&scene, &options.scene, path)?);
        world.save(path)?;
    }
    report(options, &world, &samples, &stages)
}

fn report(
    options: &BakeArgs,
    world: &World,
    samples: &[f64],
    stages: &[(&str, Vec<f64>)],
) -> anyhow::Result<()> {
    let stages_ms: Map<String, Value> = stages
        .iter()
        .map(|(stage, ms)| (stage.to_string(), json!(output::median(ms))))
        .collect();
    let build_ms = output::median(samples);
    let mut report = json!({
        "device": world.engine().device(),
        "device_reason": world.engine().selection_reason(),
        "brushes": world.program().brush_count(),
        "build_ms": build_ms,
        "builds_ms": samples,
        "stages_ms": stages_ms,
        "memory_bytes": world.memory_bytes(),
        "gpu": output::gpu_counters(world.engine()),
        "volume": options.output.as_ref().map(|p| p.display().to_string()),
    });
    let info = world.volume_info()?.context("no volume was built")?;
    output::warn_if_clipped(&info.voxel_grid, &options.scene);
    let about = output::volume(world.representation(), &info);
    if let (Some(all), Some(members)) = (report.as_object_mut(), about.as_object()) {
        for (key, value) in members {
            all.entry(key.clone()).or_insert(value.clone());
        }
        if options.count_lost
            && let Some(Volume::Octree(octree)) = world.volume()?.as_deref()
        {
            let lost = octree.lost_bricks(world.program());
            all.insert("lost_bricks".into(), json!(lost));
        }
    }
    if options.json {
        output::json(&report);
        return Ok(());
    }
    if let Some(path) = &options.output {
        output::line(&path.display().to_string());
    }
    let engine = world.engine();
    output::line(&format!(
        "on {}: {}",
        engine.device(),
        engine.selection_reason()
    ));
    let parts: Vec<_> = stages
        .iter()
        .map(|(stage, ms)| format!("{stage} {:.2}", output::median(ms)))
        .collect();
    let times = if samples.len() > 1 {
        format!(" (median of {})", samples.len())
    } else {
        String::new()
    };
    output::line(&format!(
        "built in {build_ms:.2} ms{times}: {} ms",
        parts.join(", ")
    ));
    for (key, value) in about.as_object().into_iter().flatten() {
        output::pair(key, value);
    }
    if let Some(lost) = report.get("lost_bricks") {
        output::pair("lost_bricks", lost);
    }
    Ok(())
}
