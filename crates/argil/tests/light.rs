//! Light through bricks comes closer to the field's with every doubling of the resolution, and follows edits.

use crate::levels_common::{engines, scene};
use argil::prelude::*;
use argil::volume::{Band, BrickSettings, Encoding, SampleFormat};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// The mean difference of two images.
fn difference(a: &[u8], b: &[u8]) -> f64 {
    let all = a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(*b)));
    f64::from(all.sum::<u32>()) / a.len() as f64
}

/// Distances that end near the surface would give light an error that grows with the resolution.
#[test]
fn light_through_bricks_converges_to_the_field() -> Outcome {
    let scene = scene()?;
    let field = Engine::cpu().build(&scene)?.field();
    let camera = field.camera();
    let precise = RenderSettings {
        epsilon: Some(1e-5),
        normal_bias: Some(2e-4),
        ..field.render_settings([160, 90], RenderMode::Shaded)
    };
    let truth = field.render(&camera, &precise)?.rgb;
    let narrow = argil::BricksOptions {
        settings: BrickSettings {
            encoding: Encoding {
                format: SampleFormat::Snorm8,
                band: Band::Voxels(4.0),
            },
            brick_size_voxels: 16,
        },
        ..Default::default()
    };
    for engine in engines() {
        // A brick of 16 voxels with a band of 4 stores the end of the band in most of its samples.
        for (options, most) in [(argil::BricksOptions::default(), 1.0), (narrow, 1.6)] {
            let mut last = f64::INFINITY;
            for resolution in [64, 128, 256, 512] {
                let options = argil::BricksOptions {
                    resolution,
                    ..options
                };
                let world = engine.build(&scene)?.bricks(options)?;
                let settings = world.render_settings([160, 90], RenderMode::Shaded);
                let image = world.render(&camera, &settings)?.rgb;
                let off = difference(&image, &truth);
                assert!(off < 0.85 * last, "{resolution}: {off} after {last}");
                last = off;
            }
            assert!(last < most, "{last} of 255");
        }
    }
    Ok(())
}

/// After each edit, an image is that of a world that was built from the edited scene: on the CPU, to the bit.
#[test]
fn light_follows_edits() -> Outcome {
    for engine in engines() {
        let mut scene = scene()?;
        scene.view.bounds = Some([[-3.0; 3], [3.0; 3]]);
        let mut world = engine.build(&scene)?.bricks(128)?;
        let camera = world.camera();
        let settings = RenderSettings {
            samples: 1,
            ..world.render_settings([120, 80], RenderMode::Shaded)
        };
        let mut last = world.render(&camera, &settings)?.rgb;
        let mut added = Vec::new();
        for step in 0..9u16 {
            let x = f32::from(step) * 0.3 - 1.2;
            match step {
                4 => _ = scene.apply(Edit::Remove { node: added[1] })?,
                7 => {
                    let by = Modifier::Translate {
                        by: [0.2, 0.4, 0.1],
                    };
                    scene.apply(Edit::Transform { node: added[2], by })?;
                }
                _ => {
                    let bump = Brush::new(Shape::sphere(0.25))
                        .smooth(0.05)
                        .at([x, 0.5, 0.2]);
                    added.push(scene.push(bump)?.node);
                }
            }
            let report = world.apply(&scene)?;
            assert!(!report.rebuilt, "{:?}", report.reason);
            // Several edits between two images are followed too.
            if step == 5 {
                continue;
            }
            let image = world.render(&camera, &settings)?.rgb;
            let fresh = engine.build(&scene)?.bricks(128)?;
            let wanted = fresh.render(&camera, &settings)?.rgb;
            // A GPU's filter rounds by a brick's place in the pool, which edits change.
            let most = if engine.gpu_kind().is_some() {
                0.05
            } else {
                0.0
            };
            let off = difference(&image, &wanted);
            assert!(off <= most, "{off} after edit {step}");
            assert!(difference(&image, &last) > 0.0, "edit {step} shows nothing");
            last = image;
        }
    }
    Ok(())
}
