//! Subtrees of implicit tiling: which tiles and contents there are, one bit each
//! (<https://docs.ogc.org/cs/22-025r4/22-025r4.html#implicittiling-subtree-file-format>).

use rustc_hash::{FxHashMap, FxHashSet};
use serde_json::{Value, json};

/// Levels of a subtree.
pub(super) const SUBTREE_LEVELS: u32 = 4;

/// The place of a tile: its level, from 0 at the root, and its position in tiles of that level.
pub(super) type Place = (u32, [u32; 3]);

/// Which tiles there are.
#[derive(Debug, Default)]
pub(super) struct Availability {
    pub tiles: FxHashSet<Place>,
    pub contents: FxHashSet<Place>,
}

impl Availability {
    /// Adds a tile and all above it.
    pub(super) fn add(&mut self, (level, place): Place, has_content: bool) {
        if has_content {
            self.contents.insert((level, place));
        }
        for up in 0..=level {
            if !self.tiles.insert((level - up, place.map(|c| c >> up))) {
                break;
            }
        }
    }

    /// Returns all subtrees with the places of their roots.
    pub(super) fn subtrees(&self) -> FxHashMap<Place, Vec<u8>> {
        let roots = self
            .tiles
            .iter()
            .filter(|tile| tile.0.is_multiple_of(SUBTREE_LEVELS));
        roots.map(|&root| (root, self.subtree(root))).collect()
    }

    fn subtree(&self, root: Place) -> Vec<u8> {
        let mut tiles = Bits::default();
        let mut contents = Bits::default();
        for level in 0..SUBTREE_LEVELS {
            for place in below(root, level) {
                tiles.push(self.tiles.contains(&place));
                contents.push(self.contents.contains(&place));
            }
        }
        let mut children = Bits::default();
        for place in below(root, SUBTREE_LEVELS) {
            children.push(self.tiles.contains(&place));
        }
        let mut binary = Vec::new();
        let mut views: Vec<Value> = Vec::new();
        let mut describe = |bits: &Bits| {
            if bits.set == 0 || bits.set == bits.count {
                return json!({"constant": u32::from(bits.set > 0)});
            }
            views.push(
                json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": bits.bytes.len()}),
            );
            binary.extend_from_slice(&bits.bytes);
            binary.resize(binary.len().next_multiple_of(8), 0);
            json!({"bitstream": views.len() - 1, "availableCount": bits.set})
        };
        let mut text = json!({
            "tileAvailability": describe(&tiles),
            "contentAvailability": [describe(&contents)],
            "childSubtreeAvailability": describe(&children),
        });
        if !views.is_empty() {
            text["buffers"] = json!([{"byteLength": binary.len()}]);
            text["bufferViews"] = views.into();
        }
        let mut text = text.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(8), b' ');
        let mut out = Vec::new();
        out.extend_from_slice(b"subt");
        out.extend_from_slice(&1u32.to_le_bytes());
        out.extend_from_slice(&(text.len() as u64).to_le_bytes());
        out.extend_from_slice(&(binary.len() as u64).to_le_bytes());
        out.extend_from_slice(&text);
        out.extend_from_slice(&binary);
        out
    }
}

/// Returns the places some levels below a tile, along the Morton curve.
fn below((level, place): Place, levels: u32) -> impl Iterator<Item = Place> {
    (0..1u32 << (3 * levels)).map(move |code| {
        let mut inner = [0; 3];
        for bit in 0..levels {
            for (axis, coordinate) in inner.iter_mut().enumerate() {
                *coordinate |= (code >> (3 * bit + axis as u32) & 1) << bit;
            }
        }
        let finer = [0, 1, 2].map(|axis| (place[axis] << levels) + inner[axis]);
        (level + levels, finer)
    })
}

#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    count: u32,
    set: u32,
}

impl Bits {
    fn push(&mut self, bit: bool) {
        if self.count.is_multiple_of(8) {
            self.bytes.push(0);
        }
        if let Some(last) = self.bytes.last_mut() {
            *last |= u8::from(bit) << (self.count % 8);
        }
        self.count += 1;
        self.set += u32::from(bit);
    }
}
