//! Cameras of a host, as matrices.

use crate::host_common::{
    CLEAR, Host, half, odd_view, odd_view_from, point_at, representations, target,
};
use argil::gpu::{HostTargets, wgpu};
use argil::prelude::*;
use argil::render::{Projection, frame_uniforms};
use glam::camera::rh::{proj::directx, view::look_at_mat4};
use glam::{Mat4, Vec2, Vec3};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// The same with parallel rays. The scene is between its planes.
fn parallel_view(is_reversed: bool) -> Mat4 {
    parallel_view_from(1.0, is_reversed)
}

/// The same with another near plane.
fn parallel_view_from(near: f32, is_reversed: bool) -> Mat4 {
    let [near, far] = if is_reversed {
        [9.0, near]
    } else {
        [near, 9.0]
    };
    let projection = directx::orthographic(-1.5, 1.1, -0.9, 1.2, near, far);
    let up = Vec3::new(0.4, 1.0, 0.1);
    projection * look_at_mat4(Vec3::new(1.5, 1.0, 4.0), Vec3::ZERO, up)
}

/// Where the ray between two points first meets a sphere around the origin, by the quadratic formula. It may begin in it.
fn meets_sphere(from: glam::DVec3, to: glam::DVec3, radius: f64) -> Option<glam::DVec3> {
    let direction = (to - from).normalize();
    let b = from.dot(direction);
    let root = b * b - from.length_squared() + radius * radius;
    let root = (root > 0.0).then(|| root.sqrt())?;
    let first = [-b - root, -b + root].into_iter().find(|&t| t > 0.0)?;
    Some(from + direction * first)
}

/// A sphere through any view lies where the quadratic formula says, in the depth buffer, too. A near plane that cuts it lets
/// rays begin inside.
#[test]
fn depths_are_those_of_the_formula() -> Outcome {
    let host = Host::new([90, 64])?;
    let (_, engine) = host.engine()?;
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.8))?;
    for representation in representations() {
        let mut world = engine.build(&scene)?.with_representation(representation)?;
        // Frames of a host ask for no levels.
        let camera = Projection::from_matrix(odd_view().to_cols_array_2d(), true);
        let camera = camera.ok_or("no projection")?.camera();
        let settings = world.render_settings([200, 200], RenderMode::Normal);
        world.refine(&camera, &settings)?;
        for (view, is_reversed) in [
            (odd_view(), true),
            (parallel_view(true), true),
            (parallel_view(false), false),
            (odd_view_from(4.1), true),
            (odd_view_from(4.6), true),
            (parallel_view_from(4.1, true), true),
            (parallel_view_from(4.6, false), false),
        ] {
            let (compare, far, near) = match is_reversed {
                true => (wgpu::CompareFunction::Greater, 0.0, 1.0),
                false => (wgpu::CompareFunction::Less, 1.0, 0.0),
            };
            let mut frame = world.host_frame(&Host::targets_with(compare))?;
            host.draw(&world, &mut frame, (view, RenderMode::Normal), far)?;
            let (mut wrong, mut both) = (0, 0);
            for (i, depth) in host.depths()?.into_iter().enumerate() {
                let at = |depth: f32| point_at(view, host.size, i, depth.into());
                // Rays that begin at the surface end there, or at its other side.
                if (at(near).length() - 0.8).abs() < 0.03 {
                    continue;
                }
                match (meets_sphere(at(near), at(0.5), 0.8), depth != far) {
                    (Some(expected), true) => {
                        both += 1;
                        let off = at(depth).distance(expected);
                        // No image asked for fine pages of the other side.
                        let is_coarse = matches!(representation, Representation::Levels(_));
                        let is_behind = at(near).length() < 0.8;
                        let room = if is_coarse && is_behind { 0.2 } else { 0.04 };
                        assert!(off < room, "{representation:?}: {off} off {expected}");
                    }
                    (None, false) => {}
                    _ => wrong += 1,
                }
            }
            assert!(both > 300, "{representation:?}: {both}");
            assert!(wrong * 50 < both, "{representation:?}: {wrong} of {both}");
        }
    }
    Ok(())
}

