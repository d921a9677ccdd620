//! The sheets of the surface in voxels.

use super::edges::{AROUND, ActiveEdge, Voxel};
use argil_volume::Levels;
use rayon::prelude::*;

/// For each edge and each voxel around it, the sheet of the surface: a union-find structure.
pub(super) struct Sheets {
    parents: Vec<u32>,
    seams: Vec<Seam>,
}

/// An inside interval of a face's border, where the sheets of two voxels meet: both of its ends, each with a voxel's
/// place around the edge and the other voxel's.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Seam {
    /// The edges at both ends.
    pub edges: [u32; 2],
    /// The places of both voxels around each of the edges.
    pub places: [[u8; 2]; 2],
    /// The place of its face among all faces with several intervals.
    face: u32,
}

/// An edge on the face between two voxels.
#[derive(Clone, Copy)]
struct OnFace {
    voxels: [Voxel; 2],
    edge: u32,
    /// The places of the voxels among those around the edge.
    places: [u8; 2],
    /// The axis that the face is normal to.
    normal: u8,
}

impl Sheets {
    /// Joins the sheets of all voxels around edges.
    pub(super) fn new(levels: &Levels, edges: &[ActiveEdge]) -> Self {
        let mut sheets = Self {
            parents: (0..4 * edges.len() as u32).collect(),
            seams: Vec::new(),
        };
        // A larger voxel can be at two sides of an edge.
        for (index, edge) in edges.iter().enumerate() {
            for k in 0..4 {
                for other in k + 1..4 {
                    if edge.around[k] == edge.around[other] {
                        sheets.join(4 * index + k, 4 * index + other);
                    }
                }
            }
        }
        let mut all: Vec<OnFace> = (0u32..)
            .zip(edges)
            .flat_map(|(index, edge)| on_faces(index, edge))
            .collect();
        all.par_sort_unstable_by_key(|one| (one.voxels, one.edge));
        for (index, face) in (0..).zip(all.chunk_by(|a, b| a.voxels == b.voxels)) {
            sheets.join_face(levels, edges, face, index);
        }
        sheets
    }

    /// Returns the intervals whose two sheets meet in another interval, too. Two voxels share one face, so both
    /// intervals are on it.
    pub(super) fn double_seams(&mut self) -> Vec<Seam> {
        let seams = std::mem::take(&mut self.seams);
        let mut sheets = |seam: &Seam| {
            let of = |k| 4 * seam.edges[0] as usize + usize::from(seam.places[0][k]);
            [self.root(of(0)), self.root(of(1))]
        };
        let mut all = Vec::new();
        for face in seams.chunk_by(|a, b| a.face == b.face) {
            let pairs: Vec<[usize; 2]> = face.iter().map(&mut sheets).collect();
            let is_double =
                |pair: &[usize; 2]| pairs.iter().filter(|&other| other == pair).count() > 1;
            let double = face.iter().zip(&pairs).filter(|(_, pair)| is_double(pair));
            all.extend(double.map(|(&seam, _)| seam));
        }
        all
    }

    /// Joins the sign changes at the two ends of each inside interval of a face's border.
    fn join_face(&mut self, levels: &Levels, edges: &[ActiveEdge], face: &[OnFace], index: u32) {
        let normal = usize::from(face[0].normal);
        let (p, q) = ((normal + 1) % 3, (normal + 2) % 3);
        let of = |one: &OnFace| &edges[one.edge as usize];
        // The edges are on the border of the smaller voxel's side.
        let [one, other] = face[0].voxels;
        let smaller = if one.level() <= other.level() {
            one
        } else {
            other
        };
        let side = 1i64 << smaller.level();
        let corner = smaller.corner(levels);
        let corner = [p, q].map(|axis| i64::from(corner[axis]));
        let mut around: Vec<(i64, bool, OnFace)> = face
            .iter()
            .map(|one| {
                let edge = of(one);
                let at = [p, q].map(|axis| i64::from(edge.begin[axis]));
                let (s, t) = (at[0] - corner[0], at[1] - corner[1]);
                let length = i64::from(edge.length());
                let (place, is_forward) = match (edge.axis == p, edge.axis == p && t == 0, s == 0) {
                    (true, true, _) => (s, true),
                    (true, false, _) => (2 * side + (side - s - length), false),
                    (false, _, false) => (side + t, true),
                    (false, _, true) => (3 * side + (side - t - length), false),
                };
                (place, edge.begins_inside != is_forward, *one)
            })
            .collect();
        around.sort_unstable_by_key(|&(place, ..)| place);
        for (i, &(_, enters, one)) in around.iter().enumerate() {
            let (_, _, next) = around[(i + 1) % around.len()];
            if enters {
                for k in 0..2 {
                    let node = |on_face: &OnFace| {
                        4 * on_face.edge as usize + usize::from(on_face.places[k])
                    };
                    self.join(node(&one), node(&next));
                }
                if face.len() > 3 {
                    self.seams.push(Seam {
                        edges: [one.edge, next.edge],
                        places: [one.places, next.places],
                        face: index,
                    });
                }
            }
        }
    }

    /// Returns the representative of a sheet.
    pub(super) fn root(&mut self, mut node: usize) -> usize {
        while self.parents[node] as usize != node {
            let above = self.parents[node] as usize;
            self.parents[node] = self.parents[above];
            node = above;
        }
        node
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        let (low, high) = (a.min(b), a.max(b));
        self.parents[high] = low as u32;
    }
}

/// Returns the faces that an edge is on: between voxels that are next to each other around it.
fn on_faces(index: u32, edge: &ActiveEdge) -> impl Iterator<Item = OnFace> + use<> {
    let around = edge.around;
    let (u, v) = ((edge.axis + 1) % 3, (edge.axis + 2) % 3);
    (0..4usize).filter_map(move |k| {
        let next = (k + 1) % 4;
        let (a, b) = (around[k], around[next]);
        let normal = if AROUND[k][0] == AROUND[next][0] {
            v
        } else {
            u
        };
        let (voxels, places) = if a < b {
            ([a, b], [k as u8, next as u8])
        } else {
            ([b, a], [next as u8, k as u8])
        };
        (a != b).then_some(OnFace {
            voxels,
            edge: index,
            places,
            normal: normal as u8,
        })
    })
}
