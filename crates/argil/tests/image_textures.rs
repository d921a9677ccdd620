//! Images that stay on the GPU.

use crate::host_common::Host;
use argil::RenderError;
use argil::gpu::{GpuError, ImageTextures};
use argil::prelude::*;

type Outcome = Result<(), Box<dyn std::error::Error>>;

const MODES: [RenderMode; 7] = [
    RenderMode::Shaded,
    RenderMode::Normal,
    RenderMode::Depth,
    RenderMode::Heat,
    RenderMode::Bricks,
    RenderMode::Nodes,
    RenderMode::Levels,
];

fn scene() -> Result<Scene, Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([0.7, 0.3, 0.5]))?;
    scene.push(Shape::sphere(0.4).at([0.2, 0.3, 0.1]).smooth(0.1))?;
    Ok(scene)
}

/// They have the pixels and the distances that come to the CPU, through each representation and in each mode.
#[test]
fn they_are_those_that_come_to_the_cpu() -> Outcome {
    let host = Host::new([70, 50])?;
    let (_, engine) = host.engine()?;
    let textures = ImageTextures::new(&host.device, host.size)?;
    let scene = scene()?;
    for representation in Representation::all(40) {
        let mut world = engine.build(&scene)?.with_representation(representation)?;
        let camera = world.camera();
        for mode in MODES {
            let settings = RenderSettings {
                statistics: true,
                ..world.render_settings(host.size, mode)
            };
            if !representation.supports_mode(mode) {
                let refused = world.render_into(&camera, &settings, &textures);
                assert!(matches!(refused, Err(RenderError::NoBricks)));
                continue;
            }
            world.refine(&camera, &settings)?;
            let report = world.render_into(&camera, &settings, &textures)?;
            let (picture, distances) =
                pollster::block_on(world.render_with_distances_async(&camera, &settings))?;
            assert!(report.statistics.is_some());
            // Hits and steps that nobody asks for change no pixel.
            let uncounted = RenderSettings {
                statistics: false,
                ..settings
            };
            let plain = world.render(&camera, &uncounted)?;
            assert!(plain.statistics.is_none());
            assert!(plain.rgb == picture.rgb, "{representation:?}, {mode:?}");
            assert_eq!(report.statistics, picture.statistics, "{representation:?}");
            let colors = host.pixels(textures.color())?;
            let same = colors.iter().zip(picture.rgb.as_chunks::<3>().0);
            let apart = same.filter(|(a, b)| a[..3] != b[..]).count();
            assert_eq!(apart, 0, "{representation:?}, {mode:?}");
            assert!(colors.iter().all(|color| color[3] == 255));
            let kept = host.pixels(textures.distance())?.into_iter();
            let kept: Vec<f32> = kept
                .map(f32::from_le_bytes)
                .map(|distance| {
                    if distance == f32::MAX {
                        f32::INFINITY
                    } else {
                        distance
                    }
                })
                .collect();
            assert_eq!(kept, distances, "{representation:?}, {mode:?}");
            assert!(kept.iter().any(|distance| distance.is_finite()));
        }
    }
    Ok(())
}

/// Odd sizes and worlds on the CPU are refused.
#[test]
fn odd_textures_are_refused() -> Outcome {
    let host = Host::new([70, 50])?;
    let (_, engine) = host.engine()?;
    for size in [[0, 50], [70, 0], [1 << 20, 50]] {
        let refused = ImageTextures::new(&host.device, size);
        assert!(matches!(refused, Err(GpuError::ImageSize { .. })));
    }
    let textures = ImageTextures::new(&host.device, [70, 51])?;
    let scene = scene()?;
    let world = engine.build(&scene)?.bricks(40)?;
    let settings = world.render_settings(host.size, RenderMode::Normal);
    let refused = world.render_into(&world.camera(), &settings, &textures);
    let message = refused.expect_err("another size").to_string();
    assert!(
        message.contains("70x50") && message.contains("70x51"),
        "{message}"
    );
    let on_cpu = Engine::cpu().build(&scene)?.bricks(40)?;
    let refused = on_cpu.render_into(&on_cpu.camera(), &settings, &textures);
    assert!(matches!(refused, Err(RenderError::NotOnGpu)));
    // The device is as it was.
    let textures = ImageTextures::new(&host.device, host.size)?;
    world.render_into(&world.camera(), &settings, &textures)?;
    Ok(())
}

/// An image is one submission, and creates no buffer after the first. Nothing of it comes back, or only the counts of steps that are
/// asked for, however large it is.
#[test]
fn no_pixel_comes_back() -> Outcome {
    let host = Host::new([320, 200])?;
    let (gpu, engine) = host.engine()?;
    let world = engine.build(&scene()?)?.bricks(40)?;
    let mut counts = Vec::new();
    let small = [32, 20];
    let cases = [
        (small, false),
        (host.size, false),
        (small, true),
        (host.size, true),
    ];
    for (size, statistics) in cases {
        let textures = ImageTextures::new(&host.device, size)?;
        let settings = RenderSettings {
            statistics,
            ..world.render_settings(size, RenderMode::Shaded)
        };
        let draw = || world.render_into(&world.camera(), &settings, &textures);
        draw()?;
        let before = gpu.counters();
        draw()?;
        let counted = gpu.counters().since(before);
        assert_eq!(
            [counted.submissions, counted.buffers, counted.pipelines],
            [1, 0, 0]
        );
        counts.push(counted.bytes_read);
    }
    // Timestamps come back, where a device has them.
    assert!(counts[0] == counts[1] && counts[2] == counts[3] && counts[2] > counts[0]);
    // A picture on the CPU has its pixels.
    let settings = world.render_settings(host.size, RenderMode::Shaded);
    let before = gpu.counters();
    world.render(&world.camera(), &settings)?;
    let read_back = gpu.counters().since(before);
    assert_eq!(read_back.bytes_read, counts[0] + 4 * 320 * 200);
    Ok(())
}
