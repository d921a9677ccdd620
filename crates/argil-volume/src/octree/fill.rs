//! The texels of bricks, and what stands in the cells without one; `fill.wgsl` beside this and in the crate's root are
//! the twins.

use super::{OctreeLayout, OctreeNodes};
use crate::{Texel, Texels, bake_level::sample};
use argil_abi::{FillUniform, OctreeVolume};
use argil_field::Program;
use argil_math::{Control, morton};
use glam::UVec3;

/// FillUniform the whole texture: bricks with what can matter in each of their cells.
pub(super) fn bricks<T: Texel>(
    program: &Program,
    layout: &OctreeLayout,
    words: &OctreeVolume,
    fill: &FillUniform,
    (tree, centers): (&OctreeNodes, &[f32]),
    control: &Control,
) -> Texels {
    let vacant = |first: UVec3| {
        let code = morton(first / layout.brick_size_voxels);
        let away = centers.get(code as usize).copied().unwrap_or(0.0);
        let has_brick = tree.codes().binary_search(&code).is_ok();
        (!has_brick).then(|| T::stored(vacant(words, fill, away)))
    };
    sample(program, &layout.voxel_grid.grid(0), fill, &vacant, control)
}

/// What is stored in all texels of a cell without a brick, whose center is so far from the surface: the distance that
/// none of them falls short of, at least one step so that the sign is kept.
fn vacant(words: &OctreeVolume, fill: &FillUniform, away: f32) -> i32 {
    let low = |a: f32, b: f32| if b < a { b } else { a };
    let magnitude = away.abs() - words.spread;
    let quanta = fill.quanta as f32;
    let integer = (low(magnitude * fill.spacing_scale[3], quanta).floor() as i32).max(1);
    if away < 0.0 { -integer } else { integer }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vacant_cells_keep_their_sign_and_never_exceed_the_distance() {
        let words = OctreeVolume {
            spread: 0.5,
            ..OctreeVolume::default()
        };
        let fill = FillUniform {
            spacing_scale: [1.0, 1.0, 1.0, 127.0],
            quanta: 127,
            ..FillUniform::default()
        };
        let at = |away| vacant(&words, &fill, away);
        assert_eq!([at(9.0), at(-9.0), at(0.1), at(-0.1)], [127, -127, 1, -1]);
        assert_eq!(at(1.0), 63);
    }
}
