//! Marching cubes over a dense grid.
//!
//! *Practice.* After flying edges (Schroeder, Maynard, Geveci 2015), with bits instead of its edge codes. A row of
//! samples becomes a row of bits, inside or not. All further steps (which edges are crossed, which cells are
//! active, how many vertices come before one) run on 64 cells at a time. Rows are counted first, and then each
//! layer writes its own part of the mesh, so the order of vertices and triangles does not depend on threads.

use super::case_table::{MarchingCase, cases};
use crate::Mesh;
use argil_field::Grid;
use argil_math::bits_of;
use glam::{UVec3, Vec3, uvec3};
use rayon::prelude::*;

/// A stored sample.
pub trait Sample: Copy + Sync {
    /// Returns its value, in the unit of the iso level.
    fn value(self) -> f32;
}

impl Sample for f32 {
    #[inline]
    fn value(self) -> f32 {
        self
    }
}

impl Sample for i16 {
    #[inline]
    fn value(self) -> f32 {
        f32::from(self)
    }
}

impl Sample for i8 {
    #[inline]
    fn value(self) -> f32 {
        f32::from(self)
    }
}

/// Extracts the surface where samples at a grid's points, x fastest, have the value `iso`. Smaller values are
/// inside, and NaN is outside. With normals, vertices get the gradient of the samples by central differences.
///
/// # Panics
/// If there are not as many samples as points.
pub fn march<T: Sample>(samples: &[T], grid: &Grid, iso: f32, normals: bool) -> Mesh {
    let n = grid.size.as_usizevec3();
    assert_eq!(samples.len(), n.x * n.y * n.z, "a sample for each point");
    if n.min_element() < 2 {
        return Mesh::default();
    }
    let field = GridField::new(samples, grid, iso);
    let rows: Vec<SampleRow> = (0..n.z)
        .into_par_iter()
        .flat_map_iter(|z| (0..n.y).map(move |y| (y, z)))
        .map(|(y, z)| field.count(y, z))
        .collect();
    let (rows, total) = scan(rows);

    let mut mesh = Mesh {
        positions: vec![Vec3::ZERO; total.vertices() as usize],
        normals: vec![
            Vec3::ZERO;
            if normals {
                total.vertices() as usize
            } else {
                0
            }
        ],
        materials: Vec::new(),
        triangles: vec![[0; 3]; total.triangles as usize],
    };
    // Each layer's own part.
    let mut jobs = Vec::with_capacity(n.z);
    let (mut positions, mut normals, mut triangles) = (
        &mut mesh.positions[..],
        &mut mesh.normals[..],
        &mut mesh.triangles[..],
    );
    for z in 0..n.z {
        let begin = &rows[z * n.y];
        let end = rows.get((z + 1) * n.y).unwrap_or(&total);
        let vertices = (end.first[0] - begin.first[0]) as usize;
        let own_positions = positions.split_at_mut(vertices);
        let own_normals = normals.split_at_mut(vertices.min(normals.len()));
        let own_triangles = triangles.split_at_mut((end.triangles - begin.triangles) as usize);
        (positions, normals, triangles) = (own_positions.1, own_normals.1, own_triangles.1);
        if vertices > 0 {
            jobs.push((z, own_positions.0, own_normals.0, own_triangles.0));
        }
    }
    jobs.into_par_iter()
        .for_each(|(z, positions, normals, triangles)| {
            let (mut vertex, mut triangle) = (0, 0);
            for y in 0..n.y {
                field.vertices(y, z, |place, position| {
                    positions[vertex] = position;
                    if let Some(normal) = normals.get_mut(vertex) {
                        *normal = field.normal(place, position);
                    }
                    vertex += 1;
                });
                field.triangles(&rows, y, z, |indices| {
                    triangles[triangle] = indices;
                    triangle += 1;
                });
            }
        });
    mesh
}

/// The vertices on a row's edges along x, y and z, and the triangles in its cells; after the scan, where they
/// begin.
#[derive(Clone, Copy, Debug, Default)]
struct SampleRow {
    first: [u32; 3],
    triangles: u32,
}

impl SampleRow {
    /// Returns the number of all vertices, for the total.
    fn vertices(&self) -> u32 {
        self.first[0]
    }
}

/// Converts counts to offsets, and returns the total.
fn scan(mut rows: Vec<SampleRow>) -> (Vec<SampleRow>, SampleRow) {
    let mut total = SampleRow::default();
    for row in &mut rows {
        let counts = *row;
        row.triangles = total.triangles;
        total.triangles += counts.triangles;
        let mut begin = total.first[0];
        for (first, count) in row.first.iter_mut().zip(counts.first) {
            *first = begin;
            begin += count;
        }
        total.first[0] = begin;
    }
    (rows, total)
}

/// Samples with their bits.
struct GridField<'a, T> {
    samples: &'a [T],
    grid: Grid,
    iso: f32,
    /// Words per row.
    width: usize,
    /// Bit i of a row tells whether sample i is inside.
    bits: Vec<u64>,
}

/// Words of a row: which samples are inside, and which of the samples after them.
type Pair = [u64; 2];

