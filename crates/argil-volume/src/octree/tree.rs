//! The tree above the bricks. `tree.wgsl` is the twin.

use super::OctreeLayout;
use argil_abi::OctreeNode;
use argil_math::morton;
use glam::UVec3;

/// Bricks by code, and the nodes above them.
#[derive(Clone, Debug, PartialEq)]
pub struct OctreeNodes {
    codes: Vec<u32>,
    nodes: Vec<OctreeNode>,
    /// The index where each level begins. The parents of bricks are level 0, and the root is the last.
    levels: Vec<u32>,
}

/// The result of a look-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lookup {
    /// The brick's index among the codes, or `None` if there is no brick.
    pub brick: Option<u32>,
    /// Number of nodes that were visited.
    pub nodes: u32,
}

impl OctreeNodes {
    /// Builds `depth` levels over ascending codes.
    ///
    /// Level by level, a child whose parent differs from its left neighbor's begins a node. Each child sets its bit
    /// in its parent's mask.
    pub fn from_codes(codes: Vec<u32>, depth: u32) -> Self {
        let mut nodes = Vec::new();
        let mut levels = Vec::new();
        let mut keys = codes.clone();
        for level in 0..depth {
            let begin = nodes.len();
            levels.push(begin as u32);
            let mut parents: Vec<u32> = Vec::with_capacity(keys.len() / 2 + 1);
            for (i, &key) in keys.iter().enumerate() {
                if i == 0 || keys[i - 1] >> 3 != key >> 3 {
                    parents.push(key >> 3);
                    nodes.push(OctreeNode {
                        child_offset: i as u32,
                        ..OctreeNode::default()
                    });
                }
                let node = &mut nodes[begin + parents.len() - 1];
                node.valid_mask |= 1 << (key & 7);
                if level == 0 {
                    node.leaf_mask |= 1 << (key & 7);
                }
            }
            keys = parents;
        }
        Self {
            codes,
            nodes,
            levels,
        }
    }

    /// Creates nodes from stored parts. [`OctreeNodes::check`] validates them.
    pub fn from_parts(codes: Vec<u32>, nodes: Vec<OctreeNode>, levels: Vec<u32>) -> Self {
        Self {
            codes,
            nodes,
            levels,
        }
    }

    /// Returns the Morton codes of the bricks, ascending.
    pub fn codes(&self) -> &[u32] {
        &self.codes
    }

    /// Returns all nodes, parents of bricks first, root last.
    pub fn nodes(&self) -> &[OctreeNode] {
        &self.nodes
    }

    /// Returns the index where each level begins among the nodes.
    pub fn levels(&self) -> &[u32] {
        &self.levels
    }

    /// Returns the bytes of codes, nodes and levels.
    pub fn memory_bytes(&self) -> u64 {
        (size_of_val(&self.codes[..])
            + size_of_val(&self.nodes[..])
            + size_of_val(&self.levels[..])) as u64
    }

    /// Returns what is wrong with the tree, if anything: codes that do not ascend or lie outside the volume, or
    /// nodes that do not match the codes.
    pub fn check(&self, layout: &OctreeLayout) -> Option<&'static str> {
        if !self.codes.is_sorted_by(|a, b| a < b) {
            return Some("codes do not ascend");
        }
        let in_grid = |&code: &u32| {
            code < layout.code_count() && layout.contains_voxels(argil_math::morton_cell(code))
        };
        if !self.codes.iter().all(in_grid) {
            return Some("a code lies outside of the volume");
        }
        let right = Self::from_codes(self.codes.clone(), layout.depth);
        if right.levels != self.levels {
            return Some("levels do not begin where their nodes do");
        }
        (right.nodes != self.nodes).then_some("nodes are not those of the codes")
    }

    /// Descends from the root to a cell.
    pub fn find(&self, cell: UVec3) -> Lookup {
        self.find_from(cell, &mut DescentPath::default())
    }

    /// Descends to a cell from the deepest node that it shares with the cell where `path` ended.
    pub fn find_from(&self, cell: UVec3, path: &mut DescentPath) -> Lookup {
        let code = morton(cell);
        let depth = self.levels.len() as u32;
        let Some(root) = self.nodes.len().checked_sub(1) else {
            return Lookup {
                brick: None,
                nodes: 0,
            };
        };
        path.nodes[depth as usize - 1] = root as u32;
        let mut level = path.first_level(code, depth);
        let mut nodes = 0;
        path.code = code;
        loop {
            nodes += 1;
            let node = self.nodes[path.nodes[level as usize] as usize];
            let bit = code >> (3 * level) & 7;
            if node.valid_mask >> bit & 1 == 0 {
                path.end = level;
                return Lookup { brick: None, nodes };
            }
            let child = node.child_offset + (node.valid_mask & ((1 << bit) - 1)).count_ones();
            if level == 0 {
                path.end = 0;
                return Lookup {
                    brick: Some(child),
                    nodes,
                };
            }
            level -= 1;
            path.nodes[level as usize] = self.levels[level as usize] + child;
        }
    }
}

