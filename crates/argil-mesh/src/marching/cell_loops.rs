//! The loops of the surface through cells, for dual contouring.

use glam::IVec3;
use std::collections::HashMap;

/// The loops of the surface through cells.
#[derive(Clone, Debug, Default)]
pub struct CellLoops {
    /// The cell of each loop, in voxels from the grid's corner.
    pub cells: Vec<IVec3>,
    /// The range of each loop's vertices in `vertices`.
    pub bounds: Vec<[u32; 2]>,
    /// The vertices of all loops.
    pub vertices: Vec<u32>,
    /// For each vertex, the loops through its edge: bit 0 of the index is set for the cell before it along the
    /// first of the other axes, and bit 1 along the second. `u32::MAX` where there is none.
    pub loops_around_edge: Vec<[u32; 4]>,
}

/// The loops of one brick: the cell, and the vertices with their indices in [`CellLoops::around`].
pub(super) type Ring = (IVec3, Vec<(u32, u8)>);

/// Joins the loops of all bricks.
pub(super) fn gathered(found: Vec<Vec<Ring>>, vertices: usize) -> CellLoops {
    let mut rings = CellLoops {
        loops_around_edge: vec![[u32::MAX; 4]; vertices],
        ..CellLoops::default()
    };
    for (cell, edges) in found.into_iter().flatten() {
        let cell_index = rings.cells.len() as u32;
        rings.cells.push(cell);
        let begin = rings.vertices.len() as u32;
        rings.bounds.push([begin, begin + edges.len() as u32]);
        for (vertex, place) in edges {
            rings.vertices.push(vertex);
            rings.loops_around_edge[vertex as usize][usize::from(place)] = cell_index;
        }
    }
    rings.part();
    rings
}

impl CellLoops {
    /// Returns a loop's vertices, in order.
    pub fn of(&self, ring: usize) -> &[u32] {
        let [begin, end] = self.bounds[ring];
        &self.vertices[begin as usize..end as usize]
    }

    /// Splits loops that share two segments of a face. Otherwise their dual vertices would have four triangles on
    /// one edge. On that face, the segments are joined the other way, which makes two loops of each (Wenger,
    /// "Isosurfaces", 2013).
    fn part(&mut self) {
        // Both segments, and at least two more vertices.
        const SHORTEST: usize = 6;
        let mut owner: HashMap<(u32, u32), usize> = HashMap::new();
        let long: Vec<usize> = (0..self.cells.len())
            .filter(|&ring| self.of(ring).len() >= SHORTEST)
            .collect();
        for &ring in &long {
            let vertices = self.of(ring);
            for (i, &from) in vertices.iter().enumerate() {
                owner.insert((from, vertices[(i + 1) % vertices.len()]), ring);
            }
        }
        for &ring in &long {
            let Some((other, ours, theirs)) = self.twice_beside(ring, &owner) else {
                continue;
            };
            self.split(ring, ours);
            self.split(other, theirs);
        }
    }

    /// Returns the loop that shares two segments with another, and where those begin in both.
    fn twice_beside(
        &self,
        ring: usize,
        owner: &HashMap<(u32, u32), usize>,
    ) -> Option<(usize, [usize; 2], [usize; 2])> {
        let ours = self.of(ring);
        let mut seen: Vec<(usize, usize)> = Vec::new();
        for i in 0..ours.len() {
            let (from, to) = (ours[i], ours[(i + 1) % ours.len()]);
            let Some(&other) = owner.get(&(to, from)) else {
                continue;
            };
            let Some(&(_, first)) = seen.iter().find(|(known, _)| *known == other) else {
                seen.push((other, i));
                continue;
            };
            // Either may have been split since it was recorded.
            let theirs = self.of(other);
            let at = |k: usize| theirs.iter().position(|&v| v == ours[(k + 1) % ours.len()]);
            let (mut a, mut b) = (at(first)?, at(i)?);
            let goes_on = |a: usize, k: usize| theirs[(a + 1) % theirs.len()] == ours[k];
            if !goes_on(a, first) || !goes_on(b, i) {
                continue;
            }
            if a > b {
                std::mem::swap(&mut a, &mut b);
            }
            return Some((other, [first, i], [a, b]));
        }
        None
    }

    /// Splits a loop after two of its positions: what is between them becomes a loop of its own.
    fn split(&mut self, ring: usize, [first, second]: [usize; 2]) {
        let [begin, end] = self.bounds[ring].map(|i| i as usize);
        let vertices = &mut self.vertices[begin..end];
        // What is between comes last.
        vertices.rotate_left(second + 1);
        let between = second - first;
        let cut = end - between;
        self.bounds[ring] = [begin as u32, cut as u32];
        let new = self.cells.len() as u32;
        self.cells.push(self.cells[ring]);
        self.bounds.push([cut as u32, end as u32]);
        for &vertex in &self.vertices[cut..end] {
            for slot in &mut self.loops_around_edge[vertex as usize] {
                if *slot == ring as u32 {
                    *slot = new;
                }
            }
        }
    }
}
