//! Turns bounds of distances into distances.
//!
//! *Theory.* A field whose slope is not 1 has bounds. Newton's method steps to its surface along the gradient, and the length of
//! that way is nearly the distance. At edges and corners, exact fields have a slope of 1, which differences between samples hide.

use argil_abi::Instruction;
use argil_field::{Evaluator, LANES};
use glam::Vec3;

/// Samples of a leaf.
pub(super) const SAMPLES: usize = 512;

/// A slope that differs less from 1 is 1.
const SLOPE_TOLERANCE: f32 = 0.02;
/// The least slope that values are divided by.
const MIN_SLOPE: f32 = 0.05;
/// Steps from a sample to the surface.
const STEPS: usize = 2;

/// A place on the way from a sample to the surface.
struct Walk {
    /// The sample, and its position.
    place: usize,
    from: Vec3,
    at: Vec3,
    is_done: bool,
}

/// Replaces values nearer than `reach` by distances to the surface, where the field's slope is not 1. The first program holds in
/// the leaf, and the second one as far as `band` around it.
pub(super) fn correct(
    evaluator: &mut Evaluator<'_>,
    [program, outer]: [&[Instruction]; 2],
    points: &[[f32; SAMPLES]; 3],
    (values, [band, reach]): (&mut [f32; SAMPLES], [f32; 2]),
) {
    let walk = |place: usize| {
        let from = Vec3::from(points.each_ref().map(|axis| axis[place]));
        Walk {
            place,
            from,
            at: from,
            is_done: false,
        }
    };
    let is_near = |place: &usize| values[*place].abs() < reach;
    let mut walks: Vec<Walk> = (0..SAMPLES).filter(is_near).map(walk).collect();
    for nth in 0..STEPS {
        let program = if nth == 0 { program } else { outer };
        step(evaluator, program, &mut walks, &mut |walk, d, gradient| {
            let slope = gradient.length();
            // Where a box cuts the solid off, values are those to its sides.
            let is_exact = (slope - 1.0).abs() <= SLOPE_TOLERANCE || values[walk.place] > d;
            walk.is_done |= nth == 0 && is_exact;
            // Farther away, nothing is stored, and the program does not hold.
            if !walk.is_done && walk.from.distance(walk.at) < band {
                let length = (d / slope.max(MIN_SLOPE)).clamp(-band, band);
                walk.at -= gradient.normalize_or_zero() * length;
            }
        });
        walks.retain(|walk| !walk.is_done);
    }
    for Walk {
        place, from, at, ..
    } in walks
    {
        values[place] = from.distance(at).copysign(values[place]);
    }
}

/// Calls a function for each walk, with the distance and the gradient there.
fn step(
    evaluator: &mut Evaluator<'_>,
    program: &[Instruction],
    walks: &mut [Walk],
    advance: &mut dyn FnMut(&mut Walk, f32, Vec3),
) {
    let (mut points, mut gradients) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    let mut out = [0.0; LANES];
    for chunk in walks.chunks_mut(LANES) {
        let count = chunk.len();
        for (i, walk) in chunk.iter().enumerate() {
            for (axis, along) in points.iter_mut().enumerate() {
                along[i] = walk.at[axis];
            }
        }
        let at = points.each_ref().map(|axis| &axis[..count]);
        let all = gradients.each_mut().map(|axis| &mut axis[..count]);
        evaluator.gradients_with(program, at, &mut out[..count], all);
        for (i, walk) in chunk.iter_mut().enumerate() {
            let gradient = Vec3::from(gradients.each_ref().map(|axis| axis[i]));
            advance(walk, out[i], gradient);
        }
    }
}
