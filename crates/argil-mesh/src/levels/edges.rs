//! The minimal edges on which the sign changes.

use argil_volume::{LeafCell, Levels};
use glam::{DVec3, IVec3};
use rayon::prelude::*;

/// A voxel of a leaf: its cell, its level, and its index in the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Voxel(u64);

impl Voxel {
    fn new(leaf: &LeafCell, voxel: IVec3) -> Self {
        let index = u64::from(leaf.voxel_of(voxel));
        Self(u64::from(leaf.cell) << 16 | u64::from(leaf.level) << 9 | index)
    }

    pub(super) fn cell(self) -> u32 {
        (self.0 >> 16) as u32
    }

    /// Returns the minimum corner, in voxels of level 0.
    pub(super) fn corner(self, levels: &Levels) -> IVec3 {
        let index = (self.0 & 511) as i32;
        let at = IVec3::new(index & 7, index >> 3 & 7, index >> 6);
        levels.leaf(self.cell()).origin + (at << self.level())
    }

    pub(super) fn level(self) -> u32 {
        (self.0 >> 9 & 127) as u32
    }
}

/// A minimal edge on which the sign changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct ActiveEdge {
    /// The lower end, in voxels of level 0.
    pub begin: IVec3,
    pub axis: usize,
    pub level: u32,
    /// Where the sign changes, from 0 to 1.
    share: f32,
    /// Whether the lower end is inside.
    pub begins_inside: bool,
    /// The voxels around it, counterclockwise as seen from its upper end.
    pub around: [Voxel; 4],
}

impl ActiveEdge {
    pub(super) fn length(&self) -> i32 {
        1 << self.level
    }

    /// Returns a voxel around it that is not larger than it.
    pub(super) fn voxel(&self) -> Voxel {
        let smallest = self.around.iter().min_by_key(|voxel| voxel.level());
        *smallest.unwrap_or(&self.around[0])
    }

    /// Returns where the sign changes, in voxels of level 0.
    pub(super) fn crossing(&self) -> DVec3 {
        let mut at = self.begin.as_dvec3();
        at[self.axis] += f64::from(self.share) * f64::from(self.length());
        at
    }
}

/// Distances in voxels whose signs rounding can change.
const DOUBTFUL: f32 = 0.05;

/// The places of the voxels around an edge along its two other axes, in voxels of level 0 from the edge.
pub(super) const AROUND: [[i32; 2]; 4] = [[-1, -1], [0, -1], [0, 0], [-1, 0]];

/// Finds all minimal edges on which the sign changes, each once.
pub(super) fn active_edges(levels: &Levels) -> Vec<ActiveEdge> {
    levels
        .leaves()
        .par_iter()
        .flat_map_iter(|leaf| edges_of(levels, leaf))
        .collect()
}

fn edges_of(levels: &Levels, leaf: &LeafCell) -> Vec<ActiveEdge> {
    let codes = levels.leaf_samples(leaf);
    let index = |at: IVec3| (at.x + 9 * (at.y + 9 * at.z)) as usize;
    let insides = insides_of(levels, leaf, &codes);
    let mut found = Vec::new();
    for axis in 0..3 {
        let mut end = IVec3::splat(9);
        end[axis] = 8;
        for z in 0..end.z {
            for y in 0..end.y {
                for x in 0..end.x {
                    let at = IVec3::new(x, y, z);
                    let (a, b) = (index(at), index(at + IVec3::AXES[axis]));
                    if insides[a] == insides[b] {
                        continue;
                    }
                    let begin = leaf.origin + (at << leaf.level);
                    if let Some(around) = voxels_around(levels, leaf, at, begin, axis) {
                        let length = |i: usize| f32::from(codes[i].unsigned_abs().max(1));
                        found.push(ActiveEdge {
                            begin,
                            axis,
                            level: leaf.level,
                            share: length(a) / (length(a) + length(b)),
                            begins_inside: insides[a],
                            around,
                        });
                    }
                }
            }
        }
    }
    found
}

/// Returns which samples of a leaf are inside. Where the surface is so near a corner on the leaf's side that rounding
/// decides, the finest leaf there does, so that all leaves agree.
fn insides_of(levels: &Levels, leaf: &LeafCell, codes: &[i16; 729]) -> Box<[bool; 729]> {
    let mut insides = Box::new(codes.map(|code| code < 0));
    let finest = levels.layout().level(0);
    let per_voxel = finest.encoding().format.max_code() as f32 * finest.voxel_grid().voxel_size
        / finest.encoding().band_width(finest.voxel_grid(), 0);
    let near = (DOUBTFUL * per_voxel).ceil() as u16;
    for (i, inside) in insides.iter_mut().enumerate() {
        if codes[i].unsigned_abs() > near {
            continue;
        }
        let i = i as i32;
        let at = IVec3::new(i % 9, i / 9 % 9, i / 81);
        if at.cmpeq(IVec3::ZERO).any() || at.cmpeq(IVec3::splat(8)).any() {
            let corner = leaf.origin + (at << leaf.level);
            let around = (0..8).filter_map(|k| {
                let beside = corner - IVec3::new(k & 1, k >> 1 & 1, k >> 2);
                levels.leaf_at(beside)
            });
            let decides = around
                .filter(|neighbor| levels.has_brick(neighbor))
                .min_by_key(|leaf| (leaf.level, leaf.cell));
            if let Some(leaf) = decides {
                *inside = levels.leaf_sample(&leaf, (corner - leaf.origin) >> leaf.level) < 0;
            }
        }
    }
    insides
}

/// Returns the voxels around an edge of a leaf, or `None` if a finer voxel divides it, another leaf owns it, or the world
/// ends there.
fn voxels_around(
    levels: &Levels,
    leaf: &LeafCell,
    at: IVec3,
    begin: IVec3,
    axis: usize,
) -> Option<[Voxel; 4]> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut around = [Voxel(0); 4];
    for (neighbor, [du, dv]) in around.iter_mut().zip(AROUND) {
        let mut voxel = begin;
        voxel[u] += du;
        voxel[v] += dv;
        let is_within = (1..8).contains(&at[u]) && (1..8).contains(&at[v]);
        let other = if is_within {
            *leaf
        } else {
            levels.leaf_at(voxel)?
        };
        let is_owner = other.cell >= leaf.cell || !levels.has_brick(&other);
        if other.level < leaf.level || (other.level == leaf.level && !is_owner) {
            return None;
        }
        *neighbor = Voxel::new(&other, voxel);
    }
    Some(around)
}
