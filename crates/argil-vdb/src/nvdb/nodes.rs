//! The bytes of nodes.

use super::NanoType;
use super::bytes::Bytes;
use super::layout::{Inner, LOWER, UPPER};
use super::statistics::{ValueStatistics, of_leaf};
use crate::{Leaf, Lower, Mask, Upper};

/// The parts of an inner node.
struct InnerNode<'a, const N: usize> {
    layout: &'a Inner,
    origin: [i32; 3],
    children: &'a Mask<N>,
    active: &'a Mask<N>,
    tiles: &'a [f32],
    /// The offset of the first child, and how far the next is.
    child: u64,
    step: usize,
    statistics: &'a ValueStatistics,
}

impl<const N: usize> InnerNode<'_, N> {
    fn bytes(&self) -> Vec<u8> {
        let mut out = Bytes(Vec::with_capacity(self.layout.bytes()));
        let is_empty = self.statistics.is_empty();
        let bounds = match is_empty {
            true => [self.origin, self.origin],
            false => self.statistics.bounds,
        };
        out.ints(bounds.as_flattened());
        // Bit 0: nothing to see. Bit 1: it has a box.
        out.u64(if is_empty { 1 } else { 2 });
        self.active.write(&mut out.0);
        self.children.write(&mut out.0);
        out.floats(&self.statistics.four(self.tiles[0]));
        out.0.resize(self.layout.table(), 0);
        let mut child = self.child;
        for (place, &tile) in self.tiles.iter().enumerate() {
            if self.children.is_on(place) {
                out.u64(child);
                child += self.step as u64;
            } else {
                out.float(tile).u32(0);
            }
        }
        out.0
    }
}

pub(super) fn upper_bytes(upper: &Upper<f32>, child: u64, statistics: &ValueStatistics) -> Vec<u8> {
    let node = InnerNode {
        layout: &UPPER,
        origin: upper.origin,
        children: &upper.children,
        active: &upper.active,
        tiles: &upper.tiles,
        child,
        step: LOWER.bytes(),
        statistics,
    };
    node.bytes()
}

pub(super) fn lower_bytes(
    lower: &Lower<f32>,
    child: u64,
    step: usize,
    statistics: &ValueStatistics,
) -> Vec<u8> {
    let node = InnerNode {
        layout: &LOWER,
        origin: lower.origin,
        children: &lower.children,
        active: &lower.active,
        tiles: &lower.tiles,
        child,
        step,
        statistics,
    };
    node.bytes()
}

pub(super) fn leaf_bytes_of(leaf: &Leaf<f32>, kind: NanoType) -> Vec<u8> {
    let mut out = Bytes(Vec::with_capacity(kind.leaf_bytes()));
    let statistics = of_leaf(leaf);
    let is_empty = statistics.is_empty();
    let [low, high] = match is_empty {
        true => [leaf.origin; 2],
        false => statistics.bounds,
    };
    out.ints(&low);
    out.0
        .extend([0, 1, 2].map(|axis| high[axis].wrapping_sub(low[axis]) as u8));
    out.0.push(if is_empty { 1 } else { 2 });
    leaf.active.write(&mut out.0);
    let four = statistics.four(leaf.values[0]);
    if kind == NanoType::Float {
        out.floats(&four).floats(leaf.values.as_slice());
        return out.0;
    }
    let least = leaf.values.iter().copied().fold(f32::INFINITY, f32::min);
    let most = leaf
        .values
        .iter()
        .copied()
        .fold(f32::NEG_INFINITY, f32::max);
    let quantum = (most - least) / kind.largest_code();
    let inverse = if quantum > 0.0 { 1.0 / quantum } else { 0.0 };
    let code = |value: f32, largest: f32| {
        ((value - least) * inverse + 0.5)
            .floor()
            .clamp(0.0, largest)
    };
    out.float(least).float(quantum);
    let [low, high, mean, deviation] = four;
    let deviation = (deviation * inverse + 0.5).floor().clamp(0.0, 65_535.0);
    for quantized in [low, high, mean]
        .map(|value| code(value, 65_535.0))
        .into_iter()
        .chain([deviation])
    {
        out.0.extend((quantized as u16).to_le_bytes());
    }
    let largest = kind.largest_code();
    for &value in leaf.values.iter() {
        let code = code(value, largest);
        match kind {
            NanoType::Fp8 => out.0.push(code as u8),
            _ => out.0.extend((code as u16).to_le_bytes()),
        }
    }
    out.0
}