/// With several samples, depths are those of the last sample's rays.
#[test]
fn depths_of_several_samples_are_of_one() -> Outcome {
    let host = Host::new([90, 64])?;
    let (_, engine) = host.engine()?;
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.8))?;
    let world = engine.build(&scene)?.field();
    let view = odd_view();
    let settings = RenderSettings {
        samples: 4,
        ..world.render_settings(host.size, RenderMode::Normal)
    };
    let mut frame = world.host_frame(&Host::targets())?;
    let mut encoder = host.device.create_command_encoder(&Default::default());
    world.encode_frame(&mut frame, view.to_cols_array_2d(), &settings, &mut encoder)?;
    host.pass(&frame, 0.0, &mut encoder);
    host.queue.submit([encoder.finish()]);
    let depths = host.depths()?;
    let samples = frame_uniforms(
        &settings,
        &world.camera(),
        world.program(),
        None,
        world.view_bounds(),
    );
    let off = samples.iter().map(|sample| {
        let size = Vec2::from(host.size.map(|side| side as f32));
        let shift = Vec2::new(0.5 - sample.jitter_x, sample.jitter_y - 0.5) * 2.0 / size;
        let shifted = Mat4::from_translation(shift.extend(0.0)) * view;
        let hits = depths
            .iter()
            .enumerate()
            .filter(|(_, depth)| **depth != 0.0);
        let off = hits.map(|(i, depth)| {
            let point = point_at(shifted, host.size, i, f64::from(*depth));
            (point.length() - 0.8).abs()
        });
        let (sum, count) = off.fold((0.0, 0), |(sum, count), off| (sum + off, count + 1));
        assert!(count > 300, "{count}");
        sum / f64::from(count)
    });
    let off: Vec<f64> = off.collect();
    let (last, others) = off.split_last().ok_or("no sample")?;
    assert!(*last < 1e-4, "{off:?}");
    assert!(others.iter().all(|off| *off > 1e-3), "{off:?}");
    Ok(())
}

/// Normals and motion go to targets of their own, those that there are: the sphere's, and those of its points by both matrices.
#[test]
fn normals_and_motion_have_targets() -> Outcome {
    let host = Host::new([90, 64])?;
    let (_, engine) = host.engine()?;
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.8))?;
    let world = engine.build(&scene)?.field();
    let normals = target(&host.device, host.size, wgpu::TextureFormat::Rgba8Unorm);
    let motion = target(&host.device, host.size, wgpu::TextureFormat::Rg16Float);
    for (view, has_normals) in [(odd_view(), true), (parallel_view(true), false)] {
        let moved = view * Mat4::from_translation(Vec3::new(0.05, -0.08, 0.1));
        let targets = HostTargets {
            normal: has_normals.then(|| normals.format()),
            motion: Some(motion.format()),
            ..Host::targets()
        };
        let used = match has_normals {
            true => &[&host.color, &normals, &motion][..],
            false => &[&host.color, &motion],
        };
        let mut frame = world.host_frame(&targets)?;
        for projection in [moved, view] {
            let mut encoder = host.device.create_command_encoder(&Default::default());
            host.encode(
                &world,
                &mut frame,
                (projection, RenderMode::Normal),
                &mut encoder,
            )?;
            host.pass_with(used, &frame, 0.0, &mut encoder);
            host.queue.submit([encoder.finish()]);
        }
        let pixels = host
            .pixels(&host.color)?
            .into_iter()
            .zip(host.pixels(&motion)?);
        let pixels = pixels.zip(host.pixels(&normals)?).zip(host.depths()?);
        let mut hits = 0;
        for (i, (((color, motion), normal), depth)) in pixels.enumerate() {
            if color[..3] == CLEAR {
                continue;
            }
            hits += 1;
            let point = point_at(view, host.size, i, depth.into()).as_vec3();
            let [now, before] =
                [view, moved].map(|projection| projection.project_point3(point).truncate());
            let expected = (now - before) * glam::Vec2::new(0.5, -0.5);
            let [x, y] = [[motion[0], motion[1]], [motion[2], motion[3]]];
            let found = glam::Vec2::new(half(u16::from_le_bytes(x)), half(u16::from_le_bytes(y)));
            assert!(found.distance(expected) < 1e-3, "{found}, not {expected}");
            assert!(expected.length() > 1e-3);
            if has_normals {
                let found = Vec3::from([0, 1, 2].map(|k| f32::from(normal[k]) / 127.5 - 1.0));
                assert!(
                    found.distance(point.normalize()) < 0.02,
                    "{found} at {point}"
                );
            }
        }
        assert!(hits > 300, "{hits}");
    }
    Ok(())
}

/// A matrix gives the camera that it was made of.
#[test]
fn a_matrix_gives_its_camera() {
    let eye = Vec3::new(1.5, -2.0, 7.0);
    for projection in [
        directx::perspective(0.9, 1.5, 0.01, 1000.0),
        directx::perspective_infinite(0.9, 1.5, 0.2),
        directx::perspective_infinite_reverse(0.9, 1.5, 1e-3),
    ] {
        let matrix = projection * look_at_mat4(eye, Vec3::ONE, Vec3::Y);
        let camera = Projection::from_matrix(matrix.to_cols_array_2d(), false)
            .expect("a perspective")
            .camera();
        assert!(camera.eye.distance(eye) < 1e-4, "{camera:?}");
        let (direction, expected) = (camera.target - camera.eye, Vec3::ONE - eye);
        assert!(direction.normalize().distance(expected.normalize()) < 1e-5);
        assert!((camera.field_of_view_degrees - 0.9f32.to_degrees()).abs() < 1e-3);
    }
}
