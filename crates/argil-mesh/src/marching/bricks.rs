//! Marching cubes over sparse bricks.
//!
//! *Practice.* A vertex belongs to the brick at the low end of its edge. An edge at a brick's high side belongs to
//! its neighbor, if there is one. Bricks are counted first, and then each writes its own vertices and triangles. A
//! neighbor's vertices are found by counting the bits before them. Cells without a brick contain no surface, and
//! are skipped.

use super::case_table::{case_loops, cases};
pub use super::cell_loops::CellLoops;
use super::cell_loops::Ring;
use super::dense::edge_crossing;
use crate::Mesh;
use crate::marching::cell_loops::gathered;
use crate::marching::signs::signs;
use argil_volume::{BrickCell, Bricks, SampleFormat, Texel};
use glam::{IVec3, Vec3, ivec3};
use rayon::prelude::*;

/// The vertices of a brick: `begin` to `ends[0]` lie on edges along x, from there to `ends[1]` along y, and to
/// `ends[2]` along z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BrickVertexRange {
    /// The brick's cell.
    pub cell: IVec3,
    /// The first vertex.
    pub begin: u32,
    /// The end of each axis.
    pub ends: [u32; 3],
}

/// A surface, and where its vertices come from.
#[derive(Clone, Debug, Default)]
pub struct MarchedMesh {
    /// The surface, without normals.
    pub mesh: Mesh,
    /// The vertices of each brick.
    pub groups: Vec<BrickVertexRange>,
    /// The stored distances at the start and the end of each vertex's edge.
    pub edge_distances: Vec<[f32; 2]>,
}

/// Extracts the surface of bricks.
pub fn march(bricks: &Bricks) -> MarchedMesh {
    march_with(bricks, false).0
}

/// Extracts the surface, and its loops for dual contouring.
pub fn march_with_loops(bricks: &Bricks) -> (MarchedMesh, CellLoops) {
    march_with(bricks, true)
}

fn march_with(bricks: &Bricks, with_rings: bool) -> (MarchedMesh, CellLoops) {
    if bricks.is_empty() {
        return <(MarchedMesh, CellLoops)>::default();
    }
    match bricks.layout().encoding().format {
        SampleFormat::Snorm8 => march_of::<i8>(bricks, with_rings),
        SampleFormat::Snorm16 => march_of::<i16>(bricks, with_rings),
    }
}

fn march_of<T: Texel>(bricks: &Bricks, with_rings: bool) -> (MarchedMesh, CellLoops) {
    let Some(pool) = bricks.pool().of::<T>() else {
        return <(MarchedMesh, CellLoops)>::default();
    };
    let mut all = All::<T>::new(bricks, pool);
    let (mut vertices, mut triangles) = (0u32, 0u32);
    let mut groups = Vec::with_capacity(all.vertices.len());
    for ranges in &mut all.vertices {
        let counts = ranges.counts;
        ranges.begin = [vertices, triangles];
        let [x, y, z, own_triangles] = counts;
        groups.push(BrickVertexRange {
            cell: ranges.cell,
            begin: vertices,
            ends: [vertices + x, vertices + x + y, vertices + x + y + z],
        });
        vertices += x + y + z;
        triangles += own_triangles;
    }

    let mut mesh = Mesh {
        positions: vec![Vec3::ZERO; vertices as usize],
        triangles: vec![[0; 3]; triangles as usize],
        ..Mesh::default()
    };
    let mut spans = vec![[0.0; 2]; vertices as usize];
    let (mut positions, mut left) = (&mut mesh.positions[..], &mut spans[..]);
    let mut triangles = &mut mesh.triangles[..];
    let mut jobs = Vec::with_capacity(all.vertices.len());
    for (brick, ranges) in all.vertices.iter().enumerate() {
        let [x, y, z, count] = ranges.counts;
        let count_own = (x + y + z) as usize;
        let (own_positions, rest) = positions.split_at_mut(count_own);
        positions = rest;
        let (own_spans, rest) = left.split_at_mut(count_own);
        left = rest;
        let (own_triangles, rest) = triangles.split_at_mut(count as usize);
        triangles = rest;
        jobs.push((brick, own_positions, own_spans, own_triangles));
    }
    let found: Vec<Vec<Ring>> = jobs
        .into_par_iter()
        .with_min_len(16)
        .map_init(
            || vec![0u32; 3 * all.rows * all.points],
            |ids, (brick, positions, spans, triangles)| {
                let mut rings = Vec::new();
                if !triangles.is_empty() {
                    all.vertices(brick, ids, positions, spans);
                    all.triangles(brick, ids, triangles);
                    if with_rings {
                        all.rings(brick, ids, &mut rings);
                    }
                }
                rings
            },
        )
        .collect();
    let marched = MarchedMesh {
        mesh,
        groups,
        edge_distances: spans,
    };
    let rings = if with_rings {
        gathered(found, marched.mesh.positions.len())
    } else {
        CellLoops::default()
    };
    (marched, rings)
}

