//! Fills bricks and vacant cells. Its twins are `fill.wgsl` in this folder and in the crate's root.

use super::{OctreeLayout, OctreeNodes};
use crate::{Texel, Texels, bake_level::sample};
use argil_abi::{FillUniform, OctreeUniform};
use argil_field::Program;
use argil_math::{Control, morton};
use glam::UVec3;

/// Fills the whole texture: bricks with pruned programs, and vacant cells.
pub(super) fn bricks<T: Texel>(
    program: &Program,
    layout: &OctreeLayout,
    words: &OctreeUniform,
    fill: &FillUniform,
    (tree, centers): (&OctreeNodes, &[f32]),
    control: &Control,
) -> Texels {
    let vacant = |first: UVec3| {
        let code = morton(first / layout.brick_size_voxels);
        let away = centers.get(code as usize).copied().unwrap_or(0.0);
        let has_brick = tree.codes().binary_search(&code).is_ok();
        (!has_brick).then(|| T::from_code(vacant(words, fill, away)))
    };
    sample(program, &layout.voxel_grid.grid(0), fill, &vacant, control)
}

/// Returns the value of all samples in a vacant cell, given the distance at its center: a lower bound for all of
/// them, and at least one code step, so that the sign survives.
fn vacant(words: &OctreeUniform, fill: &FillUniform, away: f32) -> i32 {
    let low = |a: f32, b: f32| if b < a { b } else { a };
    let magnitude = away.abs() - words.sample_margin;
    let quanta = fill.max_code as f32;
    let integer = (low(magnitude * fill.spacing_scale[3], quanta).floor() as i32).max(1);
    if away < 0.0 { -integer } else { integer }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vacant_cells_keep_their_sign_and_never_exceed_the_distance() {
        let words = OctreeUniform {
            sample_margin: 0.5,
            ..OctreeUniform::default()
        };
        let fill = FillUniform {
            spacing_scale: [1.0, 1.0, 1.0, 127.0],
            max_code: 127,
            ..FillUniform::default()
        };
        let at = |away| vacant(&words, &fill, away);
        assert_eq!([at(9.0), at(-9.0), at(0.1), at(-0.1)], [127, -127, 1, -1]);
        assert_eq!(at(1.0), 63);
    }
}
