//! The tree of a grid: a root of upper nodes, of lower nodes, of leaves.
//!
//! *Theory.* Museth, "VDB: High-resolution sparse volumes with dynamic topology" (2013). An upper node has 32³ places for
//! lower nodes, a lower node has 16³ places for leaves, and a leaf has 8³ voxels. A place without a child has a tile: one
//! value for all of its voxels.

use crate::{Mask, Voxel};
use std::collections::BTreeMap;

/// Voxels along the side of a leaf, a lower node and an upper node.
pub const NODE_VOXELS: [i32; 3] = [8, 128, 4096];
/// Voxels of a leaf.
pub const LEAF_SIZE: usize = 512;
/// Places of a lower node.
pub const LOWER_SIZE: usize = 4096;
/// Places of an upper node.
pub const UPPER_SIZE: usize = 32768;

/// A leaf: 8³ voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf<V> {
    /// Index of the first voxel: multiples of 8.
    pub origin: [i32; 3],
    /// The voxels that are active.
    pub active: Mask<8>,
    /// Values, z fastest.
    pub values: Box<[V; LEAF_SIZE]>,
}

/// A lower node: 16³ places for leaves or tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Lower<V> {
    /// Index of the first voxel: multiples of 128.
    pub origin: [i32; 3],
    /// The places with a leaf.
    pub children: Mask<64>,
    /// The places with an active tile.
    pub active: Mask<64>,
    /// The tiles' values. Places with a leaf have zero, and writers ignore them.
    pub tiles: Vec<V>,
    /// The leaves, by ascending place.
    pub leaves: Vec<Leaf<V>>,
}

/// An upper node: 32³ places for lower nodes or tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Upper<V> {
    /// Index of the first voxel: multiples of 4096.
    pub origin: [i32; 3],
    /// The places with a lower node.
    pub children: Mask<512>,
    /// The places with an active tile.
    pub active: Mask<512>,
    /// The tiles' values. Places with a lower node have zero, and writers ignore them.
    pub tiles: Vec<V>,
    /// The lower nodes, by ascending place.
    pub lowers: Vec<Lower<V>>,
}

/// A tile of the root: 4096³ voxels with one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RootTile<V> {
    /// Index of the first voxel: multiples of 4096.
    pub origin: [i32; 3],
    /// The value.
    pub value: V,
    /// Whether the voxels are active.
    pub is_active: bool,
}

/// A tree: values at integer coordinates, most of them equal to a background.
///
/// ```
/// use argil_vdb::{Leaf, Tree};
/// let mut leaf = Leaf::new([8, 0, -8], 3.0f32);
/// leaf.set([9, 0, -7], -1.5);
/// let tree = Tree::from_leaves(3.0, vec![leaf]);
/// assert_eq!(tree.value([9, 0, -7]), -1.5);
/// assert_eq!(tree.value([9, 0, 1000]), 3.0);
/// assert_eq!(tree.active_voxels(), 1);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Tree<V> {
    /// The value of voxels that are nowhere else.
    pub background: V,
    /// Tiles of the root.
    pub tiles: Vec<RootTile<V>>,
    /// Upper nodes, in ascending order of their origins.
    pub uppers: Vec<Upper<V>>,
}

/// Returns the first voxel of the node of a side, a power of two, that holds a voxel.
#[inline]
pub(crate) fn origin_of([x, y, z]: [i32; 3], side: i32) -> [i32; 3] {
    [x & -side, y & -side, z & -side]
}

/// Returns the place of a voxel in a node of `side` voxels, whose children have `child` voxels.
#[inline]
pub(crate) fn place_of([x, y, z]: [i32; 3], side: i32, child: i32) -> usize {
    let across = (side / child) as usize;
    let along = |c: i32| ((c & (side - 1)) / child) as usize;
    (along(x) * across + along(y)) * across + along(z)
}