/// A brick's vertices and triangles.
#[derive(Clone, Copy)]
struct BrickVertices {
    cell: IVec3,
    /// Neighboring bricks: index bit 0 toward x, bit 1 toward y, bit 2 toward z. The brick itself where there is
    /// none.
    beside: [u32; 8],
    /// Whether an edge at those high sides belongs to the brick.
    has: [bool; 8],
    /// Vertices on edges along x, y and z, and triangles.
    counts: [u32; 4],
    /// The first vertex and the first triangle.
    begin: [u32; 2],
}

impl BrickVertices {
    fn new(brick: usize, cell: IVec3, beside: [u32; 8]) -> Self {
        let mut vertices = Self {
            cell,
            beside,
            has: [false; 8],
            counts: [0; 4],
            begin: [0; 2],
        };
        vertices.has = std::array::from_fn(|sides| vertices.owner(brick, sides).0 == brick);
        vertices
    }

    /// Returns the owner of an edge at some of a brick's high sides, and the high sides at which the owner has it.
    fn owner(&self, brick: usize, sides: usize) -> (usize, usize) {
        // For two sides: both, the higher axis, the lower axis.
        let high = if sides == 0 { 0 } else { 1 << sides.ilog2() };
        for d in [sides, high, sides & !high] {
            let other = self.beside[d] as usize;
            if other != brick {
                return (other, sides & !d);
            }
        }
        (brick, sides)
    }
}

struct All<'a, T> {
    bricks: &'a Bricks,
    pool: &'a [T],
    /// Voxels along a brick's side, and samples.
    side: usize,
    points: usize,
    /// Rows of samples in a brick.
    rows: usize,
    vertices: Vec<BrickVertices>,
    /// For each row of each brick, which samples are inside.
    bits: Vec<u32>,
    /// The number of a brick's vertices before each row, for edges along x, y and z.
    before: Vec<u16>,
}

impl<'a, T: Texel> All<'a, T> {
    fn new(bricks: &'a Bricks, pool: &'a [T]) -> Self {
        let layout = bricks.layout();
        let side = layout.brick_size_voxels() as usize;
        let points = side + 1;
        let rows = points * points;
        let vertices: Vec<BrickVertices> = bricks
            .cell_of_brick()
            .par_iter()
            .enumerate()
            .with_min_len(64)
            .map(|(brick, &owner)| {
                let cell = bricks.cell_at(owner as usize);
                let beside = std::array::from_fn(|d| {
                    let d = d as i32;
                    let other = cell + ivec3(d & 1, d >> 1 & 1, d >> 2);
                    match bricks.cell(other) {
                        BrickCell::Brick(other) => other,
                        _ => brick as u32,
                    }
                });
                BrickVertices::new(brick, cell, beside)
            })
            .collect();
        let mut all = Self {
            bricks,
            pool,
            side,
            points,
            rows,
            bits: vec![0; rows * vertices.len()],
            before: vec![0; 3 * rows * vertices.len()],
            vertices,
        };
        let samples = rows * points;
        all.bits
            .par_chunks_exact_mut(rows)
            .zip(pool.par_chunks_exact(samples))
            .with_min_len(16)
            .for_each_init(
                || vec![0u64; samples.div_ceil(64) + 1],
                |stream, (bits, samples)| {
                    signs(samples, stream);
                    for (row, bits) in bits.iter_mut().enumerate() {
                        let (word, shift) = (row * points / 64, row * points % 64);
                        let both = u128::from(stream[word]) | u128::from(stream[word + 1]) << 64;
                        *bits = (both >> shift) as u32 & ((1 << points) - 1);
                    }
                },
            );
        let mut before = std::mem::take(&mut all.before);
        let counts: Vec<[u32; 4]> = before
            .par_chunks_exact_mut(3 * rows)
            .enumerate()
            .with_min_len(16)
            .map(|(brick, before)| all.count(brick, before))
            .collect();
        all.before = before;
        for (brick, counts) in all.vertices.iter_mut().zip(counts) {
            brick.counts = counts;
        }
        all
    }

