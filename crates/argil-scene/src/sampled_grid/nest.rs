//! Nested levels of cells while they are built, and the seams between cells of different intervals.
//!
//! *Practice.* Places are whole numbers of units: the finest interval of the first level. A level's cells are twice as wide
//! as those of the level before, and begin at multiples of their width from its corner. Where levels overlap, the first
//! one counts.

use glam::{IVec3, UVec3, Vec3, ivec3, uvec3};
use rayon::prelude::*;

/// Units along a cell of the first level.
pub(super) const UNITS: i32 = 8;

/// The kind of cells with the most intervals: 2 to the power of the kind. Those of kind 0 have only their corners.
pub(super) const MAX_KIND: u8 = 3;

/// A level: cells of one size in a box.
pub(super) struct NestLevel {
    /// The first corner, and a cell's width, in units.
    pub(super) first: IVec3,
    pub(super) width: i32,
    pub(super) count: UVec3,
    /// Samples at corners of cells.
    pub(super) coarse: Vec<f32>,
    pub(super) cells: Vec<CellSamples>,
}

/// The samples of a cell.
#[derive(Default)]
pub(super) struct CellSamples {
    pub(super) kind: u8,
    pub(super) max_kind: u8,
    /// None for kind 0.
    pub(super) samples: Vec<f32>,
}

impl NestLevel {
    /// Returns a corner of cells, in units.
    pub(super) fn corner_at(&self, place: UVec3) -> IVec3 {
        self.first + self.width * place.as_ivec3()
    }

    /// Returns the distance between a cell's samples, in units.
    fn interval(&self, index: usize) -> i32 {
        self.width >> self.cells[index].kind
    }

    /// Returns the level's box, in units.
    pub(super) fn span(&self) -> [IVec3; 2] {
        [self.first, self.corner_at(self.count)]
    }
}

/// A cell: its level and its index there.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct NestCell {
    pub(super) level: usize,
    pub(super) index: usize,
}

/// A cell with a wider neighbor that differs much from it on their common face.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RoughSeam {
    pub(super) cell: NestCell,
    pub(super) wider: NestCell,
}

/// A sample on a cell's face, the cell with the widest interval that touches it, and the value that one interpolates there.
struct SeamSample {
    sample: usize,
    wider: NestCell,
    value: f32,
}

/// Levels around each other, the finest first.
pub(super) struct Nest {
    pub(super) corner: Vec3,
    /// Length of a unit.
    pub(super) unit: f32,
    pub(super) levels: Vec<NestLevel>,
}

impl Nest {
    pub(super) fn new(corner: Vec3, cell: f32) -> Self {
        Self {
            corner,
            unit: cell / UNITS as f32,
            levels: Vec::new(),
        }
    }

    /// Adds a level. It has an even number of cells along each axis, so that the next one's do not overlap it in part.
    pub(super) fn add(&mut self, first: IVec3, count: UVec3) {
        self.levels.push(NestLevel {
            first,
            width: UNITS << self.levels.len(),
            count: count.map(|n| n.next_multiple_of(2)),
            coarse: Vec::new(),
            cells: Vec::new(),
        });
    }

    pub(super) fn position(&self, units: IVec3) -> Vec3 {
        self.corner + self.unit * units.as_vec3()
    }

    /// Whether a finer level has all of a cell.
    pub(super) fn is_covered(&self, level: usize, place: UVec3) -> bool {
        let Some(finer) = level.checked_sub(1).map(|finer| &self.levels[finer]) else {
            return false;
        };
        let corner = self.levels[level].corner_at(place);
        let [low, high] = finer.span();
        corner.cmpge(low).all() && (corner + self.levels[level].width).cmple(high).all()
    }

