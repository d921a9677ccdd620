//! Writes `.nvdb` files.

use super::NanoType;
use super::bytes::Bytes;
use super::layout::{
    FILE_HEADER, FILE_METADATA, GRID, LOWER, MAGIC, ROOT, ROOT_TILE, TREE, UPPER, VERSION, key_of,
};
use super::nodes::{leaf_bytes_of, lower_bytes, upper_bytes};
use super::statistics::{AllStatistics, ValueStatistics, of_tree};
use crate::{Grid, GridClass, Leaf, Lower, Transform, Tree, TreeStatistics};
use rayon::prelude::*;
use std::io::{Result, Seek, SeekFrom, Write};

/// Flags of a grid: it has boxes, extremes, means and deviations, and its nodes lie level by level.
const FLAGS: u32 = 0b11_1110;
/// Leaves that are packed together before they are written.
const BATCH: usize = 4096;

/// Writes a grid to a `.nvdb` file, with statistics and checksums.
///
/// ```
/// use argil_vdb::{Grid, GridClass, GridHeader, Leaf, Transform, Tree, nvdb};
/// let mut leaf = Leaf::new([0, 0, 0], 3.0f32);
/// leaf.set([1, 2, 3], -0.5);
/// let header = GridHeader::new("surface", GridClass::LevelSet, Transform::uniform(0.1, [0.0; 3]));
/// let grid = Grid::new(header, Tree::from_leaves(3.0, vec![leaf]));
/// let mut bytes = std::io::Cursor::new(Vec::new());
/// nvdb::write(&mut bytes, &grid, nvdb::NanoType::Float)?;
/// assert_eq!(nvdb::read(bytes.get_ref())?[0].tree, grid.tree);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If `out` fails, or the name has more than 255 bytes.
pub fn write(out: &mut (impl Write + Seek), grid: &Grid<f32>, kind: NanoType) -> Result<()> {
    let name = grid.header.name.as_bytes();
    if name.len() > 255 || name.contains(&0) {
        return Err(std::io::Error::other(
            "the grid's name has more than 255 bytes, or a zero",
        ));
    }
    let counts = grid.tree.statistics();
    let statistics = of_tree(&grid.tree);
    let head = Head {
        grid,
        kind,
        counts: &counts,
        root: &statistics.root,
    };
    let mut file = head.file();
    let grid_bytes = head.grid();
    let begin = out.stream_position()?;
    let at = begin + file.len() as u64;
    file.extend(&grid_bytes);
    out.write_all(&file)?;
    let head_sum = crc32fast::hash(&grid_bytes[16..]);
    // A checksum of the nodes' checksums, each with 64 bits.
    let mut sums = crc32fast::Hasher::new();
    write_nodes(out, &head, &statistics, &mut |all| {
        for sum in all {
            sums.update(&u64::from(*sum).to_le_bytes());
        }
    })?;
    let node_sum = if counts.nodes == [0; 3] {
        u32::MAX
    } else {
        sums.finalize()
    };
    let end = out.stream_position()?;
    out.seek(SeekFrom::Start(at + 8))?;
    out.write_all(&[head_sum.to_le_bytes(), node_sum.to_le_bytes()].concat())?;
    out.seek(SeekFrom::Start(end))?;
    out.flush()
}

/// What comes before the nodes.
struct Head<'a> {
    grid: &'a Grid<f32>,
    kind: NanoType,
    counts: &'a TreeStatistics,
    root: &'a ValueStatistics,
}