    fn bits(&self, brick: usize) -> &[u32] {
        &self.bits[brick * self.rows..(brick + 1) * self.rows]
    }

    /// Returns the crossed edges along an axis that begin in a row, one bit each.
    fn crossed(&self, bits: &[u32], axis: usize, row: usize) -> u32 {
        match axis {
            0 => (bits[row] ^ bits[row] >> 1) & ((1 << self.side) - 1),
            1 if row % self.points < self.side => bits[row] ^ bits[row + 1],
            2 if row / self.points < self.side => bits[row] ^ bits[row + self.points],
            _ => 0,
        }
    }

    /// Returns the high sides, except its own axis's, at which the edges of a row lie, without x.
    fn sides(&self, axis: usize, row: usize) -> usize {
        let y = usize::from(axis != 1 && row % self.points == self.side) << 1;
        let z = usize::from(axis != 2 && row / self.points == self.side) << 2;
        y | z
    }

    /// Returns the crossed edges that belong to the brick.
    fn owned(&self, brick: &BrickVertices, axis: usize, row: usize, crossed: u32) -> u32 {
        let mut edges = crossed;
        let sides = self.sides(axis, row);
        if !brick.has[sides] {
            edges &= 1 << self.side;
        }
        if axis != 0 && !brick.has[sides | 1] {
            edges &= !(1 << self.side);
        }
        edges
    }

    fn count(&self, brick: usize, before: &mut [u16]) -> [u32; 4] {
        let bits = self.bits(brick);
        let mut counts = [0; 4];
        let mut all = 0u32;
        for axis in 0..3 {
            for row in 0..self.rows {
                before[axis * self.rows + row] = all as u16;
                let crossed = self.crossed(bits, axis, row);
                if crossed != 0 {
                    let crossings = self
                        .owned(&self.vertices[brick], axis, row, crossed)
                        .count_ones();
                    counts[axis] += crossings;
                    all += crossings;
                }
            }
        }
        self.cells(bits, |_, case| {
            counts[3] += u32::from(cases()[case].count);
        });
        counts
    }

    /// Calls `emit` with each active cell's position and case.
    fn cells(&self, bits: &[u32], mut emit: impl FnMut([usize; 3], usize)) {
        for z in 0..self.side {
            for y in 0..self.side {
                let row = z * self.points + y;
                let rows = [row, row + 1, row + self.points, row + self.points + 1];
                let rows = rows.map(|row| bits[row]);
                let any = rows.iter().fold(0, |a, b| a | b);
                let every = rows.iter().fold(u32::MAX, |a, b| a & b);
                let cells = (1 << self.side) - 1;
                let mut active = (any | any >> 1) & !(every & every >> 1) & cells;
                while active != 0 {
                    let x = active.trailing_zeros();
                    active &= active - 1;
                    let mut case = 0;
                    for (k, row) in rows.iter().enumerate() {
                        case |= (row >> x & 3) << (2 * k);
                    }
                    emit([x as usize, y, z], case as usize);
                }
            }
        }
    }

