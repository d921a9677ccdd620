//! Reads valid files with all cores. [`super::read`] reads the others, and reports what is wrong.
//!
//! *Practice.* serde_json splits the document into the texts of its items, and each item into the texts of its
//! fields. Many items are then parsed at once, each field by the same call as in [`super::read`]. So both accept
//! the same files. Groups nested deeper than [`MAX_LEVELS`] are left to the other reader, because each level is
//! split once more.

use super::error::{FORMAT_VERSION, MAX_PART_BYTES};
use crate::{Group, Material, NodeDesc, NodeId, NodeKind, Scene, View};
use rayon::prelude::*;
use serde::de::{DeserializeOwned, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;
use std::fmt;
use std::marker::PhantomData;

/// Maximum levels of groups.
const MAX_LEVELS: usize = 16;

/// Items that are parsed before the first one enters the scene.
const ITEMS_AT_ONCE: usize = 4096;

/// Fewer items than this are not worth another thread.
const FEW_ITEMS: usize = 64;

/// Reads a scene, or returns `None` if the other reader must look at the text.
pub(super) fn read(text: &[u8]) -> Option<Scene> {
    let text = text
        .strip_prefix(super::tokens::BYTE_ORDER_MARK)
        .unwrap_or(text);
    let fields: Members<'_, String> = serde_json::from_slice(text).ok()?;
    let mut scene = Scene::new();
    let mut seen: Vec<String> = Vec::new();
    let (mut has_version, mut items) = (false, None);
    for (field, value) in fields.0 {
        if seen.contains(&field) {
            return None;
        }
        match field.as_str() {
            "$schema" => drop(part::<String>(value)?),
            "argil" => has_version = (1..=FORMAT_VERSION).contains(&part(value)?),
            "name" => scene.name = part(value)?,
            "credit" => scene.credit = part(value)?,
            "view" => {
                scene.view = part::<View>(value)?;
                scene.view.check().ok()?;
            }
            "materials" => materials(&mut scene, value)?,
            // They name materials, which can come later.
            "brushes" => items = Some(value),
            _ => return None,
        }
        seen.push(field);
    }
    brushes(&mut scene, items?)?;
    has_version.then_some(scene)
}

fn materials(scene: &mut Scene, all: &RawValue) -> Option<()> {
    let all: Members<'_, String> = serde_json::from_slice(all.get().as_bytes()).ok()?;
    for (name, material) in all.0 {
        if name.len() > MAX_PART_BYTES || scene.materials.contains_key(&name) {
            return None;
        }
        let material: Material = part(material)?;
        scene.set_material(name, material).ok()?;
    }
    Some(())
}

fn brushes(scene: &mut Scene, items: &RawValue) -> Option<()> {
    let mut open = vec![Level::new(Scene::ROOT, items)?];
    while let Some(level) = open.last_mut() {
        let Some(item) = level.next(scene)? else {
            open.pop();
            continue;
        };
        let node = scene.append(level.group, item.entry);
        if let Some(inner) = item.brushes {
            if open.len() == MAX_LEVELS {
                return None;
            }
            open.push(Level::new(node, inner)?);
        }
    }
    Some(())
}

/// A group's items, some of which have been read.
struct Level<'a> {
    group: NodeId,
    unread: std::vec::IntoIter<&'a RawValue>,
    read: std::vec::IntoIter<ReadItem<'a>>,
}

struct ReadItem<'a> {
    entry: NodeDesc,
    brushes: Option<&'a RawValue>,
}

impl<'a> Level<'a> {
    fn new(group: NodeId, items: &'a RawValue) -> Option<Self> {
        let unread: Vec<&RawValue> = serde_json::from_slice(items.get().as_bytes()).ok()?;
        Some(Self {
            group,
            unread: unread.into_iter(),
            read: Vec::new().into_iter(),
        })
    }