    /// Gives all samples on faces of cells the value that the widest interval there interpolates, so that nothing jumps.
    pub(super) fn close_seams(&mut self) {
        let mut interval = self.levels.last().map_or(0, |level| level.width);
        while interval > 0 {
            for level in 0..self.levels.len() {
                if self.levels[level].width == interval {
                    self.close_corners(level);
                }
                let nest_level = &self.levels[level];
                let is_next = |i: &usize| {
                    nest_level.cells[*i].kind > 0 && nest_level.interval(*i) == interval
                };
                let changes: Vec<(usize, Vec<SeamSample>)> = (0..nest_level.cells.len())
                    .into_par_iter()
                    .filter(is_next)
                    .map(|index| (index, self.seams_of(level, index)))
                    .collect();
                for (index, seams) in changes {
                    for seam in seams {
                        self.levels[level].cells[index].samples[seam.sample] = seam.value;
                    }
                }
            }
            interval /= 2;
        }
    }

    /// Returns the seams among some cells where a wider neighbor's interpolation differs from a cell's samples by more than a
    /// share of the cell's interval.
    pub(super) fn rough_seams(&self, cells: &[NestCell], share: f32) -> Vec<RoughSeam> {
        let seams = |&cell: &NestCell| {
            let level = &self.levels[cell.level];
            let max_error = share * self.unit * level.interval(cell.index) as f32;
            let is_rough = move |seam: &SeamSample| {
                (seam.value - level.cells[cell.index].samples[seam.sample]).abs() > max_error
            };
            let seams = self.seams_of(cell.level, cell.index);
            let rough = seams.into_iter().filter(is_rough);
            rough.map(move |seam| RoughSeam {
                cell,
                wider: seam.wider,
            })
        };
        let mut rough: Vec<RoughSeam> = cells.par_iter().flat_map_iter(seams).collect();
        rough.sort_unstable();
        rough.dedup();
        rough
    }

    /// Returns all cells that have more samples than their corners.
    pub(super) fn sampled_cells(&self) -> Vec<NestCell> {
        let of_level = |(level, nest_level): (usize, &NestLevel)| {
            let is_sampled = |&index: &usize| nest_level.cells[index].kind > 0;
            let cells = (0..nest_level.cells.len()).filter(is_sampled);
            cells
                .map(|index| NestCell { level, index })
                .collect::<Vec<_>>()
        };
        self.levels.iter().enumerate().flat_map(of_level).collect()
    }

    fn close_corners(&mut self, level: usize) {
        let nest_level = &self.levels[level];
        let points = nest_level.count + 1;
        let change = |i: usize| {
            let place = place_of(i, points);
            let is_outer = place.cmpeq(UVec3::ZERO) | place.cmpeq(nest_level.count);
            let at = nest_level.corner_at(place);
            let toward = |i: i32| self.cell_toward(at, 2 * ivec3(i & 1, i >> 1 & 1, i >> 2) - 1);
            let wider = is_outer
                .any()
                .then(|| self.widest((0..8).filter_map(toward), nest_level.width));
            wider.flatten().map(|wider| (i, self.value_in(wider, at)))
        };
        let changes: Vec<(usize, f32)> = (0..volume(points))
            .into_par_iter()
            .filter_map(change)
            .collect();
        for (i, value) in changes {
            self.levels[level].coarse[i] = value;
        }
    }

    /// Returns the samples on a cell's faces that touch cells of wider intervals.
    fn seams_of(&self, level: usize, index: usize) -> Vec<SeamSample> {
        let nest_level = &self.levels[level];
        let interval = nest_level.interval(index);
        let first = nest_level.corner_at(place_of(index, nest_level.count));
        let around: [Option<NestCell>; 27] = std::array::from_fn(|i| {
            let beside = first + nest_level.width / 2 + nest_level.width * offset_of(i);
            self.cell_toward(beside, IVec3::ONE)
        });
        let is_wider = |cell: &NestCell| self.interval(*cell) > interval;
        let wider: Vec<(IVec3, NestCell)> = (0..27)
            .filter_map(|i| Some((offset_of(i), around[i].filter(is_wider)?)))
            .collect();
        // Several cells of a finer level may lie beside a face.
        let is_beside_finer = around.iter().flatten().any(|cell| cell.level < level);
        if !is_beside_finer && wider.is_empty() {
            return Vec::new();
        }
        let side = 1u32 << nest_level.cells[index].kind;
        let points = UVec3::splat(side + 1);
        let seam = |sample: usize| {
            let inner = place_of(sample, points);
            let low = inner.cmpeq(UVec3::ZERO);
            let high = inner.cmpeq(UVec3::splat(side));
            if !(low | high).any() {
                return None;
            }
            let at = first + interval * inner.as_ivec3();
            let toward = |i: i32| self.cell_toward(at, 2 * ivec3(i & 1, i >> 1 & 1, i >> 2) - 1);
            let touching = |(offset, cell): &(IVec3, NestCell)| {
                let is_low = offset.cmplt(IVec3::ZERO) & !low;
                let is_high = offset.cmpgt(IVec3::ZERO) & !high;
                (!(is_low | is_high).any()).then_some(*cell)
            };
            let wider = if is_beside_finer {
                self.widest((0..8).filter_map(toward), interval)
            } else {
                self.widest(wider.iter().filter_map(touching), interval)
            };
            wider.map(|wider| SeamSample {
                sample,
                wider,
                value: self.value_in(wider, at),
            })
        };
        (0..volume(points)).filter_map(seam).collect()
    }

