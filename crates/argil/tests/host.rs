//! Worlds in the frames of a host that has its own device.

use crate::host_common::{CLEAR, DEPTH, Host, NEAR, odd_view, opened, representations};
use argil::RenderError;
use argil::gpu::{Gpu, GpuCounters, HostTargets, wgpu};
use argil::prelude::*;
use argil::render::Projection;
use glam::camera::rh::{proj::directx, view::look_at_mat4};
use glam::{Mat4, Vec3, Vec4};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// A frame of a host is the picture that the world renders itself, wherever rays hit something.
#[test]
fn frames_are_the_worlds_own_pictures() -> Outcome {
    let host = Host::new([80, 60])?;
    let (_, engine) = host.engine()?;
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([0.7, 0.3, 0.5]))?;
    scene.push(Shape::sphere(0.4).at([0.2, 0.3, 0.1]).smooth(0.1))?;
    for representation in representations() {
        let world = engine.build(&scene)?.with_representation(representation)?;
        let camera = world.camera();
        let degrees = camera.field_of_view_degrees.to_radians();
        let view = directx::perspective(degrees, 80.0 / 60.0, 0.01, 100.0)
            * look_at_mat4(camera.eye, camera.target, Vec3::Y);
        let mut frame = world.host_frame(&Host::targets_with(wgpu::CompareFunction::Less))?;
        for mode in [RenderMode::Normal, RenderMode::Shaded] {
            host.draw(&world, &mut frame, (view, mode), 1.0)?;
            let found = host.pixels(&host.color)?;
            let settings = RenderSettings {
                samples: 1,
                ground: false,
                ..world.render_settings(host.size, mode)
            };
            let picture = world.render(&camera, &settings)?;
            let (mut far, mut hits) = (0, 0_usize);
            for (found, expected_pixel) in found.iter().zip(picture.rgb.as_chunks::<3>().0) {
                if found[..3] != CLEAR {
                    hits += 1;
                    let differs = |i: usize| found[i].abs_diff(expected_pixel[i]) > 2;
                    far += usize::from((0..3).any(differs));
                }
            }
            let expected = picture.hit_pixels;
            assert!(
                hits.abs_diff(expected) * 50 < expected,
                "{representation:?}: {hits}"
            );
            assert!(
                far * 50 < hits,
                "{representation:?}, {mode:?}: {far} of {hits}"
            );
        }
    }
    Ok(())
}

/// The host's depth hides a world behind it, and not one before it.
#[test]
fn depth_hides_both_ways() -> Outcome {
    let host = Host::new([40, 30])?;
    let (_, engine) = host.engine()?;
    let mut scene = Scene::new();
    scene.push(Shape::sphere(1.0))?;
    let world = engine.build(&scene)?.bricks(48)?;
    let view = directx::perspective_infinite_reverse(0.7, 4.0 / 3.0, NEAR)
        * look_at_mat4(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, Vec3::Y);
    let mut frame = world.host_frame(&Host::targets())?;
    let depth_of = |z: f32| {
        let clip = view * Vec4::new(0.0, 0.0, z, 1.0);
        clip.z / clip.w
    };
    let mut seen = Vec::new();
    for wall in [-2.0, 0.5, 0.9, 1.1] {
        host.draw(
            &world,
            &mut frame,
            (view, RenderMode::Normal),
            depth_of(wall),
        )?;
        let all = host.pixels(&host.color)?;
        seen.push(all.iter().filter(|pixel| pixel[..3] != CLEAR).count());
    }
    assert!(
        seen[0] > seen[1] && seen[1] > seen[2] && seen[2] > 0,
        "{seen:?}"
    );
    assert_eq!(seen[3], 0);
    // A wall through the sphere leaves a circle, whose area perspective makes larger.
    let area = |z: f32| (1.0 - z * z) / (5.0 - z).powi(2);
    let ratio = seen[1] as f32 / seen[2] as f32;
    assert!(
        (ratio / (area(0.5) / area(0.9)) - 1.0).abs() < 0.15,
        "{seen:?}"
    );
    Ok(())
}