impl<'a, T: Sample> GridField<'a, T> {
    fn new(samples: &'a [T], grid: &Grid, iso: f32) -> Self {
        let n = grid.size.as_usizevec3();
        let width = n.x.div_ceil(64);
        let mut bits = vec![0; width * n.y * n.z];
        bits.par_chunks_mut(width * n.y)
            .zip(samples.par_chunks(n.x * n.y))
            .for_each(|(bits, layer)| {
                for (bits, row) in bits.chunks_exact_mut(width).zip(layer.chunks_exact(n.x)) {
                    for (word, part) in bits.iter_mut().zip(row.chunks(64)) {
                        *word = inside(part, iso);
                    }
                }
            });
        Self {
            samples,
            grid: *grid,
            iso,
            width,
            bits,
        }
    }

    fn size(&self) -> UVec3 {
        self.grid.size
    }

    /// Returns the words of a row.
    fn row(&self, y: usize, z: usize) -> &[u64] {
        let begin = (z * self.size().y as usize + y) * self.width;
        &self.bits[begin..begin + self.width]
    }

    /// Returns the bits of cells along x in a word.
    fn cells(&self, word: usize) -> u64 {
        let cells = self.size().x as usize - 1;
        let left = cells.saturating_sub(64 * word);
        if left >= 64 {
            u64::MAX
        } else {
            (1 << left) - 1
        }
    }

    fn pair(row: &[u64], word: usize) -> Pair {
        let current = row[word];
        let next = row.get(word + 1).copied().unwrap_or(0);
        [current, current >> 1 | next << 63]
    }

    /// Returns the rows of cells and edges that begin at a row of points: (y, z), (y + 1, z), (y, z + 1), (y + 1, z
    /// + 1). Beyond the grid, the last row repeats, so that nothing is crossed on the way there.
    fn four(&self, y: usize, z: usize) -> [&[u64]; 4] {
        let n = self.size().as_usizevec3();
        let (up, on) = ((y + 1).min(n.y - 1), (z + 1).min(n.z - 1));
        [
            self.row(y, z),
            self.row(up, z),
            self.row(y, on),
            self.row(up, on),
        ]
    }

    /// Whether there are cells from this row on.
    fn has_cells(&self, y: usize, z: usize) -> bool {
        y + 1 < self.size().y as usize && z + 1 < self.size().z as usize
    }

    /// Whether all points of four rows are on one side.
    fn is_uniform(&self, rows: [&[u64]; 4]) -> bool {
        let is_in = rows[0][0] != 0;
        (0..self.width).all(|word| {
            let points = self.cells(word) << 1 | 1;
            let all = if !is_in {
                0
            } else if word + 1 == self.width {
                points
            } else {
                u64::MAX
            };
            rows.iter().all(|row| row[word] == all)
        })
    }

    fn count(&self, y: usize, z: usize) -> SampleRow {
        let rows = self.four(y, z);
        let mut count = SampleRow::default();
        if self.is_uniform(rows) {
            return count;
        }
        for word in 0..self.width {
            let pairs = rows.map(|row| Self::pair(row, word));
            let cells = self.cells(word);
            let [x, y_edges, z_edges] = crossed(pairs, cells);
            count.first[0] += x.count_ones();
            count.first[1] += y_edges.count_ones();
            count.first[2] += z_edges.count_ones();
            if self.has_cells(y, z) {
                let mut active = active(pairs, cells);
                while active != 0 {
                    let case = case_of(pairs, active.trailing_zeros());
                    count.triangles += u32::from(case.count);
                    active &= active - 1;
                }
            }
        }
        count
    }

    /// Calls `emit` with the vertices on the edges from a row's points: first along x, then y, then z, with the
    /// edge's first point.
    fn vertices(&self, y: usize, z: usize, mut emit: impl FnMut((UVec3, usize), Vec3)) {
        let rows = self.four(y, z);
        if self.is_uniform(rows) {
            return;
        }
        for axis in 0..3 {
            for word in 0..self.width {
                let pairs = rows.map(|row| Self::pair(row, word));
                let mut edges = crossed(pairs, self.cells(word))[axis];
                while edges != 0 {
                    let x = 64 * word as u32 + edges.trailing_zeros();
                    edges &= edges - 1;
                    let place = uvec3(x, y as u32, z as u32);
                    emit((place, axis), self.position(place, axis));
                }
            }
        }
    }

    fn value(&self, place: UVec3) -> f32 {
        let n = self.size();
        let [x, y, z, nx, ny] = [place.x, place.y, place.z, n.x, n.y].map(|i| i as usize);
        self.samples[(z * ny + y) * nx + x].value()
    }

    fn position(&self, place: UVec3, axis: usize) -> Vec3 {
        let mut after = place;
        after[axis] += 1;
        let (a, b) = (self.value(place), self.value(after));
        let mut at = (self.grid.begin + place).as_vec3();
        at[axis] += edge_crossing(a, b, self.iso);
        self.grid.min + self.grid.spacing * at
    }

