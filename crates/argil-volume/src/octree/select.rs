//! Selects bricks. `select.wgsl` is the twin.

use super::{BrickTest, OctreeLayout};
use argil_field::{Evaluator, LANES, Program};
use argil_math::morton_cell;
use rayon::prelude::*;

/// The bricks to keep, and the distances at all centers.
#[derive(Debug)]
pub struct BrickSelection {
    /// Codes of the bricks, ascending.
    pub codes: Vec<u32>,
    /// The distance at the center of each cell, by code. 0 for codes outside the volume.
    pub centers: Vec<f32>,
}

impl BrickSelection {
    /// Evaluates the centers of all cells in Morton order, and keeps those near enough.
    pub fn of(program: &Program, layout: &OctreeLayout, keep: BrickTest) -> Self {
        let reach = layout.uniform(program, keep).max_center_distance;
        let mut centers = vec![0.0; layout.code_count() as usize];
        let is_kept =
            |code: u32, d: f32| layout.contains_voxels(morton_cell(code)) && d.abs() <= reach;
        // Parts come back in order, so their codes are ascending.
        let parts: Vec<Vec<u32>> = centers
            .par_chunks_mut(64 * LANES)
            .enumerate()
            .map_init(
                || Evaluator::new(program),
                |evaluator, (part, centers)| {
                    let first = (part * 64 * LANES) as u32;
                    measure(layout, evaluator, first, centers);
                    (first..)
                        .zip(centers.iter())
                        .filter(|&(code, &d)| is_kept(code, d))
                        .map(|(code, _)| code)
                        .collect()
                },
            )
            .collect();
        Self {
            codes: parts.concat(),
            centers,
        }
    }
}

/// Evaluates the centers of a range of codes.
fn measure(layout: &OctreeLayout, evaluator: &mut Evaluator<'_>, first: u32, centers: &mut [f32]) {
    let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let (mut places, mut d) = ([0; LANES], [0.0; LANES]);
    let mut n = 0;
    let mut measure = |n: usize, places: &[usize], p: [&[f32]; 3], centers: &mut [f32]| {
        evaluator.distances(&p[0][..n], &p[1][..n], &p[2][..n], &mut d[..n]);
        for (&place, &d) in places[..n].iter().zip(&d) {
            centers[place] = d;
        }
    };
    for i in 0..centers.len() {
        let cell = morton_cell(first + i as u32);
        if !layout.contains_voxels(cell) {
            continue;
        }
        let p = layout.center(cell);
        (x[n], y[n], z[n], places[n]) = (p.x, p.y, p.z, i);
        n += 1;
        if n == LANES {
            measure(n, &places, [&x, &y, &z], centers);
            n = 0;
        }
    }
    if n > 0 {
        measure(n, &places, [&x, &y, &z], centers);
    }
}