/// After the first frame, none submits, waits or creates anything, whatever the view is.
#[test]
fn later_frames_create_nothing() -> Outcome {
    let host = Host::new([48, 32])?;
    let (gpu, engine) = host.engine()?;
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.8))?;
    for representation in representations() {
        let world = engine.build(&scene)?.with_representation(representation)?;
        let mut frames = [
            world.host_frame(&Host::targets())?,
            world.host_frame(&Host::targets())?,
        ];
        let mut counts = Vec::new();
        for round in 0..4 {
            let before = gpu.counters();
            for (frame, mode) in frames
                .iter_mut()
                .zip([RenderMode::Normal, RenderMode::Shaded])
            {
                let turned = odd_view() * Mat4::from_rotation_y(0.1 * round as f32);
                host.draw(&world, frame, (turned, mode), 0.0)?;
            }
            let after = gpu.counters();
            counts.push(after.since(before));
        }
        assert!(counts[0].buffers > 0 && counts[0].pipelines > 0);
        for count in &counts[1..] {
            assert_eq!(*count, GpuCounters::default(), "{representation:?}");
        }
    }
    Ok(())
}

/// Several views of a world are drawn by one submission, each as alone.
#[test]
fn views_of_one_submission_are_as_alone() -> Outcome {
    let host = Host::new([48, 32])?;
    let (_, engine) = host.engine()?;
    let mut scene = Scene::new();
    scene.push(Shape::torus(0.6, 0.25))?;
    let far = Mat4::from_scale(Vec3::splat(0.2));
    let views = [odd_view(), odd_view() * far];
    for representation in representations() {
        let mut world = engine.build(&scene)?.with_representation(representation)?;
        let camera = Projection::from_matrix(odd_view().to_cols_array_2d(), true);
        let camera = camera.ok_or("no projection")?.camera();
        world.refine(
            &camera,
            &world.render_settings([48, 32], RenderMode::Normal),
        )?;
        let mut alone = Vec::new();
        for view in views {
            let mut frame = world.host_frame(&Host::targets())?;
            host.draw(&world, &mut frame, (view, RenderMode::Normal), 0.0)?;
            alone.push(host.depths()?);
        }
        let mut frames = [
            world.host_frame(&Host::targets())?,
            world.host_frame(&Host::targets())?,
        ];
        for last in [0, 1] {
            let mut encoder = host.device.create_command_encoder(&Default::default());
            let order = [1 - last, last];
            for i in order {
                host.encode(
                    &world,
                    &mut frames[i],
                    (views[i], RenderMode::Normal),
                    &mut encoder,
                )?;
            }
            for i in order {
                host.pass(&frames[i], 0.0, &mut encoder);
            }
            host.queue.submit([encoder.finish()]);
            assert!(host.depths()? == alone[last], "{representation:?}");
        }
    }
    Ok(())
}

/// An edit of bricks is one submission. It waits for nothing, and creates nothing once there is room.
#[test]
fn later_edits_submit_once() -> Outcome {
    let host = Host::new([16, 16])?;
    let (gpu, engine) = host.engine()?;
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([0.5; 3]))?;
    scene.push(Shape::sphere(0.12).at([0.5, 0.1, 0.1]).subtract())?;
    let mut world = engine.build(&scene)?.bricks(64)?;
    let mut counts = Vec::new();
    for step in 0..8 {
        if step % 2 == 0 {
            scene.undo();
        } else {
            scene.redo();
        }
        let before = gpu.counters();
        world.apply(&scene)?;
        let after = gpu.counters();
        // A small read-back of the edit before may end here.
        counts.push(GpuCounters {
            bytes_read: 0,
            ..after.since(before)
        });
        // The counters of an edit come back between frames.
        world.render_view([16, 16])?;
    }
    let once = GpuCounters {
        submissions: 1,
        ..GpuCounters::default()
    };
    // The first ones make room.
    assert_eq!(counts[4..], [once; 4], "{counts:?}");
    assert!(world.flush()?.filled > 0);
    Ok(())
}

/// One frame draws several worlds of a device, one after another, and each is there.
#[test]
fn a_frame_draws_one_world_after_another() -> Outcome {
    let host = Host::new([48, 32])?;
    let (_, engine) = host.engine()?;
    let mut worlds = Vec::new();
    for (representation, radius) in representations().into_iter().zip([0.4, 0.5, 0.6, 0.7, 0.8]) {
        let mut scene = Scene::new();
        scene.push(Shape::sphere(radius))?;
        worlds.push(engine.build(&scene)?.with_representation(representation)?);
    }
    let mut frame = worlds[0].host_frame(&Host::targets())?;
    let mut seen = Vec::new();
    for world in worlds.iter().chain(&worlds) {
        host.draw(world, &mut frame, (odd_view(), RenderMode::Normal), 0.0)?;
        seen.push(host.depths()?.iter().filter(|&&depth| depth > 0.0).count());
    }
    assert!(
        seen[..5].is_sorted() && seen[0] > 50 && seen[0] < seen[4],
        "{seen:?}"
    );
    assert_eq!(seen[..5], seen[5..]);
    Ok(())
}

