//! Edits in the encoder of a host.

use crate::host_common::Host;
use argil::gpu::GpuError;
use argil::prelude::*;
use argil::scene::Edit;
use argil::{BuildError, RebuildReason, RenderError, Representation};
use glam::camera::rh::{proj::directx, view::look_at_mat4};
use glam::{Mat4, Vec3};

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn view() -> Mat4 {
    directx::perspective_infinite_reverse(0.8, 1.5, 0.1)
        * look_at_mat4(Vec3::new(1.5, 1.8, 4.0), Vec3::ZERO, Vec3::Y)
}

/// A block that is wider than any edit.
fn block() -> Result<Scene, Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([1.2, 0.3, 1.2]))?;
    Ok(scene)
}

/// Brushes of some shapes that have a size, in turn removed and added, smooth and hard, somewhere on the block. A software device
/// compiles its passes for each other shape; random edits of all shapes are tried elsewhere, through encoders, too.
fn brushes() -> Vec<Brush> {
    let shapes = Shape::examples();
    let shapes = shapes.into_iter().filter(|shape| shape.aabb().is_finite());
    let shapes: Vec<_> = shapes.step_by(5).collect();
    let shapes = shapes.iter().cycle().take(2 * shapes.len());
    let mut seed = 7_u32;
    let mut random = move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
    };
    let all = shapes.enumerate().map(|(index, shape)| {
        let place = [random(), 0.3 * random(), random()];
        let brush = Brush::new(shape.clone()).at(place).scaled(0.3);
        let brush = brush.smooth(if index % 3 == 0 { 0.05 } else { 0.0 });
        match index % 2 {
            0 => brush.subtract(),
            _ => brush,
        }
    });
    all.collect()
}

/// Edits, the frame and the host's own pass are one submission, after which the world is a fresh bake to the bit. None submits
/// or waits by itself. Once each shape was seen, none compiles anything, and only a table that grows takes a new buffer.
#[test]
fn edits_are_part_of_the_hosts_submission() -> Outcome {
    let host = Host::new([72, 48])?;
    let (gpu, engine) = host.engine()?;
    let mut scene = block()?;
    let mut world = engine.build(&scene)?.bricks(96)?;
    let mut twin = engine.build(&scene)?.bricks(96)?;
    let mut frame = world.host_frame(&Host::targets())?;
    let mut twin_frame = twin.host_frame(&Host::targets())?;
    let mut without_work = 0;
    let all = brushes();
    for (index, brush) in all.iter().enumerate() {
        scene.push(brush.clone())?;
        let before = gpu.counters();
        let mut encoder = host.device.create_command_encoder(&Default::default());
        let report = world.encode_edits(&scene, &mut encoder)?;
        host.encode(
            &world,
            &mut frame,
            (view(), RenderMode::Normal),
            &mut encoder,
        )?;
        host.pass(&frame, 0.0, &mut encoder);
        let used = gpu.counters().since(before);
        assert!(!report.rebuilt, "{report:?}");
        assert_eq!((used.submissions, used.waits), (0, 0), "{used:?}");
        if index * 2 >= all.len() {
            assert!(used.buffers <= 1 && used.pipelines == 0, "{used:?}");
            without_work += usize::from(used.buffers == 0);
        }
        host.queue.submit([encoder.finish()]);
        // A host presents, which waits for a frame before.
        let found = host.pixels(&host.color)?;
        twin.apply(&scene)?;
        host.draw(&twin, &mut twin_frame, (view(), RenderMode::Normal), 0.0)?;
        // Rays step through blocks that are to leave the table cell by cell, which rounds their lengths elsewhere.
        let expected = host.pixels(&host.color)?;
        let pairs = found.iter().zip(&expected);
        let far = pairs.filter(|(a, b)| (0..3).any(|i| a[i].abs_diff(b[i]) > 2));
        let (far, brushes) = (far.count(), scene.brush_count());
        assert!(far * 500 < found.len(), "{far} pixels, {brushes} brushes");
    }
    assert!(without_work > 0, "{without_work}");
    world.flush()?;
    assert_eq!(world.diff_from_rebuild()?, Some(0));
    Ok(())
}

