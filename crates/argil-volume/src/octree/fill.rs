//! The texels of bricks, and what stands in the cells without one; `fill.wgsl` beside this and in the crate's root are
//! the twins.

use super::{Layout, Tree};
use crate::encoding::encode;
use crate::{Texel, Texels};
use argil_abi::{Fill, Volume};
use argil_field::{Evaluator, Grid, Program};
use argil_math::morton;
use glam::{UVec3, uvec3};
use rayon::prelude::*;

/// Fill the whole texture, layer by layer.
pub(super) fn bricks<T: Texel>(
    program: &Program,
    layout: &Layout,
    words: &Volume,
    fill: &Fill,
    tree: &Tree,
    centers: &[f32],
) -> Texels {
    let all = layout.lattice.grid(0);
    let xs = all.xs();
    let (size, brick, grid) = (layout.lattice.size, layout.brick, layout.grid);
    let mut texels = vec![T::default(); layout.lattice.texel_count(0) as usize];
    texels
        .par_chunks_mut(all.layer_len())
        .zip(0..size.z)
        .for_each_init(
            || Evaluator::new(program),
            |evaluator, (layer, z)| {
                for cell_y in 0..grid.y {
                    for cell_x in 0..grid.x {
                        let cell = uvec3(cell_x, cell_y, z / brick);
                        let code = morton(cell);
                        let begin = UVec3::new(cell_x * brick, cell_y * brick, z);
                        let part = Grid {
                            begin,
                            size: (UVec3::new(size.x, size.y, z + 1) - begin)
                                .min(uvec3(brick, brick, 1)),
                            ..all
                        };
                        let mut store = |i: usize, integers: &[T]| {
                            scatter(&part, size.x as usize, layer, i, integers);
                        };
                        if tree.codes().binary_search(&code).is_ok() {
                            let mut out = [T::default(); argil_field::LANES];
                            let first = begin.x as usize;
                            let xs = &xs[first..first + part.size.x as usize];
                            part.sweep_layer(evaluator, xs, 0, |range, d| {
                                encode(d, fill, &mut out[..d.len()]);
                                store(range.start, &out[..d.len()]);
                            });
                        } else {
                            let away = centers.get(code as usize).copied().unwrap_or(0.0);
                            let integer = T::stored(vacant(words, fill, away));
                            let row = [integer; 32];
                            let n = part.size.x as usize;
                            for j in 0..part.size.y as usize {
                                store(j * n, &row[..n]);
                            }
                        }
                    }
                }
            },
        );
    Texels::from_vec(texels)
}

/// What is stored in all texels of a cell without a brick, whose centre is so far from the surface: the distance that
/// none of them falls short of, at least one step so that the sign is kept.
fn vacant(words: &Volume, fill: &Fill, away: f32) -> i32 {
    let low = |a: f32, b: f32| if b < a { b } else { a };
    let magnitude = away.abs() - words.spread;
    let quanta = fill.quanta as f32;
    let integer = (low(magnitude * fill.spacing_scale[3], quanta).floor() as i32).max(1);
    if away < 0.0 { -integer } else { integer }
}

/// Put a stretch of a part's layer, from its point `first` on, where it belongs in the volume's layer.
fn scatter<T: Copy>(part: &Grid, width: usize, layer: &mut [T], first: usize, from: &[T]) {
    let nx = part.size.x as usize;
    let mut done = 0;
    while done < from.len() {
        let (i, j) = ((first + done) % nx, (first + done) / nx);
        let run = (nx - i).min(from.len() - done);
        let to = (part.begin.y as usize + j) * width + part.begin.x as usize + i;
        layer[to..to + run].copy_from_slice(&from[done..done + run]);
        done += run;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vacant_cells_keep_their_sign_and_never_exceed_the_distance() {
        let words = Volume {
            spread: 0.5,
            ..Volume::default()
        };
        let fill = Fill {
            spacing_scale: [1.0, 1.0, 1.0, 127.0],
            quanta: 127,
            ..Fill::default()
        };
        let at = |away| vacant(&words, &fill, away);
        assert_eq!([at(9.0), at(-9.0), at(0.1), at(-0.1)], [127, -127, 1, -1]);
        assert_eq!(at(1.0), 63);
    }
}