/// Returns the first voxel of a place.
#[inline]
pub(crate) fn voxel_of(origin: [i32; 3], place: usize, side: i32, child: i32) -> [i32; 3] {
    let across = (side / child) as usize;
    let at = [
        place / across / across,
        place / across % across,
        place % across,
    ];
    [0, 1, 2].map(|axis| origin[axis].wrapping_add(at[axis] as i32 * child))
}

/// Returns tiles of one value, and zeros where children are.
fn tiles_beside<V: Voxel, const N: usize>(children: &Mask<N>, value: V) -> Vec<V> {
    let place = |place| {
        if children.is_on(place) {
            V::default()
        } else {
            value
        }
    };
    (0..64 * N).map(place).collect()
}

impl<V: Voxel> Leaf<V> {
    /// Creates a leaf whose voxels are inactive and have one value. `origin` is rounded down to multiples of 8.
    pub fn new(origin: [i32; 3], value: V) -> Self {
        Self {
            origin: origin_of(origin, 8),
            active: Mask::default(),
            values: Box::new([value; LEAF_SIZE]),
        }
    }

    /// Sets a voxel of this leaf, and makes it active.
    pub fn set(&mut self, voxel: [i32; 3], value: V) {
        let place = place_of(voxel, 8, 1);
        self.values[place] = value;
        self.active.set(place, true);
    }
}

impl<V: Voxel> Lower<V> {
    /// Returns the leaf at a place.
    fn leaf_at(&self, place: usize) -> Option<&Leaf<V>> {
        let key = |leaf: &Leaf<V>| place_of(leaf.origin, 128, 8);
        let at = self.leaves.binary_search_by_key(&place, key);
        at.ok().map(|at| &self.leaves[at])
    }

    fn from_leaves(origin: [i32; 3], background: V, mut leaves: Vec<Leaf<V>>) -> Self {
        let place = |leaf: &Leaf<V>| place_of(leaf.origin, 128, 8);
        leaves.sort_by_key(place);
        leaves.dedup_by_key(|leaf| leaf.origin);
        let mut children = Mask::default();
        for leaf in &leaves {
            children.set(place(leaf), true);
        }
        Self {
            origin,
            tiles: tiles_beside(&children, background),
            children,
            active: Mask::default(),
            leaves,
        }
    }
}

impl<V: Voxel> Upper<V> {
    /// Creates an upper node from leaves that lie in it. Of leaves with one origin, the first stays. Tiles are inactive
    /// and have the background's value.
    pub fn from_leaves(origin: [i32; 3], background: V, leaves: Vec<Leaf<V>>) -> Self {
        let mut by_lower = BTreeMap::<usize, Vec<Leaf<V>>>::new();
        for leaf in leaves {
            let place = place_of(leaf.origin, 4096, 128);
            by_lower.entry(place).or_default().push(leaf);
        }
        let mut children = Mask::default();
        for &place in by_lower.keys() {
            children.set(place, true);
        }
        let origin = origin_of(origin, 4096);
        let lowers = by_lower.into_iter().map(|(place, leaves)| {
            Lower::from_leaves(voxel_of(origin, place, 4096, 128), background, leaves)
        });
        Self {
            origin,
            tiles: tiles_beside(&children, background),
            children,
            active: Mask::default(),
            lowers: lowers.collect(),
        }
    }

    /// Returns the lower node at a place.
    fn lower_at(&self, place: usize) -> Option<&Lower<V>> {
        let key = |lower: &Lower<V>| place_of(lower.origin, 4096, 128);
        let at = self.lowers.binary_search_by_key(&place, key);
        at.ok().map(|at| &self.lowers[at])
    }

    /// Returns the leaves.
    pub fn leaves(&self) -> impl Iterator<Item = &Leaf<V>> {
        self.lowers.iter().flat_map(|lower| &lower.leaves)
    }
}

impl<V: Voxel> Tree<V> {
    /// Creates a tree without nodes.
    pub fn new(background: V) -> Self {
        Self {
            background,
            tiles: Vec::new(),
            uppers: Vec::new(),
        }
    }