impl Head<'_> {
    fn tree(&self) -> &Tree<f32> {
        &self.grid.tree
    }

    fn root_bytes(&self) -> usize {
        let tree = self.tree();
        ROOT + ROOT_TILE * (tree.uppers.len() + tree.tiles.len())
    }

    /// Returns the positions of the first leaf, lower node and upper node, and the end, from the tree on.
    fn offsets(&self) -> [u64; 4] {
        let [leaves, lowers, uppers] = self.counts.nodes;
        let upper = (TREE + self.root_bytes()) as u64;
        let lower = upper + uppers * UPPER.bytes() as u64;
        let leaf = lower + lowers * LOWER.bytes() as u64;
        [
            leaf,
            lower,
            upper,
            leaf + leaves * self.kind.leaf_bytes() as u64,
        ]
    }

    fn grid_bytes(&self) -> u64 {
        GRID as u64 + self.offsets()[3]
    }

    /// Returns the world's box of the active voxels.
    fn world_box(&self) -> [[f64; 3]; 2] {
        if self.root.is_empty() {
            return [[f64::MAX; 3], [f64::MIN; 3]];
        }
        let [low, high] = self.root.bounds;
        let mut all = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for corner in 0..8 {
            let at = [0, 1, 2].map(|axis| match corner >> axis & 1 {
                0 => f64::from(low[axis]),
                _ => f64::from(high[axis]) + 1.0,
            });
            let at = self.grid.header.transform.to_world(at);
            for axis in 0..3 {
                all[0][axis] = all[0][axis].min(at[axis]);
                all[1][axis] = all[1][axis].max(at[axis]);
            }
        }
        all
    }

    fn class(&self) -> u32 {
        match self.grid.header.class {
            GridClass::Unknown => 0,
            GridClass::LevelSet => 1,
            GridClass::FogVolume => 2,
        }
    }

    /// Returns the file's header and the grid's metadata.
    fn file(&self) -> Vec<u8> {
        let mut out = Bytes::default();
        out.u64(MAGIC).u32(VERSION).u32(1);
        let name = self.grid.header.name.as_bytes();
        out.u64(self.grid_bytes())
            .u64(self.grid_bytes())
            .u64(name_key(name));
        out.u64(self.counts.active_voxels);
        out.u32(self.kind.number()).u32(self.class());
        out.doubles(self.world_box().as_flattened());
        out.ints(self.index_box().as_flattened());
        out.doubles(&self.grid.header.transform.voxel_size());
        out.u32(name.len() as u32 + 1);
        for count in self.counts.nodes {
            out.u32(count as u32);
        }
        out.u32(1);
        for count in self.counts.active_tiles {
            out.u32(count as u32);
        }
        // No codec.
        out.u32(0).u32(VERSION);
        debug_assert_eq!(out.0.len(), FILE_HEADER + FILE_METADATA);
        out.0.extend(name);
        out.0.push(0);
        out.0
    }

    fn index_box(&self) -> [[i32; 3]; 2] {
        if self.root.is_empty() {
            return [[i32::MAX; 3], [i32::MIN; 3]];
        }
        self.root.bounds
    }

    /// Returns the grid's, the tree's and the root's bytes. The checksum is empty.
    fn grid(&self) -> Vec<u8> {
        let mut out = Bytes::default();
        out.u64(MAGIC).u64(u64::MAX).u32(VERSION).u32(FLAGS);
        out.u32(0).u32(1).u64(self.grid_bytes());
        let mut name = self.grid.header.name.as_bytes().to_vec();
        name.resize(256, 0);
        out.0.extend(name);
        write_map(&self.grid.header.transform, &mut out);
        out.doubles(self.world_box().as_flattened());
        out.doubles(&self.grid.header.transform.voxel_size());
        out.u32(self.class()).u32(self.kind.number());
        out.0.resize(GRID, 0);
        let [leaf, lower, upper, _] = self.offsets();
        let or_zero = |at: u64, count: u64| if count == 0 { 0 } else { at };
        let [leaves, lowers, uppers] = self.counts.nodes;
        out.u64(or_zero(leaf, leaves)).u64(or_zero(lower, lowers));
        out.u64(or_zero(upper, uppers)).u64(TREE as u64);
        for count in self
            .counts
            .nodes
            .into_iter()
            .chain(self.counts.active_tiles)
        {
            out.u32(count as u32);
        }
        out.u64(self.counts.active_voxels);
        self.root(&mut out);
        out.0
    }

    fn root(&self, out: &mut Bytes) {
        let tree = self.tree();
        out.ints(self.index_box().as_flattened());
        out.u32((tree.uppers.len() + tree.tiles.len()) as u32);
        out.float(tree.background);
        out.floats(&self.root.four(tree.background));
        out.0.resize(GRID + TREE + ROOT, 0);
        let first = self.root_bytes() as u64;
        let uppers = tree.uppers.iter().enumerate().map(|(i, upper)| {
            let child = first + (i * UPPER.bytes()) as u64;
            (key_of(upper.origin), child, false, 0.0)
        });
        let tiles = tree
            .tiles
            .iter()
            .map(|tile| (key_of(tile.origin), 0, tile.is_active, tile.value));
        let mut all: Vec<_> = uppers.chain(tiles).collect();
        all.sort_by_key(|entry| entry.0);
        for (key, child, is_active, value) in all {
            out.u64(key)
                .u64(child)
                .u32(u32::from(is_active))
                .float(value);
            out.0.extend([0; 8]);
        }
    }
}

