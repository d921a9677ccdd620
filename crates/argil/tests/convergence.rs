//! Images through bricks come closer to the field's with every doubling of the resolution.

use crate::levels_common::{engines, scene};
use argil::prelude::*;

/// The mean difference of normals falls, and no more pixels hit than from the field. A ray that ended before the surface
/// would widen the solid by a part of a pixel, however fine the voxels are.
#[test]
fn normals_through_bricks_converge_to_the_field() -> Result<(), Box<dyn std::error::Error>> {
    engines().iter().try_for_each(converges)
}

fn converges(engine: &Engine) -> Result<(), Box<dyn std::error::Error>> {
    let scene = scene()?;
    let field = Engine::cpu().build(&scene)?.field();
    let camera = field.camera();
    let precise = RenderSettings {
        epsilon: Some(1e-5),
        normal_bias: Some(2e-4),
        samples: 4,
        ..field.render_settings([160, 90], RenderMode::Normal)
    };
    let truth = field.render(&camera, &precise)?.rgb;
    let hits = |rays: Vec<f32>| rays.iter().filter(|t| t.is_finite()).count() as f64;
    let true_hits = hits(field.ray_distances(&camera, &precise)?);
    let mut last = f64::INFINITY;
    for resolution in [64, 128, 256] {
        let world = engine.build(&scene)?.bricks(resolution)?;
        let settings = RenderSettings {
            samples: 4,
            ..world.render_settings([160, 90], RenderMode::Normal)
        };
        let image = world.render(&camera, &settings)?.rgb;
        let off = image
            .iter()
            .zip(&truth)
            .map(|(a, b)| u32::from(a.abs_diff(*b)));
        let off = f64::from(off.sum::<u32>()) / image.len() as f64;
        assert!(off < 0.75 * last, "{resolution}: {off} after {last}");
        last = off;
        let hits = hits(world.ray_distances(&camera, &settings)?);
        // Voxels cut thin edges off. They add none.
        assert!(hits <= 1.002 * true_hits, "{hits} hits of {true_hits}");
    }
    Ok(())
}