    /// Creates a tree from leaves, in any order. Of leaves with one origin, the first stays.
    pub fn from_leaves(background: V, leaves: Vec<Leaf<V>>) -> Self {
        let mut by_upper = BTreeMap::<[i32; 3], Vec<Leaf<V>>>::new();
        for leaf in leaves {
            by_upper
                .entry(origin_of(leaf.origin, 4096))
                .or_default()
                .push(leaf);
        }
        let uppers = by_upper.into_iter();
        Self {
            background,
            tiles: Vec::new(),
            uppers: uppers
                .map(|(origin, leaves)| Upper::from_leaves(origin, background, leaves))
                .collect(),
        }
    }

    /// Returns the value of a voxel.
    pub fn value(&self, voxel: [i32; 3]) -> V {
        self.value_and_state(voxel).0
    }

    /// Returns the value of a voxel, and whether it is active.
    pub fn value_and_state(&self, voxel: [i32; 3]) -> (V, bool) {
        let origin = origin_of(voxel, 4096);
        let Ok(at) = self
            .uppers
            .binary_search_by_key(&origin, |upper| upper.origin)
        else {
            let tile = self.tiles.iter().find(|tile| tile.origin == origin);
            return tile.map_or((self.background, false), |tile| {
                (tile.value, tile.is_active)
            });
        };
        let upper = &self.uppers[at];
        let place = place_of(voxel, 4096, 128);
        if !upper.children.is_on(place) {
            return (upper.tiles[place], upper.active.is_on(place));
        }
        let Some(lower) = upper.lower_at(place) else {
            return (self.background, false);
        };
        let place = place_of(voxel, 128, 8);
        if !lower.children.is_on(place) {
            return (lower.tiles[place], lower.active.is_on(place));
        }
        let Some(leaf) = lower.leaf_at(place) else {
            return (self.background, false);
        };
        let place = place_of(voxel, 8, 1);
        (leaf.values[place], leaf.active.is_on(place))
    }

    /// Returns the leaf that holds a voxel.
    pub fn leaf(&self, voxel: [i32; 3]) -> Option<&Leaf<V>> {
        let origin = origin_of(voxel, 4096);
        let at = self
            .uppers
            .binary_search_by_key(&origin, |upper| upper.origin);
        let lower = self.uppers[at.ok()?].lower_at(place_of(voxel, 4096, 128))?;
        lower.leaf_at(place_of(voxel, 128, 8))
    }

    /// Replaces active tiles by leaves, and other tiles by the background. Returns false, and changes nothing, if there
    /// would be more than a number of leaves.
    pub fn expand_active_tiles(&mut self, max_leaves: u64) -> bool {
        let counts = self.statistics();
        let [lower, upper, root] = counts.active_tiles;
        if counts.active_tiles == [0; 3] {
            return true;
        }
        let leaves = upper
            .saturating_mul(16 * 16 * 16)
            .saturating_add(lower + counts.nodes[0]);
        if root > 0 || leaves > max_leaves {
            return false;
        }
        let mut all = Vec::new();
        let full = |origin: [i32; 3], value: V| {
            let mut leaf = Leaf::new(origin, value);
            leaf.active = Mask([u64::MAX; 8]);
            leaf
        };
        for upper in std::mem::take(&mut self.uppers) {
            for place in upper.active.places() {
                let origin = voxel_of(upper.origin, place, 4096, 128);
                let value = upper.tiles[place];
                all.extend((0..LOWER_SIZE).map(|i| full(voxel_of(origin, i, 128, 8), value)));
            }
            for lower in upper.lowers {
                for place in lower.active.places() {
                    let origin = voxel_of(lower.origin, place, 128, 8);
                    all.push(full(origin, lower.tiles[place]));
                }
                all.extend(lower.leaves);
            }
        }
        *self = Self::from_leaves(self.background, all);
        true
    }

    /// Returns the leaves.
    pub fn leaves(&self) -> impl Iterator<Item = &Leaf<V>> {
        self.uppers.iter().flat_map(Upper::leaves)
    }

