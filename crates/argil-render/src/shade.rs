//! The colors of a tile's hits: light, or what other modes show. `shade.wgsl` is the twin.

use crate::false_colors::{depth, heat, id_color, level_color};
use crate::light::{Light, LightSource, reflect};
use crate::probe::FieldProbe;
use crate::source::DistanceSource;
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use argil_abi::{self as abi, FrameUniform, Hit};
use glam::{Vec3, vec3};

/// Adds the colors of a tile's hits, one frame each, times the frame's sample weight, to `out`: RGB and coverage.
/// Shaded colors are linear, after the tone curve. Other modes add their own values.
///
/// # Panics
/// If there are fewer hits than frames, or if these or `out` are shorter than the tile's area.
pub(crate) fn shade_tile(
    frames: &[FrameUniform],
    tile: Tile,
    probe: &mut FieldProbe<'_>,
    air: Option<&dyn DistanceSource>,
    scratch: &mut TileScratch,
    hits: &[Vec<Hit>],
    out: &mut [[f32; 4]],
) {
    let Some(first) = frames.first() else { return };
    if first.mode == abi::MODE_SHADED {
        let TileScratch {
            points,
            source: scratch_of_source,
            ..
        } = scratch;
        let light: &mut Light = scratch_of_source.of();
        let mut source = LightSource { probe, air };
        light.gather(frames, tile, &mut source, points, hits);
        reflect::add_colors(first, light, out);
        return;
    }
    for (frame, hits) in frames.iter().zip(hits) {
        for (hit, out) in hits.iter().zip(&mut *out).take(tile.area()) {
            let [r, g, b] = (frame.sample_weight * shown(frame, hit)).to_array();
            let is_covered = matches!(hit.kind, abi::HIT_OUTSIDE | abi::HIT_INSIDE);
            let covered = if is_covered { frame.sample_weight } else { 0.0 };
            for (out, value) in out.iter_mut().zip([r, g, b, covered]) {
                *out += value;
            }
        }
    }
}

/// Returns what a mode without light shows of a hit.
fn shown(frame: &FrameUniform, hit: &Hit) -> Vec3 {
    match frame.mode {
        abi::MODE_NORMAL if hit.kind != abi::HIT_NONE => {
            vec3(hit.normal_t[0], hit.normal_t[1], hit.normal_t[2]) * 0.5 + 0.5
        }
        abi::MODE_DEPTH if hit.kind != abi::HIT_NONE => Vec3::splat(depth(frame, hit.normal_t[3])),
        abi::MODE_HEAT => heat(frame, hit.steps),
        abi::MODE_BRICKS | abi::MODE_NODES if hit.id != 0 => id_color(hit),
        abi::MODE_LEVELS if hit.id != 0 => level_color(hit),
        _ => Vec3::ZERO,
    }
}