    /// Returns the next item, `Some(None)` at the end, and `None` if an item is invalid.
    fn next(&mut self, scene: &Scene) -> Option<Option<ReadItem<'a>>> {
        if let Some(item) = self.read.next() {
            return Some(Some(item));
        }
        let texts: Vec<&RawValue> = self.unread.by_ref().take(ITEMS_AT_ONCE).collect();
        let items: Option<Vec<ReadItem<'_>>> = if texts.len() < FEW_ITEMS {
            texts.iter().map(|text| item(scene, text)).collect()
        } else {
            texts.par_iter().map(|text| item(scene, text)).collect()
        };
        self.read = items?.into_iter();
        Some(self.read.next())
    }
}

fn item<'a>(scene: &Scene, text: &'a RawValue) -> Option<ReadItem<'a>> {
    let fields: Members<'_, Field> = serde_json::from_slice(text.get().as_bytes()).ok()?;
    let mut entry: NodeDesc = Group::new().into();
    let (mut has_shape, mut brushes) = (false, None);
    let mut seen = 0u32;
    for (field, value) in fields.0 {
        let bit = 1 << field as u32;
        if seen & bit != 0 {
            return None;
        }
        seen |= bit;
        match field {
            Field::Name => entry.name = part(value)?,
            Field::Visible => entry.visible = part(value)?,
            Field::Locked => entry.locked = part(value)?,
            Field::Operator => entry.operator.kind = part(value)?,
            Field::Blend => entry.operator.blend = part(value)?,
            Field::Profile => entry.operator.profile = part(value)?,
            Field::Amount => entry.operator.morph_amount = part(value)?,
            Field::Ramp => entry.ramp = Some(part(value)?),
            Field::Material => entry.material = Some(part(value)?),
            Field::Modifiers => entry.modifiers = part(value)?,
            Field::Keyframes => entry.keyframes = part(value)?,
            Field::Shape => {
                entry.kind = NodeKind::Shape(part(value)?);
                has_shape = true;
            }
            Field::Brushes => brushes = Some(value),
        }
    }
    scene.check_entry(&entry).ok()?;
    (has_shape != brushes.is_some()).then_some(ReadItem { entry, brushes })
}

/// Parses a value, up to the length that the other reader accepts.
fn part<T: DeserializeOwned>(text: &RawValue) -> Option<T> {
    let text = text.get();
    if text.len() > MAX_PART_BYTES {
        return None;
    }
    // From bytes, as everywhere here, so that the parser is compiled once.
    serde_json::from_slice(text.as_bytes()).ok()
}

/// The fields of an item.
#[derive(Clone, Copy, Deserialize)]
#[serde(field_identifier, rename_all = "lowercase")]
enum Field {
    Name,
    Visible,
    Locked,
    Operator,
    Blend,
    Profile,
    Amount,
    Ramp,
    Material,
    Modifiers,
    Keyframes,
    Shape,
    Brushes,
}

/// The members of an object with the texts of their values, in file order. A name may appear twice.
struct Members<'a, K>(Vec<(K, &'a RawValue)>);