    /// Writes a brick's own vertices, and the vertex of each crossed edge: `ids` has room for an edge along each
    /// axis from each sample.
    fn vertices(
        &self,
        brick: usize,
        ids: &mut [u32],
        positions: &mut [Vec3],
        spans: &mut [[f32; 2]],
    ) {
        let bits = self.bits(brick);
        let layout = self.bricks.layout();
        let voxel_grid = &layout.voxel_grid();
        let unit = layout.encoding().band_width(voxel_grid, 0)
            / layout.encoding().format.max_code() as f32;
        let length = self.rows * self.points;
        let samples = &self.pool[brick * length..][..length];
        let ranges = &self.vertices[brick];
        let first = (ranges.cell * self.side as i32).as_vec3();
        let mut next = 0;
        for axis in 0..3 {
            let step = [1, self.points, self.rows][axis];
            for row in 0..self.rows {
                let mut edges = self.crossed(bits, axis, row);
                if edges == 0 {
                    continue;
                }
                let owned = self.owned(ranges, axis, row, edges);
                let [y, z] = [row % self.points, row / self.points];
                while edges != 0 {
                    let x = edges.trailing_zeros() as usize;
                    edges &= edges - 1;
                    let at = row * self.points + x;
                    let id = &mut ids[axis * length + at];
                    if owned >> x & 1 == 0 {
                        let at_end = usize::from(axis != 0 && x == self.side);
                        let sides = self.sides(axis, row) | at_end;
                        *id = self.id(brick, axis, row, x, sides);
                        continue;
                    }
                    let (a, b) = (samples[at].code(), samples[at + step].code());
                    let mut place = Vec3::new(x as f32, y as f32, z as f32);
                    place[axis] += edge_crossing(a, b, 0.0);
                    positions[next] = voxel_grid.corner + voxel_grid.voxel_size * (first + place);
                    spans[next] = [a * unit, b * unit];
                    *id = ranges.begin[0] + next as u32;
                    next += 1;
                }
            }
        }
    }

    /// Returns the offsets from a cell's first sample to the edges around it.
    fn edge_places(&self) -> [usize; 12] {
        std::array::from_fn(|edge| {
            let (axis, low, high) = (edge / 4, edge & 1, edge >> 1 & 1);
            let [x, y, z] = match axis {
                0 => [0, low, high],
                1 => [low, 0, high],
                _ => [low, high, 0],
            };
            ((axis * self.points + z) * self.points + y) * self.points + x
        })
    }

    /// Writes a brick's loops, as vertices on its edges.
    fn rings(&self, brick: usize, ids: &[u32], out: &mut Vec<Ring>) {
        let places = self.edge_places();
        let first = self.vertices[brick].cell * self.side as i32;
        self.cells(self.bits(brick), |[x, y, z], case| {
            let from = (z * self.points + y) * self.points + x;
            for ring in &case_loops()[case] {
                let edges = ring
                    .iter()
                    .map(|&edge| (ids[from + places[usize::from(edge)]], edge % 4));
                let cell = first + ivec3(x as i32, y as i32, z as i32);
                out.push((cell, edges.collect()));
            }
        });
    }

    /// Writes a brick's triangles, as vertices on its edges.
    fn triangles(&self, brick: usize, ids: &[u32], out: &mut [[u32; 3]]) {
        let places = self.edge_places();
        let mut out = out.iter_mut();
        self.cells(self.bits(brick), |[x, y, z], case| {
            let from = (z * self.points + y) * self.points + x;
            for triangle in cases()[case].triangles() {
                if let Some(out) = out.next() {
                    *out = triangle.map(|edge| ids[from + places[usize::from(edge)]]);
                }
            }
        });
    }

    /// Returns the vertex of a crossed edge at some high sides.
    fn id(&self, brick: usize, axis: usize, row: usize, x: usize, sides: usize) -> u32 {
        let (owner, left) = self.vertices[brick].owner(brick, sides);
        // What was at a high side is at the owner's low side.
        let gone = sides & !left;
        let x = if gone & 1 != 0 { 0 } else { x };
        let y = if gone & 2 != 0 { 0 } else { row % self.points };
        let z = if gone & 4 != 0 { 0 } else { row / self.points };
        let row = z * self.points + y;
        let crossed = self.crossed(self.bits(owner), axis, row);
        let edges = self.owned(&self.vertices[owner], axis, row, crossed);
        let before = self.before[(owner * 3 + axis) * self.rows + row];
        let below = (edges & ((1 << x) - 1)).count_ones();
        self.vertices[owner].begin[0] + u32::from(before) + below
    }
}
