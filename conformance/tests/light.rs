//! Light in batches against light ray by ray, and against the other device.

use argil_abi::{HIT_NONE, HIT_OUTSIDE};
use argil_conformance::{Wait, gpu, primary_ray};
use argil_field::Program;
use argil_gpu::{GpuProgram, GpuVolume, ImageOutput};
use argil_math::Aabb;
use argil_render::{
    Camera, PrunedField, RenderMode, RenderOutput, RenderSettings, frame_uniforms, render_with_hits,
};
use argil_scene::{Brush, Scene, Shape};
use argil_volume::{BrickLayout, BrickSettings, Bricks, Volume, VoxelGrid};
use glam::Vec3;

/// Returns how many bytes of two images differ by more than 12.
fn differing(a: &RenderOutput, b: &RenderOutput) -> usize {
    assert_eq!(a.rgb.len(), b.rgb.len());
    let pairs = a.rgb.iter().zip(&b.rgb);
    pairs.filter(|(a, b)| a.abs_diff(**b) > 12).count()
}

/// A slab with a wall, posts, a curb and a hole: what stands beside flat places.
fn yard() -> Scene {
    let mut scene = Scene::new();
    let mut push = |brush: Brush| {
        scene.push(brush).expect("a brush");
    };
    push(Brush::new(Shape::cuboid([1.0, 0.1, 1.0])).at([0.0, -0.1, 0.0]));
    push(Brush::new(Shape::cuboid([0.02, 0.3, 0.5])).at([0.3, 0.3, 0.2]));
    push(Brush::new(Shape::cuboid([0.6, 0.02, 0.02])).at([-0.2, 0.02, -0.5]));
    for i in 0..5 {
        let x = -0.8 + 0.2 * i as f32;
        push(Brush::new(Shape::cylinder(0.015, 0.2)).at([x, 0.2, 0.5]));
    }
    push(Brush::new(Shape::sphere(0.12)).at([-0.4, 0.3, 0.0]));
    push(
        Brush::new(Shape::cylinder(0.15, 0.08))
            .at([-0.5, 0.0, -0.1])
            .subtract(),
    );
    scene
}

/// Independent. On the GPU, each pixel sends its own ray through the field to the sun; on the CPU, cylinders around the
/// rays of blocks and groups go first, with pruned programs. No shadow is missing, whatever the sun's height.
#[test]
fn cylinders_toward_the_sun_miss_no_shadow() {
    let scene = yard();
    let program = Program::lower(&scene).expect("a program");
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let camera = Camera::orbit(Aabb::centered(Vec3::ONE), [25.0, 35.0, 2.2], 40.0);
    for elevation in [12.0, 25.0, 60.0] {
        let images = |azimuth: f32| {
            let settings = RenderSettings {
                size: [250, 150],
                mode: RenderMode::Shaded,
                ground: true,
                sun_degrees: [azimuth, elevation],
                ..RenderSettings::default()
            };
            frame_uniforms(&settings, &camera, &program, None, program.aabb())
        };
        let frames = images(70.0);
        let cpu = render_with_hits(&program, &PrunedField, &frames);
        let (found, _) = field
            .render(&frames, ImageOutput::CpuWithHits)
            .wait()
            .expect("an image");
        let count = differing(&cpu, &found);
        assert!(
            count <= cpu.rgb.len() / 300,
            "{elevation}: {count} bytes differ"
        );
        // The other way round: a sun moved by six degrees is seen.
        let moved = render_with_hits(&program, &PrunedField, &images(76.0));
        let seen = differing(&moved, &found);
        println!("{elevation}: {count} bytes, {seen} with another sun");
        assert!(
            seen > 2 * count && seen > cpu.rgb.len() / 200,
            "{elevation}: {seen}"
        );
    }
}

/// Bounded. Sizes that are no multiples of blocks, several samples, and a clipped solid, in whose cut there are no bricks:
/// the field gives its materials there, in a pass of its own.
#[test]
fn bricks_are_lit_alike_on_both_devices_at_any_size() {
    let mut scene = Scene::new();
    scene
        .push(Brush::new(Shape::Plane {
            normal: [0.0, 1.0, 0.0],
            offset: -0.2,
        }))
        .expect("a brush");
    scene
        .push(
            Brush::new(Shape::sphere(0.4))
                .at([0.1, 0.2, 0.0])
                .smooth(0.1),
        )
        .expect("a brush");
    let program = Program::lower(&scene).expect("a program");
    let region = Aabb::centered(Vec3::ONE);
    let grid = VoxelGrid::fitting(program.aabb(), Some(region), 64).expect("a grid");
    let layout = BrickLayout::new(grid, &BrickSettings::default()).expect("a layout");
    let (bricks, _) = Bricks::bake(&program, layout, None).expect("bricks");
    let volume: Volume = bricks.clone().into();
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let on_gpu = GpuVolume::upload(&field, &volume).wait().expect("bricks");
    let camera = Camera::orbit(region, [30.0, 20.0, 2.4], 40.0);
    for (size, samples) in [([70, 50], 1), ([97, 67], 3), ([9, 130], 1)] {
        let settings = RenderSettings {
            size,
            samples,
            mode: RenderMode::Shaded,
            ground: true,
            ..RenderSettings::default()
        };
        let frames = frame_uniforms(&settings, &camera, &program, Some(&grid), region);
        let cpu = render_with_hits(&program, &volume, &frames);
        let (found, _) = on_gpu
            .render(&field, &frames, ImageOutput::CpuWithHits)
            .wait()
            .expect("an image");
        let count = differing(&cpu, &found);
        assert!(
            count <= cpu.rgb.len() / 60,
            "{size:?}: {count} bytes differ"
        );
        let hits = cpu.hits.iter().filter(|hit| hit.kind != HIT_NONE).count();
        assert!(10 * hits > cpu.hits.len(), "{size:?}: {hits} hits");
        // Some are where no brick is.
        let clipped = cpu.hits.iter().enumerate().filter(|(i, hit)| {
            let (x, y) = (*i as u32 % size[0], *i as u32 / size[0]);
            let place = primary_ray(&frames[0], x, y).at(hit.normal_t[3]);
            let n = Vec3::from_slice(&hit.normal_t[..3]);
            hit.kind == HIT_OUTSIDE && bricks.material(place, n, program.materials()).is_none()
        });
        assert!(clipped.count() > 20, "{size:?}");
    }
}