/// What cannot be drawn is named.
#[test]
fn bad_hosts_get_errors() -> Outcome {
    let lacking = opened(|_| wgpu::Limits {
        max_storage_buffers_per_shader_stage: 4,
        ..wgpu::Limits::default()
    })?;
    let error = Gpu::from_wgpu(lacking.0, lacking.1).expect_err("too few buffers");
    let text = error.to_string();
    assert!(
        text.contains("max_storage_buffers_per_shader_stage of 8"),
        "{text}"
    );
    assert!(text.contains("required_limits"), "{text}");

    let host = Host::new([16, 16])?;
    let (_, engine) = host.engine()?;
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.8))?;
    let world = engine.build(&scene)?.bricks(32)?;
    let no_color = HostTargets {
        color: DEPTH,
        ..Host::targets()
    };
    assert!(world.host_frame(&no_color).is_err());
    let odd_samples = HostTargets {
        sample_count: 3,
        ..Host::targets()
    };
    assert!(world.host_frame(&odd_samples).is_err());
    let mut frame = world.host_frame(&Host::targets())?;
    for view in [
        Mat4::ZERO,
        Mat4::NAN,
        Mat4::from_cols_array(&[f32::INFINITY; 16]),
    ] {
        let refused = host.draw(&world, &mut frame, (view, RenderMode::Normal), 0.0);
        assert!(matches!(refused, Err(RenderError::NoProjection)), "{view}");
    }
    let mut encoder = host.device.create_command_encoder(&Default::default());
    for size in [[0, 0], [0, 16], [1 << 20, 1 << 20]] {
        let settings = RenderSettings {
            size,
            ..RenderSettings::default()
        };
        let view = odd_view().to_cols_array_2d();
        let refused = world.encode_frame(&mut frame, view, &settings, &mut encoder);
        assert!(matches!(refused, Err(RenderError::Size { .. })));
    }
    let on_cpu = Engine::cpu().build(&scene)?.bricks(32)?;
    assert!(matches!(
        on_cpu.host_frame(&Host::targets()),
        Err(RenderError::NotOnGpu)
    ));
    let mesh = argil::MeshRenderOptions::from(32);
    let mesh = engine.build(&scene)?.with_representation(mesh)?;
    let refused = host.draw(&mesh, &mut frame, (odd_view(), RenderMode::Normal), 0.0);
    assert!(matches!(refused, Err(RenderError::Triangles)));
    // The frame still draws.
    host.draw(&world, &mut frame, (odd_view(), RenderMode::Normal), 0.0)?;
    assert!(host.depths()?.iter().any(|&depth| depth > 0.0));
    Ok(())
}

/// A device that is lost makes calls fail, and nothing else. The scene is there, and another device goes on with it.
#[test]
fn a_lost_device_leaves_the_scene() -> Outcome {
    let host = Host::new([32, 24])?;
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.8))?;
    let size = [32, 24];
    let (_, engine) = host.engine()?;
    let mut worlds = Vec::new();
    for representation in representations() {
        worlds.push(engine.build(&scene)?.with_representation(representation)?);
    }
    let mut frame = worlds[0].host_frame(&Host::targets())?;
    host.draw(
        &worlds[0],
        &mut frame,
        (odd_view(), RenderMode::Normal),
        0.0,
    )?;
    let settings = worlds[0].render_settings(size, RenderMode::Normal);
    let camera = worlds[0].camera();
    let before = worlds[0].render(&camera, &settings)?;
    host.device.destroy();
    for world in &mut worlds {
        assert!(world.render(&camera, &settings).is_err());
    }
    let old = scene.clone();
    scene.push(Shape::sphere(0.3).at([0.8, 0.0, 0.0]))?;
    for world in &mut worlds {
        // An edit may learn of the loss only later. One that fails changes nothing.
        let edited = world.apply(&scene).map(|_| ());
        let kept = if edited.is_ok() { &scene } else { &old };
        assert_eq!(world.scene().to_json(), kept.to_json());
        let flushed = world.flush().map(|_| ());
        let drawn = host.draw(world, &mut frame, (odd_view(), RenderMode::Normal), 0.0);
        let _ = (edited, flushed, drawn.map_err(|error| error.to_string()));
        assert!(world.render(&camera, &settings).is_err());
    }
    let other = Host::new(size)?;
    let (_, engine) = other.engine()?;
    let again = engine.build(&old)?.field();
    assert_eq!(again.render(&camera, &settings)?.rgb, before.rgb);
    Ok(())
}
