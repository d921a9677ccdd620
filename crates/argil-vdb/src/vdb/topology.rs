//! Nodes in files: first the masks of all, then the leaves' values.

use super::bytes::{Reader, write_place};
use super::values::{Packing, Unpacking};
use crate::tree::{LEAF_SIZE, LOWER_SIZE, UPPER_SIZE, voxel_of};
use crate::{Leaf, Lower, Mask, Upper, VdbError, Voxel};
use rayon::prelude::*;

/// Lower nodes whose values are packed together before they are written.
const BATCH: usize = 32;

/// Returns tiles with zeros where children are, as readers expect.
fn without_children<V: Voxel, const N: usize>(tiles: &[V], children: &Mask<N>) -> Vec<V> {
    let mut cleared = tiles.to_vec();
    clear_children(&mut cleared, children);
    cleared
}

fn clear_children<V: Voxel, const N: usize>(tiles: &mut [V], children: &Mask<N>) {
    for place in children.places() {
        tiles[place] = V::default();
    }
}

/// Appends the masks and tiles of an upper node and all that it holds.
pub(super) fn write_upper<V: Voxel>(upper: &Upper<V>, packing: &Packing<V>, out: &mut Vec<u8>) {
    write_place(upper.origin, out);
    upper.children.write(out);
    upper.active.write(out);
    let tiles = without_children(&upper.tiles, &upper.children);
    packing.write(&tiles, &upper.active, &upper.children, out);
    for lower in &upper.lowers {
        lower.children.write(out);
        lower.active.write(out);
        let tiles = without_children(&lower.tiles, &lower.children);
        packing.write(&tiles, &lower.active, &lower.children, out);
        for leaf in &lower.leaves {
            leaf.active.write(out);
        }
    }
}

/// Packs the values of leaves, and hands the bytes over in order.
pub(super) fn write_leaves<V: Voxel>(
    upper: &Upper<V>,
    packing: &Packing<V>,
    write: &mut dyn FnMut(&[u8]) -> std::io::Result<()>,
) -> std::io::Result<()> {
    for lowers in upper.lowers.chunks(BATCH) {
        let packed: Vec<Vec<u8>> = lowers
            .par_iter()
            .flat_map(|lower| lower.leaves.par_chunks(256))
            .map(|leaves| {
                let mut out = Vec::with_capacity(leaves.len() * (LEAF_SIZE * V::BYTES / 2));
                for leaf in leaves {
                    leaf.active.write(&mut out);
                    let values = leaf.values.as_slice();
                    packing.write(values, &leaf.active, &Mask::default(), &mut out);
                }
                out
            })
            .collect();
        for bytes in packed {
            write(&bytes)?;
        }
    }
    Ok(())
}

/// Reads the masks and tiles of an upper node and all that it holds. Leaves have no values yet.
pub(super) fn read_upper<V: Voxel>(
    from: &mut Reader<'_>,
    unpacking: &Unpacking<V>,
) -> Result<Upper<V>, VdbError> {
    let what = "an upper node";
    let origin = from.place(what)?;
    if origin.iter().any(|c| c & 4095 != 0) {
        return Err(from.damaged(format!(
            "an upper node begins at {origin:?}, no multiples of 4096"
        )));
    }
    let children = from.mask::<512>(what)?;
    let active = from.mask::<512>(what)?;
    let mut tiles = vec![V::default(); UPPER_SIZE];
    unpacking.read(from, &active, &mut tiles)?;
    clear_children(&mut tiles, &children);
    let mut lowers = Vec::new();
    for place in children.places() {
        let origin = voxel_of(origin, place, 4096, 128);
        lowers.push(read_lower(from, unpacking, origin)?);
    }
    Ok(Upper {
        origin,
        children,
        active,
        tiles,
        lowers,
    })
}

fn read_lower<V: Voxel>(
    from: &mut Reader<'_>,
    unpacking: &Unpacking<V>,
    origin: [i32; 3],
) -> Result<Lower<V>, VdbError> {
    let what = "a lower node";
    let children = from.mask::<64>(what)?;
    let active = from.mask::<64>(what)?;
    let mut tiles = vec![V::default(); LOWER_SIZE];
    unpacking.read(from, &active, &mut tiles)?;
    clear_children(&mut tiles, &children);
    let mut leaves = Vec::new();
    for place in children.places() {
        leaves.push(Leaf {
            origin: voxel_of(origin, place, 128, 8),
            active: from.mask::<8>("a leaf")?,
            values: Box::new([V::default(); LEAF_SIZE]),
        });
    }
    Ok(Lower {
        origin,
        children,
        active,
        tiles,
        leaves,
    })
}

/// Reads the values of an upper node's leaves.
pub(super) fn read_leaves<V: Voxel>(
    from: &mut Reader<'_>,
    unpacking: &Unpacking<V>,
    upper: &mut Upper<V>,
) -> Result<(), VdbError> {
    for leaf in upper.lowers.iter_mut().flat_map(|lower| &mut lower.leaves) {
        leaf.active = from.mask::<8>("a leaf")?;
        unpacking.read(from, &leaf.active, leaf.values.as_mut_slice())?;
    }
    Ok(())
}
