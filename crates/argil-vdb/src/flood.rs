//! Signs of tiles and of inactive voxels.

use crate::{Leaf, Lower, RootTile, Tree, Upper, Voxel};
use rayon::prelude::*;
use std::collections::HashSet;

impl<V: Voxel> Tree<V> {
    /// Gives tiles and inactive voxels the background with the sign of the nearest value before them, along z, then y,
    /// then x: positive outside of a closed level set, and negative inside. Active voxels and active tiles stay.
    ///
    /// This is the signed flood fill of Museth, "VDB" (2013), section 4.5.
    pub fn flood_signs(&mut self) {
        let background = self.background;
        self.uppers
            .par_iter_mut()
            .flat_map(|upper| upper.lowers.par_iter_mut())
            .for_each(|lower| {
                for leaf in &mut lower.leaves {
                    flood_leaf(leaf, background);
                }
                flood_lower(lower, background);
            });
        for upper in &mut self.uppers {
            flood_upper(upper, background);
        }
        self.flood_root();
    }

    /// Fills between upper nodes of one column along z.
    fn flood_root(&mut self) {
        let mut filled = Vec::new();
        let known: HashSet<[i32; 3]> = self.tiles.iter().map(|tile| tile.origin).collect();
        for pair in self.uppers.windows(2) {
            let [low, high] = [&pair[0], &pair[1]];
            let is_column = low.origin[..2] == high.origin[..2];
            if !is_column
                || !last_of_upper(low).is_negative()
                || !first_of_upper(high).is_negative()
            {
                continue;
            }
            let mut z = low.origin[2] + 4096;
            while z < high.origin[2] {
                let origin = [low.origin[0], low.origin[1], z];
                if !known.contains(&origin) {
                    filled.push(RootTile {
                        origin,
                        value: self.background.negated(),
                        is_active: false,
                    });
                }
                z += 4096;
            }
        }
        self.tiles.extend(filled);
        self.tiles.sort_by_key(|tile| tile.origin);
    }
}

fn signed<V: Voxel>(background: V, is_inside: bool) -> V {
    if is_inside {
        background.negated()
    } else {
        background
    }
}

/// Goes through the places of a node along z, then y, then x. `side` is their number along an axis. `known` returns the
/// sign at the end of a place, and `fill` sets an unknown one.
fn flood(
    side: usize,
    first: bool,
    mut known: impl FnMut(usize) -> Option<bool>,
    mut fill: impl FnMut(usize, bool),
) {
    let mut along_x = first;
    for x in 0..side {
        let at = x * side * side;
        along_x = known(at).unwrap_or(along_x);
        let mut along_y = along_x;
        for y in 0..side {
            let at = at + y * side;
            along_y = known(at).unwrap_or(along_y);
            let mut along_z = along_y;
            for z in 0..side {
                let at = at + z;
                match known(at) {
                    Some(value) => along_z = value,
                    None => fill(at, along_z),
                }
            }
        }
    }
}

fn flood_leaf<V: Voxel>(leaf: &mut Leaf<V>, background: V) {
    let Some(first) = leaf.active.places().next() else {
        let is_inside = leaf.values[0].is_negative();
        leaf.values.fill(signed(background, is_inside));
        return;
    };
    let [inside, outside] = [true, false].map(|is| signed(background, is));
    let mut along_x = leaf.values[first].is_negative();
    for (word, layer) in leaf
        .active
        .0
        .iter()
        .zip(leaf.values.as_chunks_mut::<64>().0)
    {
        if *word == u64::MAX {
            along_x = layer[0].is_negative();
            continue;
        }
        if word & 1 != 0 {
            along_x = layer[0].is_negative();
        }
        let mut along_y = along_x;
        for (y, row) in layer.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            let active = word >> (8 * y) & 0xff;
            if active & 1 != 0 {
                along_y = row[0].is_negative();
            }
            let mut along_z = along_y;
            for (z, value) in row.iter_mut().enumerate() {
                if active >> z & 1 != 0 {
                    along_z = value.is_negative();
                } else {
                    *value = if along_z { inside } else { outside };
                }
            }
        }
    }
}

fn flood_lower<V: Voxel>(lower: &mut Lower<V>, background: V) {
    let Lower {
        children,
        active,
        tiles,
        leaves,
        ..
    } = lower;
    let ends: Vec<bool> = leaves
        .iter()
        .map(|leaf| leaf.values[511].is_negative())
        .collect();
    let begin = leaves.first().map(|leaf| leaf.values[0].is_negative());
    fill_tiles(16, (children, active), tiles, &ends, begin, background);
}

fn flood_upper<V: Voxel>(upper: &mut Upper<V>, background: V) {
    let ends: Vec<bool> = upper
        .lowers
        .iter()
        .map(|l| last_of_lower(l).is_negative())
        .collect();
    let begin = upper
        .lowers
        .first()
        .map(|l| first_of_lower(l).is_negative());
    let masks = (&upper.children, &upper.active);
    fill_tiles(32, masks, &mut upper.tiles, &ends, begin, background);
}

fn fill_tiles<V: Voxel, const N: usize>(
    side: usize,
    (children, active): (&crate::Mask<N>, &crate::Mask<N>),
    tiles: &mut [V],
    ends: &[bool],
    begin: Option<bool>,
    background: V,
) {
    // The sign at the end of each place with a child or an active tile.
    let mut known = vec![None; tiles.len()];
    for (place, &end) in children.places().zip(ends) {
        known[place] = Some(end);
    }
    for place in active.places() {
        known[place] = Some(tiles[place].is_negative());
    }
    let begin = begin.or_else(|| known.iter().flatten().next().copied());
    let begin = begin.unwrap_or_else(|| tiles[0].is_negative());
    flood(
        side,
        begin,
        |at| known[at],
        |at, is_inside| tiles[at] = signed(background, is_inside),
    );
}

fn first_of_lower<V: Voxel>(lower: &Lower<V>) -> V {
    match lower.children.is_on(0) {
        true => lower
            .leaves
            .first()
            .map_or(lower.tiles[0], |leaf| leaf.values[0]),
        false => lower.tiles[0],
    }
}

fn last_of_lower<V: Voxel>(lower: &Lower<V>) -> V {
    match lower.children.is_on(4095) {
        true => lower
            .leaves
            .last()
            .map_or(lower.tiles[4095], |leaf| leaf.values[511]),
        false => lower.tiles[4095],
    }
}

fn first_of_upper<V: Voxel>(upper: &Upper<V>) -> V {
    match upper.children.is_on(0) {
        true => upper.lowers.first().map_or(upper.tiles[0], first_of_lower),
        false => upper.tiles[0],
    }
}

fn last_of_upper<V: Voxel>(upper: &Upper<V>) -> V {
    match upper.children.is_on(32767) {
        true => upper
            .lowers
            .last()
            .map_or(upper.tiles[32767], last_of_lower),
        false => upper.tiles[32767],
    }
}
