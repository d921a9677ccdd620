//! Maps for points that are relative to an origin.
//!
//! *Theory.* 100 km from the origin, a coordinate in `f32` is off by millimeters. A page of a wide world is evaluated
//! relative to its own corner instead. A map into a solid's frame is R·(q + o − p), with the page's origin o and the
//! place p of the solid in the world. Both are large and precise, so their difference is taken in `f64`, once for all
//! points of a batch; then everything is as small as the page and the solid.

use crate::Program;
use crate::interpreter_state::words;
use argil_abi::{self as abi, Instruction};
use argil_math::Aabb;
use glam::{DAffine3, DVec3};

/// Words of a place: nine, and three spare ones. They precede the words of a map.
pub(crate) const PLACE_WORDS: usize = 12;

/// Returns the number of words in front of an instruction's own.
pub(crate) fn place_words_of(instr: &Instruction) -> u32 {
    if instr.op < abi::OP_SHAPES_END || instr.op == abi::OP_AFFINE {
        PLACE_WORDS as u32
    } else {
        0
    }
}

/// Returns the words of the point that a map moves to its frame's origin: three parts of each coordinate, which add up
/// to all of its digits.
pub(crate) fn place_words(own_from_point: &DAffine3) -> [f32; PLACE_WORDS] {
    let place = own_from_point.inverse().translation;
    let mut words = [0.0; PLACE_WORDS];
    for axis in 0..3 {
        let mut rest = place[axis];
        for part in 0..3 {
            let word = rest as f32;
            // Overflow and NaN cannot be split.
            let word = if word.is_finite() { word } else { 0.0 };
            words[3 * part + axis] = word;
            rest -= f64::from(word);
        }
    }
    words
}

/// Returns a map for points relative to an origin, given where its words begin. `repeat` holds the words of a repetition
/// that follows, if there is one.
pub(crate) fn placed(params: &[f32], at: usize, origin: DVec3, repeat: &[f32]) -> [f32; 12] {
    let [x, y, z] = (origin - place_of(params, at)).to_array();
    let mut m: [f32; 12] = *words(params, at);
    let offset = [0, 1, 2].map(|row: usize| {
        let [a, b, c] = [m[4 * row], m[4 * row + 1], m[4 * row + 2]].map(f64::from);
        a * x + b * y + c * z
    });
    let offset = wrapped(offset, repeat);
    for (row, offset) in offset.into_iter().enumerate() {
        m[4 * row + 3] = offset;
    }
    m
}

/// Rounds an offset. Along the axes of an endless repetition, it first goes toward 0 by whole steps, because all copies
/// are the same.
pub(crate) fn wrapped(offset: [f64; 3], repeat: &[f32]) -> [f32; 3] {
    [0, 1, 2].map(|axis: usize| {
        let word = |index: usize| repeat.get(3 * index + axis).copied().unwrap_or(0.0);
        let (step, low, high) = (f64::from(word(0)), word(2), word(3));
        let is_endless = low <= -ENDLESS && high >= ENDLESS && step > 0.0;
        let steps = if is_endless {
            (offset[axis] / step).round()
        } else {
            0.0
        };
        (offset[axis] - step * steps) as f32
    })
}

impl Program {
    /// Returns the largest coordinate that determines how a list's distances are rounded in a box that is relative to an
    /// origin: how far the maps into solids reach, and the coordinates in the scene's space where an instruction needs
    /// those.
    pub fn rounding_coordinate(
        &self,
        instructions: &[Instruction],
        region: Aabb,
        origin: Option<DVec3>,
    ) -> f32 {
        let in_region = region.min.abs().max(region.max.abs()).max_element();
        let Some(origin) = origin else {
            return in_region;
        };
        let in_scene = in_region + origin.abs().max_element() as f32;
        let (mut reach, mut depth, mut absolute_from) = (0.0f32, 0usize, usize::MAX);
        for instr in instructions {
            match instr.op {
                abi::OP_PUSH_POINT => depth += 1,
                abi::OP_POP_POINT => {
                    depth = depth.saturating_sub(1);
                    if depth < absolute_from {
                        absolute_from = usize::MAX;
                    }
                }
                _ if depth >= absolute_from => {}
                op if op < abi::OP_SHAPES_END || op == abi::OP_AFFINE => {
                    let away = origin - place_of(&self.params, instr.params as usize);
                    reach = reach.max(away.abs().max_element() as f32);
                    if op == abi::OP_AFFINE {
                        absolute_from = depth;
                    }
                }
                abi::OP_PUSH_VALUE | abi::OP_COMBINE | abi::OP_ROUND | abi::OP_SHELL => {}
                _ => return in_scene,
            }
        }
        in_region + reach.min(in_scene)
    }
}

/// Returns the place in front of a map's words.
fn place_of(params: &[f32], at: usize) -> DVec3 {
    let place: &[f32; PLACE_WORDS] = words(params, at.wrapping_sub(PLACE_WORDS));
    let [x, y, z] = [0, 1, 2].map(|axis: usize| {
        let parts = [0, 3, 6].map(|part| f64::from(place[part + axis]));
        parts[0] + parts[1] + parts[2]
    });
    DVec3::new(x, y, z)
}

/// The number of the last cell of an endless repetition.
pub(crate) const ENDLESS: f32 = 1e9;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_place_keeps_all_digits() {
        let turn = DQuat::from_rotation_y(0.3);
        let place = DVec3::new(100_000.123_456_789, -3.000_000_1, 1e-7);
        let world_from_own = DAffine3::from_rotation_translation(turn, place);
        let map = world_from_own.inverse();
        let mut params = place_words(&map).to_vec();
        params.extend([0.0f32; 12]);
        for (row, words) in params[PLACE_WORDS..].chunks_exact_mut(4).enumerate() {
            for (column, word) in words.iter_mut().take(3).enumerate() {
                *word = map.matrix3.col(column)[row] as f32;
            }
        }
        // A point 1 m from the solid, in a page 3 m from it.
        let origin = place + DVec3::new(2.0, 2.0, 1.0);
        let m = placed(&params, PLACE_WORDS, origin, &[]);
        let q = DVec3::new(-1.5, -1.0, -0.25);
        let exact = map.transform_point3(origin + q);
        let q = q.as_vec3();
        for row in 0..3 {
            let w = &m[4 * row..4 * row + 4];
            let rounded = w[0] * q.x + w[1] * q.y + w[2] * q.z + w[3];
            assert!(
                (f64::from(rounded) - exact[row]).abs() < 5e-7,
                "{rounded} {exact}"
            );
        }
    }
}
