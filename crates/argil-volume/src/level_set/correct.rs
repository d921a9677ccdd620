//! Where a field has bounds instead of distances, and what they are divided by.
//!
//! *Theory.* A field of distances has a slope of 1. Elsewhere, its difference to the samples beside one that are nearer to the
//! surface tells the slope on the way there, and a bound divided by it is nearly a distance. At edges and corners, that
//! difference is too small for distances, too, so only the gradient tells that they are exact.

use argil_abi::Instruction;
use argil_field::{Evaluator, LANES};
use glam::Vec3;

/// Samples of a leaf.
pub(super) const SAMPLES: usize = 512;
/// Samples along a leaf's side, with one more on each side.
pub(super) const WIDE: usize = 10;
/// Samples of a leaf with one more on each side.
pub(super) const WIDE_SAMPLES: usize = WIDE * WIDE * WIDE;

/// A slope that differs less from 1 is 1.
const SLOPE_TOLERANCE: f32 = 0.02;
/// The least slope that values are divided by.
const MIN_SLOPE: f32 = 0.05;

/// Divides values by their slopes where they are bounds, given the samples of a leaf and around it. Values of `reach` or more stay.
/// Where a box cuts the solid off, values are those to its sides, with a slope of 1.
pub(super) fn correct(
    evaluator: &mut Evaluator<'_>,
    program: &[Instruction],
    points: &[[f32; SAMPLES]; 3],
    (wide, voxel): (&[f32; WIDE_SAMPLES], f32),
    (values, reach): (&mut [f32; SAMPLES], f32),
) {
    let slope_of = |sample: usize| {
        let [x, y, z] = [sample / 64, sample / 8 % 8, sample % 8];
        slope(wide, ((x + 1) * WIDE + y + 1) * WIDE + z + 1, voxel)
    };
    let is_near = |sample: &usize| values[*sample].abs() < reach;
    let near = (0..SAMPLES).filter(is_near).map(|i| (i, slope_of(i)));
    let doubtful: Vec<(usize, f32)> = near.filter(|(_, slope)| !is_one(*slope)).collect();
    let (mut at, mut gradients) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    let mut out = [0.0; LANES];
    for chunk in doubtful.chunks(LANES) {
        let count = chunk.len();
        for (along, from) in at.iter_mut().zip(points) {
            for (c, (sample, _)) in along.iter_mut().zip(chunk) {
                *c = from[*sample];
            }
        }
        let from = at.each_ref().map(|axis| &axis[..count]);
        let all = gradients.each_mut().map(|axis| &mut axis[..count]);
        evaluator.gradients_with(program, from, &mut out[..count], all);
        for (i, &(sample, slope)) in chunk.iter().enumerate() {
            let exact = Vec3::from(gradients.each_ref().map(|axis| axis[i])).length();
            let value = &mut values[sample];
            if *value <= out[i] && !is_one(exact) {
                *value /= slope.max(MIN_SLOPE);
            }
        }
    }
}

fn is_one(slope: f32) -> bool {
    (slope - 1.0).abs() <= SLOPE_TOLERANCE
}

/// Returns the slope of samples away from the surface, by the scheme of Godunov for |∇d| = 1 (Rouy and Tourin, "A viscosity
/// solutions approach to shape-from-shading", 1992). Across a crease, it is that of one side.
fn slope(samples: &[f32; WIDE_SAMPLES], place: usize, voxel: f32) -> f32 {
    let own = samples[place];
    let sign = if own < 0.0 { -1.0 } else { 1.0 };
    let mut square = 0.0;
    for stride in [1, WIDE, WIDE * WIDE] {
        // How much nearer to the surface either neighbor is.
        let before = sign * (own - samples[place - stride]);
        let after = sign * (own - samples[place + stride]);
        let nearer = before.max(after).max(0.0);
        square += nearer * nearer;
    }
    square.sqrt() / voxel
}