/// Returns the hash by which programs look names up.
fn name_key(name: &[u8]) -> u64 {
    name.iter().fold(0u64, |hash, byte| {
        let added = u64::from(*byte) + (hash >> 56);
        hash.wrapping_mul(67).wrapping_add(added)
    })
}

fn write_map(transform: &Transform, out: &mut Bytes) {
    let columns = transform.columns;
    let matrix: [[f64; 3]; 3] = [0, 1, 2].map(|row| [0, 1, 2].map(|axis| columns[axis][row]));
    let inverse = inverse(&matrix);
    let single = |all: &[f64]| all.iter().map(|&n| n as f32).collect::<Vec<f32>>();
    out.floats(&single(matrix.as_flattened()));
    out.floats(&single(inverse.as_flattened()));
    out.floats(&single(&transform.translation)).float(1.0);
    out.doubles(matrix.as_flattened())
        .doubles(inverse.as_flattened());
    out.doubles(&transform.translation).doubles(&[1.0]);
}

/// Inverts a matrix of rows by its cofactors.
fn inverse(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let cofactor = |i: usize, k: usize| {
        let ([a, b], [c, d]) = ([(i + 1) % 3, (i + 2) % 3], [(k + 1) % 3, (k + 2) % 3]);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3).map(|k| m[0][k] * cofactor(0, k)).sum();
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| cofactor(column, row) / determinant))
}

fn write_nodes(
    out: &mut impl Write,
    head: &Head<'_>,
    statistics: &AllStatistics,
    summed: &mut dyn FnMut(&[u32]),
) -> Result<()> {
    let tree = head.tree();
    let [first_leaf, first_lower, first_upper, _] = head.offsets();
    let leaf_bytes = head.kind.leaf_bytes();
    let mut put = |nodes: Vec<Vec<u8>>| {
        let sums: Vec<u32> = nodes
            .par_iter()
            .map(|bytes| crc32fast::hash(bytes))
            .collect();
        summed(&sums);
        nodes.iter().try_for_each(|bytes| out.write_all(bytes))
    };
    let mut lowers = 0;
    for (i, upper) in tree.uppers.iter().enumerate() {
        let at = first_upper + (i * UPPER.bytes()) as u64;
        let child = first_lower + (lowers * LOWER.bytes()) as u64;
        put(vec![upper_bytes(upper, child - at, &statistics.uppers[i])])?;
        lowers += upper.lowers.len();
    }
    let all: Vec<&Lower<f32>> = tree.uppers.iter().flat_map(|upper| &upper.lowers).collect();
    let mut places = Vec::with_capacity(all.len());
    let mut leaves = 0;
    for lower in &all {
        places.push(leaves);
        leaves += lower.leaves.len();
    }
    for first in (0..all.len()).step_by(64) {
        let range = first..(first + 64).min(all.len());
        let nodes = range.into_par_iter().map(|i| {
            let at = first_lower + (i * LOWER.bytes()) as u64;
            let child = first_leaf + (places[i] * leaf_bytes) as u64;
            lower_bytes(all[i], child - at, leaf_bytes, &statistics.lowers[i])
        });
        put(nodes.collect())?;
    }
    let leaves: Vec<&Leaf<f32>> = tree.leaves().collect();
    for chunk in leaves.chunks(BATCH) {
        let nodes = chunk.par_iter().map(|leaf| leaf_bytes_of(leaf, head.kind));
        put(nodes.collect())?;
    }
    Ok(())
}
