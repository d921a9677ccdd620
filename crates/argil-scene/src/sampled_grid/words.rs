//! Distances in nested levels as the words that interpreters read.
//!
//! ```text
//! a head for each level │ summary │ samples of cells │ for each level: a word for each cell, samples at corners
//!  corner, 1/cell,      │ counts, │ of kind 1, 2, 3  │  kind + 4 · index among the cells of that kind
//!  cells, levels        │ solid   │                  │
//! ```

use super::nest::{MAX_KIND, Nest, corners, index, place_of, volume};
use super::{MAX_LIPSCHITZ, MAX_SAMPLED_LEVELS, SAMPLED_HEADER, SAMPLED_SUMMARY, SampledGrid};
use crate::MAX_LENGTH;
use argil_math::Aabb;
use glam::{UVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Kinds of cells, in two bits of a word.
const KINDS: usize = 4;

/// Words hold whole numbers below this exactly.
const EXACT: usize = 1 << 24;

const _: () = assert!(MAX_KIND as usize + 1 == KINDS);

/// Where a grid's levels and samples lie in its words.
struct Layout {
    levels: Vec<LayoutLevel>,
    /// The first sample of each kind, and the end.
    samples: [usize; KINDS + 1],
    length: usize,
}

struct LayoutLevel {
    corner: Vec3,
    cell: f32,
    cells: UVec3,
    /// Words of cells, and samples at corners.
    table: Range<usize>,
    coarse: Range<usize>,
}

impl Layout {
    /// Reads heads and summary. Returns `None` if they are not valid.
    fn new(words: &[f32]) -> Option<Self> {
        let whole = |word: f32, max: usize| {
            let is_whole = (0.0..=max as f32).contains(&word) && word.fract() == 0.0;
            is_whole.then_some(word as usize)
        };
        let count = whole(*words.get(SAMPLED_HEADER - 1)?, MAX_SAMPLED_LEVELS)?;
        let summary = words
            .get(SAMPLED_HEADER * count..)?
            .get(..SAMPLED_SUMMARY)?;
        let mut end = SAMPLED_HEADER * count + SAMPLED_SUMMARY;
        let mut samples = [end; KINDS + 1];
        for kind in 1..KINDS {
            samples[kind] = end;
            end += whole(summary[kind - 1], EXACT / KINDS)? * samples_of(kind);
        }
        samples[KINDS] = end;
        let mut levels = Vec::with_capacity(count);
        for head in words[..SAMPLED_HEADER * count].chunks(SAMPLED_HEADER) {
            let mut cells = UVec3::ZERO;
            for axis in 0..3 {
                cells[axis] = whole(head[4 + axis], 512)? as u32;
            }
            let table = end..end + volume(cells);
            let coarse = table.end..table.end + volume(cells + 1);
            end = coarse.end;
            levels.push(LayoutLevel {
                corner: Vec3::from_slice(head),
                cell: 1.0 / head[3],
                cells,
                table,
                coarse,
            });
        }
        let is_valid = |level: &LayoutLevel| level.cells.min_element() > 0 && level.cell > 0.0;
        (count > 0 && levels.iter().all(is_valid)).then_some(Self {
            levels,
            samples,
            length: end,
        })
    }
}

/// Returns the number of samples of a cell.
const fn samples_of(kind: usize) -> usize {
    ((1 << kind) + 1usize).pow(3)
}

impl SampledGrid {
    pub(super) fn of_nest(nest: &Nest, solid: Aabb) -> Self {
        let mut words = Vec::new();
        for level in &nest.levels {
            words.extend(nest.position(level.first).to_array());
            words.push(1.0 / (nest.unit * level.width as f32));
            words.extend(level.count.as_vec3().to_array());
            words.push(0.0);
        }
        words[SAMPLED_HEADER - 1] = nest.levels.len() as f32;
        let summary = words.len();
        words.resize(summary + SAMPLED_SUMMARY, 0.0);
        words[summary + KINDS..][..3].copy_from_slice(&solid.min.to_array());
        words[summary + KINDS + 3..][..3].copy_from_slice(&solid.max.to_array());
        for kind in 1..KINDS {
            let mut count = 0usize;
            for level in &nest.levels {
                for cell in level
                    .cells
                    .iter()
                    .filter(|cell| usize::from(cell.kind) == kind)
                {
                    words.extend_from_slice(&cell.samples);
                    count += 1;
                }
            }
            words[summary + kind - 1] = count as f32;
        }
        let mut counts = [0usize; KINDS];
        for level in &nest.levels {
            words.extend(level.cells.iter().map(|cell| {
                let kind = usize::from(cell.kind);
                counts[kind] += 1;
                if kind == 0 {
                    0.0
                } else {
                    (kind + KINDS * (counts[kind] - 1)) as f32
                }
            }));
            words.extend_from_slice(&level.coarse);
        }
        let first = &nest.levels[0];
        let cell = nest.unit * first.width as f32;
        // Its length was not known, and a grid lives long.
        words.shrink_to_fit();
        Self::with(words, nest.corner, cell, first.count, solid)
    }

    fn with(words: Vec<f32>, corner: Vec3, cell: f32, cells: UVec3, solid: Aabb) -> Self {
        let mut grid = Self {
            words,
            corner,
            cell,
            cells,
            solid,
            lipschitz: 1.0,
        };
        grid.lipschitz = grid.steepest().max(1.0);
        grid
    }

    /// Creates a grid from stored words. Returns `None` if they are not a valid grid.
    pub fn from_words(words: Vec<f32>, solid: Aabb) -> Option<Self> {
        let head = words.get(..SAMPLED_HEADER)?;
        if head[5] == 0.0 {
            let posts = [head[4], head[6]].map(|n| n as u32);
            let grid = Self::from_heights(posts, &words[SAMPLED_HEADER..])?;
            return (grid.words == words).then_some(grid);
        }
        let layout = Layout::new(&words)?;
        if words.len() != layout.length
            || !words.iter().all(|w| w.is_finite())
            || !solid.is_finite()
        {
            return None;
        }
        let mut counts = [0usize; KINDS];
        for word in layout
            .levels
            .iter()
            .flat_map(|level| &words[level.table.clone()])
        {
            if *word != 0.0 {
                let kind = *word as usize % KINDS;
                if kind == 0 || *word != (kind + KINDS * counts[kind]) as f32 {
                    return None;
                }
                counts[kind] += 1;
            }
        }
        let is_whole = |kind: usize| {
            let samples = layout.samples[kind + 1] - layout.samples[kind];
            samples == counts[kind] * samples_of(kind)
        };
        if !(1..KINDS).all(is_whole) {
            return None;
        }
        let summary = &words[SAMPLED_HEADER * layout.levels.len()..];
        let stored = [0, 3].map(|at| Vec3::from_slice(&summary[KINDS + at..]));
        let is_near = layout.levels.iter().all(|level| {
            let away = level.corner.abs() + level.cell * level.cells.as_vec3();
            away.max_element() <= 16.0 * MAX_LENGTH
        });
        let LayoutLevel {
            corner,
            cell,
            cells,
            ..
        } = layout.levels[0];
        let grid = Self::with(words, corner, cell, cells, solid);
        let region = grid.region().grown(1e-3 * cell);
        let is_inside = region.contains(solid.min) && region.contains(solid.max);
        let is_stored = stored == [solid.min, solid.max];
        (is_near && is_inside && is_stored && grid.lipschitz <= MAX_LIPSCHITZ).then_some(grid)
    }

    /// Whether any sample lies inside the solid.
    pub fn has_inside(&self) -> bool {
        self.layout().is_some_and(|layout| {
            let samples = &self.words[layout.samples[1]..layout.samples[KINDS]];
            let mut coarse = layout
                .levels
                .iter()
                .flat_map(|level| &self.words[level.coarse.clone()]);
            samples.iter().any(|&d| d < 0.0) || coarse.any(|&d| d < 0.0)
        })
    }

    /// Returns the number of cells with all samples.
    pub fn fine_cells(&self) -> usize {
        let kind = usize::from(MAX_KIND);
        self.layout().map_or(0, |layout| {
            (layout.samples[kind + 1] - layout.samples[kind]) / samples_of(kind)
        })
    }

    fn layout(&self) -> Option<Layout> {
        (!self.has_heights()).then(|| Layout::new(&self.words))?
    }

    /// Returns the largest gradient in any cell.
    fn steepest(&self) -> f32 {
        let Some(layout) = self.layout() else {
            return 0.0;
        };
        let of_level = |level: &LayoutLevel| {
            let coarse = &self.words[level.coarse.clone()];
            let table = &self.words[level.table.clone()];
            let in_cell = |(i, &word): (usize, &f32)| {
                let kind = word as usize % KINDS;
                if kind == 0 {
                    let place = place_of(i, level.cells);
                    let values = corners(place).map(|p| coarse[index(p, level.cells + 1)]);
                    return steepest(values) / level.cell;
                }
                let first = layout.samples[kind] + word as usize / KINDS * samples_of(kind);
                steepest_of(&self.words[first..][..samples_of(kind)], 1 << kind) / level.cell
            };
            let all = table.par_iter().enumerate().map(in_cell);
            all.reduce(|| 0.0, f32::max)
        };
        // Rounding of the samples themselves.
        layout.levels.iter().map(of_level).fold(0.0, f32::max) * 1.0001
    }
}

/// Returns the longest gradient in a cell of length 1, from samples at a number of intervals.
fn steepest_of(samples: &[f32], side: usize) -> f32 {
    let row = side + 1;
    let layer = row * row;
    let mut greatest = 0.0f32;
    for z in 0..side {
        for y in 0..side {
            for first in (z * layer + y * row..).take(side) {
                let edges =
                    [0, 1, row, row + 1].map(|i| [samples[first + i], samples[first + i + layer]]);
                let [a, b, c, d] = edges;
                greatest = greatest.max(steepest([a[0], b[0], c[0], d[0], a[1], b[1], c[1], d[1]]));
            }
        }
    }
    greatest * side as f32
}

/// Returns the longest gradient at a corner, for samples a unit apart.
fn steepest(v: [f32; 8]) -> f32 {
    let mut greatest = 0.0f32;
    for c in 0..8 {
        let along = |axis: usize| v[c | 1 << axis] - v[c & !(1 << axis)];
        let [x, y, z] = [along(0), along(1), along(2)];
        greatest = greatest.max(x * x + y * y + z * z);
    }
    greatest.sqrt()
}
