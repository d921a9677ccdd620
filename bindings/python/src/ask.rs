//! Questions to a solid.

use crate::axes::python_from_scene;
use crate::solid::Solid;
use argil::math::Control;
use rayon::prelude::*;

/// Points of one task.
const CHUNK: usize = 1 << 14;

/// Calls a function for chunks of points in parallel. `width` numbers of `out` belong to each point.
fn each_chunk(
    points: &[[f32; 3]],
    width: usize,
    out: &mut [f32],
    control: &Control,
    ask: impl Fn(&[[f32; 3]], &mut [f32]) + Sync,
) {
    control.begin("points", points.len() as u64);
    let chunks = out.par_chunks_mut(width * CHUNK);
    chunks
        .zip(points.par_chunks(CHUNK))
        .for_each(|(out, chunk)| {
            if control.is_cancelled() {
                return;
            }
            ask(chunk, out);
            control.advance(chunk.len() as u64);
        });
}

/// Returns the signed distance of each point.
pub fn distances(solid: &Solid, points: &[[f32; 3]], control: &Control) -> Vec<f32> {
    let mut all = vec![0.0; points.len()];
    let query = solid.world.query();
    each_chunk(points, 1, &mut all, control, |points, out| {
        query.distances(points, out);
        for (point, out) in points.iter().zip(out) {
            if point.iter().any(|c| c.is_nan()) {
                *out = f32::NAN;
            }
        }
    });
    all
}

/// Returns the gradient at each point.
pub fn gradients(solid: &Solid, points: &[[f32; 3]], control: &Control) -> Vec<f32> {
    let mut all = vec![0.0; 3 * points.len()];
    let query = solid.world.query();
    each_chunk(points, 3, &mut all, control, |points, out| {
        let mut found = vec![(0.0, [0.0; 3]); points.len()];
        query.gradients(points, &mut found);
        for ((out, (_, gradient)), point) in out.chunks_exact_mut(3).zip(found).zip(points) {
            let is_nan = point.iter().any(|c| c.is_nan());
            let shown = if is_nan { [f32::NAN; 3] } else { gradient };
            out.copy_from_slice(&python_from_scene(shown));
        }
    });
    all
}

/// Returns the closest point of the surface, and its distance, for each point. Both are NaN where there is none.
pub fn closest_points(
    solid: &Solid,
    points: &[[f32; 3]],
    max_distance: f32,
    control: &Control,
) -> Vec<f32> {
    let mut all = vec![f32::NAN; 4 * points.len()];
    let query = solid.world.query();
    // These take long, so that tasks are small.
    control.begin("points", points.len() as u64);
    let tasks = all.par_chunks_mut(4).zip(points);
    tasks.for_each(|(out, &point)| {
        if control.is_cancelled() {
            return;
        }
        if let Some(found) = query.closest_point(point, max_distance) {
            out[..3].copy_from_slice(&python_from_scene(found.point));
            out[3] = found.distance;
        }
        control.advance(1);
    });
    all
}

/// Returns distance, point and normal of what each ray meets: infinity and NaN where that is nothing.
pub fn cast_rays(
    solid: &Solid,
    origins: &[[f32; 3]],
    directions: &[[f32; 3]],
    max_distance: f32,
    control: &Control,
) -> Vec<f32> {
    let mut all = vec![f32::NAN; 7 * origins.len()];
    let query = solid.world.query();
    control.begin("rays", origins.len() as u64);
    let tasks = all
        .par_chunks_mut(7)
        .zip(origins.par_iter().zip(directions));
    tasks.for_each(|(out, (&origin, &direction))| {
        if control.is_cancelled() {
            return;
        }
        out[0] = f32::INFINITY;
        if let Some(hit) = query.cast_ray(origin, direction, max_distance) {
            out[0] = hit.distance;
            out[1..4].copy_from_slice(&python_from_scene(hit.point));
            out[4..].copy_from_slice(&python_from_scene(hit.normal));
        }
        control.advance(1);
    });
    all
}