impl<'de, K: Deserialize<'de>> Deserialize<'de> for Members<'de, K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader<K>(PhantomData<K>);
        impl<'de, K: Deserialize<'de>> Visitor<'de> for Reader<K> {
            type Value = Members<'de, K>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut all = Vec::with_capacity(4);
                while let Some(member) = map.next_entry()? {
                    all.push(member);
                }
                Ok(Members(all))
            }
        }
        deserializer.deserialize_map(Reader(PhantomData))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn streamed(text: &[u8]) -> Option<Scene> {
        super::super::read::read(Path::new("test"), Box::new(text), &|| Ok(Box::new(text))).ok()
    }

    /// Both readers take the same texts, and make the same scene of one.
    fn agree(text: &[u8]) -> bool {
        let (quick, streamed) = (read(text), streamed(text));
        assert!(
            quick == streamed,
            "read otherwise at once ({}) than as a stream ({}): {}",
            quick.is_some(),
            streamed.is_some(),
            String::from_utf8_lossy(text),
        );
        quick.is_some()
    }

    const SCENE: &str = r#"{"argil": 1, "name": "a \"b\"", "credit": "c", "view": {"ground": true},
        "materials": {"red": {"base_color": [1, 0, 0]}, "blue": {"roughness": 0.5}}, "brushes": [
        {"shape": {"type": "sphere", "radius": 0.5}, "material": "red", "name": "é", "visible": false},
        {"brushes": [{"shape": {"type": "box", "half_size": [1, 2, 3]}, "operator": "subtract", "blend": 0.1},
        {"brushes": [], "locked": true}], "modifiers": [{"type": "translate", "by": [1, 2, 3e-1]}]},
        {"shape": {"type": "torus", "major_radius": 1.0, "minor_radius": 0.25}, "operator": "morph", "amount": 0.5,
        "keyframes": [{"time": 0, "translate": [0, 1, 0]}]}]}"#;

    #[test]
    fn it_takes_what_the_other_reader_takes() {
        for text in [
            "{\"argil\": 1, \"brushes\": []}",
            "\u{feff}{\"argil\": 1, \"brushes\": []}\n\n",
            "{\"$schema\": \"argil.schema.json\", \"argil\": 1, \"brushes\": []}",
            "{\"brushes\": [{\"brushes\": [], \"material\": \"a\"}], \"argil\": 1, \"materials\": {\"a\": {}}, \"$schema\": \"\"}",
        ] {
            assert!(agree(text.as_bytes()), "{text}");
        }
        for text in [
            "{\"brushes\": []}",
            "{\"$schema\": 1, \"argil\": 1, \"brushes\": []}",
            "{\"argil\": 2, \"brushes\": []}",
            "{\"argil\": 1.0, \"brushes\": []}",
            "{\"argil\": 1}",
            "{\"argil\": 1, \"brushes\": null}",
            "{\"argil\": 1, \"brushes\": [], \"brushes\": []}",
            "{\"argil\": 1, \"brushes\": [{}]}",
            "{\"argil\": 1, \"brushes\": [{\"brushes\": [], \"brushes\": []}]}",
            "{\"argil\": 1, \"brushes\": [{\"brushes\": [], \"name\": null}]}",
            "{\"argil\": 1, \"brushes\": [{\"brushes\": [], \"material\": null}]}",
            "{\"argil\": 1, \"brushes\": [{\"brushes\": [], \"material\": \"none\"}]}",
            "{\"argil\": 1, \"brushes\": [{\"brushes\": [], \"blend\": -1}]}",
            "{\"argil\": 1, \"materials\": {\"a\": {}, \"a\": {}}, \"brushes\": []}",
            "{\"argil\": 1, \"brushes\": []}}",
            "",
        ] {
            assert!(!agree(text.as_bytes()), "{text}");
        }
    }

    #[test]
    fn it_takes_no_damaged_text_that_the_other_reader_refuses() {
        let tokens: Vec<&str> = SCENE
            .split_inclusive([',', ':', '{', '}', '[', ']'])
            .collect();
        let mut state = 7u64;
        let mut random = |below: usize| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        let mut taken = 0;
        for _ in 0..4000 {
            let mut words = tokens.clone();
            let at = random(words.len());
            let from = tokens[random(tokens.len())];
            match random(4) {
                0 => words[at] = from,
                1 => words.insert(at, from),
                2 => words.swap(at, random(tokens.len())),
                _ => drop(words.remove(at)),
            }
            taken += usize::from(agree(words.concat().as_bytes()));
        }
        assert!((20..3900).contains(&taken), "{taken} were scenes");
    }

    #[test]
    fn it_reads_the_order_of_groups() {
        let group = |inner: &str| format!("{{\"brushes\": [{inner}]}}");
        let sphere = "{\"shape\": {\"type\": \"sphere\", \"radius\": 1}}";
        let many = vec![sphere; 200].join(",");
        let inner = group(&format!("{many},{},{sphere}", group(sphere)));
        let text = format!("{{\"argil\": 1, \"brushes\": [{inner},{sphere}]}}");
        assert!(agree(text.as_bytes()));
        // Deeper than it looks: left to the other.
        let deep = (0..MAX_LEVELS + 1).fold(sphere.to_owned(), |inner, _| group(&inner));
        let text = format!("{{\"argil\": 1, \"brushes\": [{deep}]}}");
        assert!(read(text.as_bytes()).is_none() && streamed(text.as_bytes()).is_some());
    }
}