    /// Counts the active voxels, with those of tiles.
    pub fn active_voxels(&self) -> u64 {
        self.statistics().active_voxels
    }

    /// Computes counts and the box of the active voxels.
    pub fn statistics(&self) -> TreeStatistics {
        let mut all = TreeStatistics::default();
        for tile in self.tiles.iter().filter(|tile| tile.is_active) {
            all.add_root_tile(tile.origin);
        }
        for upper in &self.uppers {
            all.add_upper(upper);
        }
        all
    }
}

/// Counts of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TreeStatistics {
    /// Active voxels, with those of tiles.
    pub active_voxels: u64,
    /// Number of leaves, lower nodes and upper nodes.
    pub nodes: [u64; 3],
    /// Active tiles of lower nodes, of upper nodes and of the root.
    pub active_tiles: [u64; 3],
    /// The first and the last active voxel along each axis. If none is active, the first is larger than the last.
    pub bounds: [[i32; 3]; 2],
}

impl Default for TreeStatistics {
    fn default() -> Self {
        Self {
            active_voxels: 0,
            nodes: [0; 3],
            active_tiles: [0; 3],
            bounds: [[i32::MAX; 3], [i32::MIN; 3]],
        }
    }
}

impl TreeStatistics {
    fn hold(&mut self, low: [i32; 3], high: [i32; 3]) {
        for axis in 0..3 {
            self.bounds[0][axis] = self.bounds[0][axis].min(low[axis]);
            self.bounds[1][axis] = self.bounds[1][axis].max(high[axis]);
        }
    }

    fn add_tile(&mut self, origin: [i32; 3], side: i32) {
        let level = NODE_VOXELS
            .iter()
            .position(|&voxels| voxels == side)
            .unwrap_or(0);
        self.active_tiles[level] += 1;
        self.active_voxels = self
            .active_voxels
            .saturating_add(u64::from(side as u32).pow(3));
        self.hold(origin, origin.map(|c| c.wrapping_add(side - 1)));
    }

    pub(crate) fn add_root_tile(&mut self, origin: [i32; 3]) {
        self.add_tile(origin, 4096);
    }

    /// Adds an upper node with all that it holds.
    pub(crate) fn add_upper<V: Voxel>(&mut self, upper: &Upper<V>) {
        self.nodes[2] += 1;
        for place in upper.active.places() {
            self.add_tile(voxel_of(upper.origin, place, 4096, 128), 128);
        }
        for lower in &upper.lowers {
            self.nodes[1] += 1;
            for place in lower.active.places() {
                self.add_tile(voxel_of(lower.origin, place, 128, 8), 8);
            }
            for leaf in &lower.leaves {
                self.nodes[0] += 1;
                self.active_voxels += leaf.active.count() as u64;
                if let Some([low, high]) = active_box(leaf) {
                    self.hold(low, high);
                }
            }
        }
    }
}

/// Returns the first and the last active voxel of a leaf along each axis.
pub(crate) fn active_box<V>(leaf: &Leaf<V>) -> Option<[[i32; 3]; 2]> {
    if leaf.active.is_empty() {
        return None;
    }
    // Word x holds the voxels of one x: a byte for each y, and in it a bit for each z.
    let words = &leaf.active.0;
    let x0 = words.iter().position(|&word| word != 0)?;
    let x1 = words.iter().rposition(|&word| word != 0)?;
    let all = words.iter().fold(0, |all, word| all | word);
    let bytes = all.to_le_bytes();
    let y0 = bytes.iter().position(|&byte| byte != 0)?;
    let y1 = bytes.iter().rposition(|&byte| byte != 0)?;
    let row = bytes.iter().fold(0, |all, byte| all | byte);
    let (z0, z1) = (row.trailing_zeros(), 7 - row.leading_zeros());
    let at = |inner: [usize; 3]| {
        [0, 1, 2].map(|axis| leaf.origin[axis].wrapping_add(inner[axis] as i32))
    };
    Some([at([x0, y0, z0 as usize]), at([x1, y1, z1 as usize])])
}
