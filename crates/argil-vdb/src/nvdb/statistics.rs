//! Extremes, mean and deviation of a node's active values.

use crate::tree::{active_box, voxel_of};
use crate::{Leaf, Lower, Tree, Upper};
use rayon::prelude::*;

/// Sums of a node's active values, and their box.
#[derive(Clone, Copy, Debug)]
pub(super) struct ValueStatistics {
    pub least: f32,
    pub most: f32,
    sum: f64,
    squares: f64,
    count: u64,
    pub bounds: [[i32; 3]; 2],
}

impl Default for ValueStatistics {
    fn default() -> Self {
        Self {
            least: f32::INFINITY,
            most: f32::NEG_INFINITY,
            sum: 0.0,
            squares: 0.0,
            count: 0,
            bounds: [[i32::MAX; 3], [i32::MIN; 3]],
        }
    }
}

impl ValueStatistics {
    fn add(&mut self, value: f32, count: u64) {
        self.least = self.least.min(value);
        self.most = self.most.max(value);
        let (x, n) = (f64::from(value), count as f64);
        self.sum += n * x;
        self.squares += n * x * x;
        self.count += count;
    }

    fn hold(&mut self, [low, high]: [[i32; 3]; 2]) {
        for axis in 0..3 {
            self.bounds[0][axis] = self.bounds[0][axis].min(low[axis]);
            self.bounds[1][axis] = self.bounds[1][axis].max(high[axis]);
        }
    }

    fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
        self.sum += other.sum;
        self.squares += other.squares;
        self.count += other.count;
        self.hold(other.bounds);
    }

    fn add_tile(&mut self, value: f32, origin: [i32; 3], side: i32) {
        self.add(value, u64::from(side as u32).pow(3));
        self.hold([origin, origin.map(|c| c.wrapping_add(side - 1))]);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the minimum, maximum, mean and standard deviation. Without active values, all but the last two are
    /// `other`.
    pub(super) fn four(&self, other: f32) -> [f32; 4] {
        if self.count == 0 {
            return [other, other, 0.0, 0.0];
        }
        let n = self.count as f64;
        let mean = self.sum / n;
        let variance = (self.squares / n - mean * mean).max(0.0);
        [self.least, self.most, mean as f32, variance.sqrt() as f32]
    }
}

/// The statistics of all nodes, in their order in files.
#[derive(Debug, Default)]
pub(super) struct AllStatistics {
    pub root: ValueStatistics,
    pub uppers: Vec<ValueStatistics>,
    pub lowers: Vec<ValueStatistics>,
}

pub(super) fn of_leaf(leaf: &Leaf<f32>) -> ValueStatistics {
    let mut statistics = ValueStatistics::default();
    for place in leaf.active.places() {
        statistics.add(leaf.values[place], 1);
    }
    if let Some(bounds) = active_box(leaf) {
        statistics.hold(bounds);
    }
    statistics
}

fn of_lower(lower: &Lower<f32>) -> ValueStatistics {
    let mut statistics = ValueStatistics::default();
    for leaf in &lower.leaves {
        statistics.merge(&of_leaf(leaf));
    }
    for place in lower.active.places() {
        let origin = voxel_of(lower.origin, place, 128, 8);
        statistics.add_tile(lower.tiles[place], origin, 8);
    }
    statistics
}

fn of_upper(upper: &Upper<f32>, lowers: &[ValueStatistics]) -> ValueStatistics {
    let mut statistics = ValueStatistics::default();
    for lower in lowers {
        statistics.merge(lower);
    }
    for place in upper.active.places() {
        let origin = voxel_of(upper.origin, place, 4096, 128);
        statistics.add_tile(upper.tiles[place], origin, 128);
    }
    statistics
}

pub(super) fn of_tree(tree: &Tree<f32>) -> AllStatistics {
    let mut all = AllStatistics::default();
    for upper in &tree.uppers {
        let lowers: Vec<_> = upper.lowers.par_iter().map(of_lower).collect();
        let statistics = of_upper(upper, &lowers);
        all.root.merge(&statistics);
        all.uppers.push(statistics);
        all.lowers.extend(lowers);
    }
    for tile in tree.tiles.iter().filter(|tile| tile.is_active) {
        all.root.add_tile(tile.value, tile.origin, 4096);
    }
    all
}