    /// Returns the cell with the widest interval, if that is wider than another.
    fn widest(&self, cells: impl Iterator<Item = NestCell>, interval: i32) -> Option<NestCell> {
        cells
            .filter(|cell| self.interval(*cell) > interval)
            .max_by_key(|cell| self.interval(*cell))
    }

    fn interval(&self, cell: NestCell) -> i32 {
        self.levels[cell.level].interval(cell.index)
    }

    /// Returns the cell beside a point, in the direction of signs.
    fn cell_toward(&self, at: IVec3, toward: IVec3) -> Option<NestCell> {
        self.levels
            .iter()
            .enumerate()
            .find_map(|(level, nest_level)| {
                // Half a step below is in the cell before.
                let below = toward.min(IVec3::ZERO);
                let place = (at - nest_level.first + below).map(|c| c.div_euclid(nest_level.width));
                let is_in = place.cmpge(IVec3::ZERO) & place.cmplt(nest_level.count.as_ivec3());
                is_in.all().then(|| NestCell {
                    level,
                    index: index(place.as_uvec3(), nest_level.count),
                })
            })
    }

    fn value_in(&self, cell: NestCell, at: IVec3) -> f32 {
        let level = &self.levels[cell.level];
        let place = place_of(cell.index, level.count);
        let CellSamples { kind, samples, .. } = &level.cells[cell.index];
        let interval = level.width >> kind;
        let side = 1 << kind;
        let offset = (at - level.corner_at(place)).as_uvec3();
        let inner = (offset / interval as u32).min(UVec3::splat(side - 1));
        let t = (offset - interval as u32 * inner).as_vec3() / interval as f32;
        let around = match kind {
            0 => corners(place).map(|p| level.coarse[index(p, level.count + 1)]),
            _ => corners(inner).map(|p| samples[index(p, UVec3::splat(side + 1))]),
        };
        interpolate(around, t)
    }
}

/// Interpolates between eight values, x fastest.
pub(super) fn interpolate(v: [f32; 8], t: Vec3) -> f32 {
    let along = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let row = |i: usize| along(v[i], v[i + 1], t.x);
    along(along(row(0), row(2), t.y), along(row(4), row(6), t.y), t.z)
}

/// Returns the offset of one of 27 neighbors, or of the cell itself.
fn offset_of(i: usize) -> IVec3 {
    place_of(i, UVec3::splat(3)).as_ivec3() - 1
}

pub(super) fn volume(n: UVec3) -> usize {
    n.x as usize * n.y as usize * n.z as usize
}

pub(super) fn index(p: UVec3, n: UVec3) -> usize {
    (p.z as usize * n.y as usize + p.y as usize) * n.x as usize + p.x as usize
}

pub(super) fn place_of(i: usize, n: UVec3) -> UVec3 {
    let i = i as u32;
    uvec3(i % n.x, i / n.x % n.y, i / n.x / n.y)
}

/// Returns the corners of a cell, x fastest.
pub(super) fn corners(place: UVec3) -> [UVec3; 8] {
    std::array::from_fn(|c| place + uvec3(c as u32 & 1, c as u32 >> 1 & 1, c as u32 >> 2))
}