/// The nodes from the root to the end of a look-up. An empty path makes the next look-up start at the root.
#[derive(Clone, Copy, Debug, Default)]
pub struct DescentPath {
    /// Nodes by level.
    nodes: [u32; argil_abi::OCTREE_MAX_DEPTH as usize],
    code: u32,
    /// The lowest known level. The depth, or more, if none is known.
    end: u32,
    is_known: bool,
}

impl DescentPath {
    /// Creates a path that records look-ups.
    pub fn recording() -> Self {
        Self {
            is_known: true,
            end: u32::MAX,
            ..Self::default()
        }
    }

    /// Returns the level to start at: the lowest known one whose node contains both codes.
    fn first_level(&self, code: u32, depth: u32) -> u32 {
        if !self.is_known || self.end >= depth {
            return depth - 1;
        }
        // A node of level l contains all codes that agree from bit 3 (l + 1) on.
        let differing = 32 - (code ^ self.code).leading_zeros();
        let shared = differing.div_ceil(3).max(1) - 1;
        shared.max(self.end).min(depth - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil_math::morton_cell;
    use proptest::prelude::*;

    fn codes(depth: u32) -> impl Strategy<Value = Vec<u32>> {
        prop::collection::btree_set(0..1u32 << (3 * depth), 0..200)
            .prop_map(|set| set.into_iter().collect())
    }

    proptest! {
        #[test]
        fn every_brick_is_found_and_nothing_else(all in codes(4), probes in prop::collection::vec(0..1u32 << 12, 64)) {
            let tree = OctreeNodes::from_codes(all.clone(), 4);
            let mut path = DescentPath::recording();
            for code in all.iter().chain(&probes) {
                let cell = morton_cell(*code);
                let expected = all.binary_search(code).ok().map(|i| i as u32);
                let from_root = tree.find(cell);
                prop_assert_eq!(from_root.brick, expected);
                let from_path = tree.find_from(cell, &mut path);
                prop_assert_eq!(from_path.brick, expected);
                prop_assert!(from_path.nodes <= from_root.nodes);
            }
        }

        #[test]
        fn nodes_hold_their_children_and_none_is_an_orphan(all in codes(3)) {
            let tree = OctreeNodes::from_codes(all.clone(), 3);
            prop_assert_eq!(tree.levels().len(), 3);
            let ends = tree.levels().iter().skip(1).copied().chain([tree.nodes().len() as u32]);
            let mut below = all.len() as u32;
            for (level, (&begin, end)) in tree.levels().iter().zip(ends).enumerate() {
                let mut next = 0;
                for node in &tree.nodes()[begin as usize..end as usize] {
                    // Children follow one another without a gap, so each has exactly one parent.
                    prop_assert_eq!(node.child_offset, next);
                    prop_assert!(node.valid_mask != 0 && node.valid_mask < 256);
                    prop_assert_eq!(node.leaf_mask, if level == 0 { node.valid_mask } else { 0 });
                    next += node.valid_mask.count_ones();
                }
                prop_assert_eq!(next, below);
                below = end - begin;
            }
            prop_assert_eq!(below, u32::from(!all.is_empty()));
        }
    }

    #[test]
    fn an_empty_tree_finds_nothing() {
        let tree = OctreeNodes::from_codes(Vec::new(), 3);
        assert_eq!(tree.nodes().len(), 0);
        assert_eq!(tree.find(UVec3::ZERO).brick, None);
    }
}