    /// Returns the gradient of the samples at a vertex, as a unit vector.
    fn normal(&self, (place, axis): (UVec3, usize), position: Vec3) -> Vec3 {
        let mut after = place;
        after[axis] += 1;
        let at = (position - self.grid.min) / self.grid.spacing - self.grid.begin.as_vec3();
        let t = at[axis] - place[axis] as f32;
        let gradient = self.gradient(place).lerp(self.gradient(after), t);
        gradient.normalize_or_zero()
    }

    fn gradient(&self, place: UVec3) -> Vec3 {
        let mut gradient = Vec3::ZERO;
        for axis in 0..3 {
            let (mut low, mut high) = (place, place);
            low[axis] = low[axis].saturating_sub(1);
            high[axis] = (high[axis] + 1).min(self.size()[axis] - 1);
            let way = (high[axis] - low[axis]) as f32 * self.grid.spacing[axis];
            gradient[axis] = (self.value(high) - self.value(low)) / way;
        }
        gradient
    }

    /// Calls `emit` with the triangles in the cells from a row's points.
    fn triangles(&self, rows: &[SampleRow], y: usize, z: usize, mut emit: impl FnMut([u32; 3])) {
        if !self.has_cells(y, z) {
            return;
        }
        let bits = self.four(y, z);
        if self.is_uniform(bits) {
            return;
        }
        let ny = self.size().y as usize;
        let first = |y: usize, z: usize, axis: usize| rows[z * ny + y].first[axis];
        // The next vertex of each row of edges around the cells: four along x, two along y, two along z.
        let mut next = [
            first(y, z, 0),
            first(y + 1, z, 0),
            first(y, z + 1, 0),
            first(y + 1, z + 1, 0),
            first(y, z, 1),
            first(y, z + 1, 1),
            first(y, z, 2),
            first(y + 1, z, 2),
        ];
        for word in 0..self.width {
            let pairs = bits.map(|row| Self::pair(row, word));
            let cells = self.cells(word);
            let [b00, b10, b01, b11] = pairs.map(|pair| pair[0]);
            // Edges crossed along each of those rows. Rows of points have one more bit than there are cells.
            let along = |pair: Pair| (pair[0] ^ pair[1]) & cells;
            let edges = [
                along(pairs[0]),
                along(pairs[1]),
                along(pairs[2]),
                along(pairs[3]),
                b00 ^ b10,
                b01 ^ b11,
                b00 ^ b01,
                b10 ^ b11,
            ];
            let mut active = active(pairs, cells);
            while active != 0 {
                let i = active.trailing_zeros();
                active &= active - 1;
                let below = (1u64 << i) - 1;
                let id = |row: usize| next[row] + (edges[row] & below).count_ones();
                let beside = |row: usize| id(row) + (edges[row] >> i & 1) as u32;
                let ids = [
                    id(0),
                    id(1),
                    id(2),
                    id(3),
                    id(4),
                    beside(4),
                    id(5),
                    beside(5),
                    id(6),
                    beside(6),
                    id(7),
                    beside(7),
                ];
                for triangle in case_of(pairs, i).triangles() {
                    emit(triangle.map(|edge| ids[usize::from(edge)]));
                }
            }
            for (next, edges) in next.iter_mut().zip(edges) {
                *next += edges.count_ones();
            }
        }
    }
}

/// Minimum distance of a vertex from a sample, as a fraction of its edge, so that vertices around a sample on the
/// surface stay apart, and every triangle has an area.
const NEAREST: f32 = argil_abi::MIN_EDGE_FRACTION;

/// Returns where between two samples the value is reached, from 0 to 1.
#[inline]
pub(crate) fn edge_crossing(a: f32, b: f32, iso: f32) -> f32 {
    let t = (iso - a) / (b - a);
    if t.is_nan() { 0.5 } else { clamp(t) }
}

#[inline]
pub(crate) fn clamp(t: f32) -> f32 {
    t.clamp(NEAREST, 1.0 - NEAREST)
}

/// Returns a bit for each of up to 64 samples.
fn inside<T: Sample>(part: &[T], iso: f32) -> u64 {
    let mut flags = [0; 64];
    for (flag, sample) in flags.iter_mut().zip(part) {
        *flag = u8::from(sample.value() < iso);
    }
    bits_of(&flags)
}

/// Returns the crossed edges along x, y and z that begin at the points of the first row.
fn crossed([b00, b10, b01, _]: [Pair; 4], cells: u64) -> [u64; 3] {
    [(b00[0] ^ b00[1]) & cells, b00[0] ^ b10[0], b00[0] ^ b01[0]]
}

/// Returns the cells whose corners are not all on one side.
fn active(pairs: [Pair; 4], cells: u64) -> u64 {
    let any = pairs.iter().fold(0, |bits, pair| bits | pair[0] | pair[1]);
    let all = pairs
        .iter()
        .fold(u64::MAX, |bits, pair| bits & pair[0] & pair[1]);
    any & !all & cells
}

fn case_of(pairs: [Pair; 4], i: u32) -> &'static MarchingCase {
    let mut case = 0;
    for (k, pair) in pairs.iter().enumerate() {
        case |= (pair[0] >> i & 1) << (2 * k) | (pair[1] >> i & 1) << (2 * k + 1);
    }
    &cases()[case as usize]
}
