//! The box of what samples find inside a solid.
//!
//! *Theory.* The distance to a box is convex. What interpolates between samples that are at least as large is as large, too.

use super::nest::{CellSamples, Nest, NestLevel, corners, index, place_of, volume};
use argil_math::Aabb;
use glam::{IVec3, UVec3};
use rayon::prelude::*;

impl Nest {
    /// Cuts the box of a solid down to the intervals that have a sample inside, and makes distances at least those to the
    /// result. Returns all of the box if no sample is inside.
    pub(super) fn tighten(&mut self, solid: Aabb) -> Aabb {
        let Some((low, high)) = self.levels[0].span_of_solid() else {
            return solid;
        };
        let tight = Aabb::new(self.position(low), self.position(high)).intersection(solid);
        if tight.is_empty() {
            return solid;
        }
        let (corner, unit) = (self.corner, self.unit);
        let raise = |units: IVec3, d: &mut f32| {
            let of_box = tight.distance(corner + unit * units.as_vec3());
            // NaN stays NaN, which a maximum would hide.
            if of_box > 0.0 && *d < of_box {
                *d = of_box;
            }
        };
        for level in &mut self.levels {
            let (first, width, count) = (level.first, level.width, level.count);
            let corners = level.coarse.par_iter_mut().enumerate();
            corners.for_each(|(i, d)| raise(first + width * place_of(i, count + 1).as_ivec3(), d));
            let cells = level.cells.par_iter_mut().enumerate();
            cells.for_each(|(i, cell)| {
                let begin = first + width * place_of(i, count).as_ivec3();
                let points = UVec3::splat((1 << cell.kind) + 1);
                let interval = width >> cell.kind;
                for (n, d) in cell.samples.iter_mut().enumerate() {
                    raise(begin + interval * place_of(n, points).as_ivec3(), d);
                }
            });
        }
        tight
    }
}

impl NestLevel {
    /// Returns the first and the last corner of the intervals that have a sample inside the solid, in units.
    fn span_of_solid(&self) -> Option<(IVec3, IVec3)> {
        let spans = (0..volume(self.count)).into_par_iter();
        let spans = spans.filter_map(|cell| {
            let place = place_of(cell, self.count);
            let CellSamples { kind, samples, .. } = &self.cells[cell];
            let side = UVec3::splat(1 << kind);
            let around = corners(place).map(|p| self.coarse[index(p, self.count + 1)]);
            let samples = if *kind == 0 {
                &around[..]
            } else {
                &samples[..]
            };
            let inside = (0..samples.len()).filter(|&i| samples[i] <= 0.0);
            let inside = inside.map(|i| place_of(i, side + 1));
            let spans = inside.map(|p| (p.saturating_sub(UVec3::ONE), (p + 1).min(side)));
            let (low, high) = spans.reduce(united)?;
            let at = |p: UVec3| self.corner_at(place) + (self.width >> kind) * p.as_ivec3();
            Some((at(low), at(high)))
        });
        spans.reduce_with(|(low, high), (a, b)| (low.min(a), high.max(b)))
    }
}

fn united((low, high): (UVec3, UVec3), (a, b): (UVec3, UVec3)) -> (UVec3, UVec3) {
    (low.min(a), high.max(b))
}