/// Several edits in one encoder, and several encoders in their order, are as edits that are applied one after another.
#[test]
fn edits_of_one_submission_follow_one_another() -> Outcome {
    let host = Host::new([72, 48])?;
    let (_, engine) = host.engine()?;
    for (per_encoder, per_submission) in [(2, 3), (64, 1)] {
        let mut scene = block()?;
        let mut world = engine.build(&scene)?.bricks(64)?;
        let mut encoders = Vec::new();
        for some in brushes().chunks(per_encoder) {
            let mut encoder = host.device.create_command_encoder(&Default::default());
            for brush in some {
                let put = scene.push(brush.clone())?.node;
                world.encode_edits(&scene, &mut encoder)?;
                // It goes away again, so that slots become free.
                if scene.brush_count().is_multiple_of(4) {
                    scene.apply(Edit::Remove { node: put })?;
                    world.encode_edits(&scene, &mut encoder)?;
                }
            }
            encoders.push(encoder.finish());
            if encoders.len() == per_submission {
                host.queue.submit(encoders.drain(..));
            }
        }
        host.queue.submit(encoders);
        world.flush()?;
        let differing = world.diff_from_rebuild()?;
        assert_eq!(differing, Some(0), "{per_encoder}, {per_submission}");
    }
    Ok(())
}

/// All representations follow edits that a host encodes. Those that cannot change in place say that they were built again.
#[test]
fn all_representations_follow() -> Outcome {
    let host = Host::new([72, 48])?;
    let (_, engine) = host.engine()?;
    let mut all = Representation::all(48);
    all.retain(|kind| !matches!(kind, Representation::Mesh(_)));
    for representation in all {
        let mut scene = block()?;
        let mut world = engine.build(&scene)?.with_representation(representation)?;
        let mut twin = engine.build(&scene)?.with_representation(representation)?;
        let mut frame = world.host_frame(&Host::targets())?;
        let mut twin_frame = twin.host_frame(&Host::targets())?;
        for brush in brushes().into_iter().take(12) {
            scene.push(brush)?;
        }
        let mut encoder = host.device.create_command_encoder(&Default::default());
        let report = world.encode_edits(&scene, &mut encoder)?;
        host.encode(
            &world,
            &mut frame,
            (view(), RenderMode::Normal),
            &mut encoder,
        )?;
        host.pass(&frame, 0.0, &mut encoder);
        host.queue.submit([encoder.finish()]);
        let found = host.pixels(&host.color)?;
        twin.apply(&scene)?;
        host.draw(&twin, &mut twin_frame, (view(), RenderMode::Normal), 0.0)?;
        assert_eq!(
            found,
            host.pixels(&host.color)?,
            "{representation:?}, {report:?}"
        );
    }
    Ok(())
}

/// An encoder that is dropped takes its edits with it: the world knows, and is built again. One that is not submitted yet is
/// named by what would come before it.
#[test]
fn encoders_that_are_not_submitted_are_known() -> Outcome {
    let host = Host::new([72, 48])?;
    let (_, engine) = host.engine()?;
    let mut scene = block()?;
    let mut world = engine.build(&scene)?.bricks(64)?;
    let mut frame = world.host_frame(&Host::targets())?;
    let all = brushes();
    let encoder = || host.device.create_command_encoder(&Default::default());

    scene.push(all[0].clone())?;
    let mut dropped = encoder();
    world.encode_edits(&scene, &mut dropped)?;
    drop(dropped);
    let look = (view(), RenderMode::Normal);
    let drawn = host.encode(&world, &mut frame, look, &mut encoder());
    let refused = matches!(drawn, Err(RenderError::Gpu(GpuError::NotSubmitted)));
    assert!(refused, "{drawn:?}");
    let mut next = encoder();
    let report = world.encode_edits(&scene, &mut next)?;
    assert_eq!(report.reason, Some(RebuildReason::NotSubmitted));
    host.queue.submit([next.finish()]);
    assert_eq!(world.diff_from_rebuild()?, Some(0));

    scene.push(all[1].clone())?;
    let mut waiting = encoder();
    world.encode_edits(&scene, &mut waiting)?;
    scene.push(all[2].clone())?;
    let applied = world.apply(&scene);
    let refused = matches!(applied, Err(BuildError::Gpu(GpuError::NotSubmitted)));
    assert!(refused, "{applied:?}");
    assert!(world.apply(&scene)?.rebuilt);
    // It belongs to a volume that is gone.
    host.queue.submit([waiting.finish()]);
    assert_eq!(world.diff_from_rebuild()?, Some(0));

    scene.push(all[3].clone())?;
    let mut waiting = encoder();
    world.encode_edits(&scene, &mut waiting)?;
    let flushed = world.flush();
    let refused = matches!(flushed, Err(BuildError::Gpu(GpuError::NotSubmitted)));
    assert!(refused, "{flushed:?}");

    let mut on_cpu = Engine::cpu().build(&scene)?.bricks(32)?;
    let refused = on_cpu.encode_edits(&scene, &mut encoder());
    assert!(matches!(refused, Err(BuildError::NotOnGpu)), "{refused:?}");
    Ok(())
}
