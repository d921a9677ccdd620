//! The table of a scene's materials and their textures.
//!
//! *Practice.* Materials come first. If any has textures, an entry whose roughness is −1 follows, and then each one's
//! record: an entry with the places of its four textures, or 0, and two entries for each of these: see
//! [`textures`](crate::textures). The texels of images come last, three bytes each, as one number.

use crate::lower::LowerError;
use crate::texture_patterns::{ENTRY as WORDS, KIND_IMAGE};
use crate::textures::{CHANNELS, packed_texel, texture_words};
use argil_abi::GpuMaterial;
use argil_scene::{Material, Pattern, Scene, SceneImage, Textures};
use std::collections::HashMap;
use std::sync::Arc;

/// The most texels of all images.
const MAX_TEXELS: usize = 1 << 26;

/// Materials and textures, as interpreters read them.
#[derive(Clone, Debug, Default)]
pub(crate) struct MaterialTable {
    pub entries: Vec<GpuMaterial>,
    /// Number of materials. The rest are textures.
    pub materials: usize,
    /// Properties besides those of an entry: see [`Program::appearances`](crate::Program). Empty if no material has any.
    pub extras: Vec<[f32; 4]>,
    /// A length over which heights of surfaces differ. 0 if no texture has heights.
    pub bump_step: f32,
    /// Whether a material lets light through.
    pub has_glass: bool,
}

/// The extras of most materials.
const PLAIN: [f32; 4] = [0.0, Material::REFRACTIVE_INDEX, 0.0, 0.0];

/// What a material has besides the words of an entry: transmission, the index of refraction, 1 / attenuation distance, and
/// height.
fn extras_of(m: &Material) -> [f32; 4] {
    let density = if m.attenuation_distance > 0.0 {
        1.0 / m.attenuation_distance
    } else {
        0.0
    };
    [m.transmission, m.refractive_index, density, 0.0]
}

/// Returns the materials of a scene: the default one, and then all by name.
fn all_of(scene: &Scene) -> impl Iterator<Item = (&str, Option<&Material>)> {
    let all = scene.materials().iter();
    std::iter::once(("", None)).chain(all.map(|(name, material)| (name.as_str(), Some(material))))
}

fn textures_of(material: Option<&Material>) -> Option<&Textures> {
    let textures = material?.textures.as_deref()?;
    (!textures.is_empty()).then_some(textures)
}

/// Returns the place of each material's record in the table, or 0.
pub(crate) fn texture_places(scene: &Scene) -> Vec<u32> {
    let mut next = scene.materials().len() as u32 + 2;
    let place = |(_, material)| {
        let Some(textures) = textures_of(material) else {
            return 0;
        };
        let first = next;
        next += 1 + 2 * textures.patterns().count() as u32;
        first
    };
    all_of(scene).map(place).collect()
}

impl MaterialTable {
    /// A table without anything, not even the default material.
    pub(crate) const BLANK: Self = Self {
        entries: Vec::new(),
        materials: 0,
        extras: Vec::new(),
        bump_step: 0.0,
        has_glass: false,
    };

    /// Whether textures follow the materials.
    pub(crate) fn has_textures(&self) -> bool {
        self.entries.len() > self.materials
    }

    /// Returns the properties of a material: base color, roughness, emission, metalness, and its extras.
    #[inline]
    pub(crate) fn appearance(&self, index: usize) -> [f32; 12] {
        let entry = &self.entries[index];
        let extras = self.extras.get(index).copied().unwrap_or(PLAIN);
        let mut all = [0.0; 12];
        all[..4].copy_from_slice(&entry.base_roughness);
        all[4..8].copy_from_slice(&entry.emission_metallic);
        all[8..].copy_from_slice(&extras);
        all
    }

    /// Returns extras in the form of entries: see [`Program::material_extras`](crate::Program::material_extras).
    pub(crate) fn extras_as_entries(&self) -> Vec<GpuMaterial> {
        if !self.has_glass && self.bump_step == 0.0 {
            return Vec::new();
        }
        let entries = self.entries.iter().zip(&self.extras);
        entries
            .map(|(entry, &extras)| GpuMaterial {
                base_roughness: extras,
                emission_metallic: [0.0, 0.0, 0.0, entry.emission_metallic[3]],
            })
            .collect()
    }

    /// Returns how many properties differ between materials, of 8 or 12.
    #[inline]
    pub(crate) fn properties(&self) -> usize {
        if self.extras.is_empty() { 8 } else { 12 }
    }

    /// Creates the table of a scene.
    ///
    /// # Errors
    /// If an image is not loaded, or images are too large together.
    pub(crate) fn of(scene: &Scene) -> Result<Self, LowerError> {
        let default = Material::default();
        let words_and_extras = |(_, material): (&str, Option<&Material>)| {
            let material = material.unwrap_or(&default);
            (words_of(material), extras_of(material))
        };
        let (mut entries, mut extras): (Vec<_>, Vec<_>) =
            all_of(scene).map(words_and_extras).unzip();
        let materials = entries.len();
        let places = texture_places(scene);
        let has_textures = places.iter().any(|&place| place != 0);
        let mut bump_step = f32::INFINITY;
        for bump in all_of(scene)
            .filter_map(|(_, listed)| textures_of(listed))
            .filter_map(|textures| textures.bump.as_ref())
        {
            bump_step = bump_step.min(BUMP_STEP * bump.size);
        }
        if extras.iter().all(|extra| *extra == PLAIN) && bump_step == f32::INFINITY {
            extras.clear();
        }
        if has_textures {
            let mut words = vec![0.0; WORDS];
            words[3] = -1.0;
            let mut images = Images::default();
            for (name, material) in all_of(scene) {
                if let Some(textures) = textures_of(material) {
                    let at = materials + words.len() / WORDS;
                    record(name, textures, at, &mut words, &mut images)?;
                }
            }
            images.write(materials, &mut words);
            words.resize(words.len().next_multiple_of(WORDS), 0.0);
            entries.extend_from_slice(bytemuck::cast_slice::<f32, GpuMaterial>(&words));
        }
        Ok(Self {
            has_glass: extras.iter().any(|extra| extra[0] > 0.0),
            entries,
            materials,
            extras,
            bump_step: if bump_step.is_finite() {
                bump_step
            } else {
                0.0
            },
        })
    }
}

/// Heights are compared over this part of a pattern's length.
const BUMP_STEP: f32 = 1.0 / 512.0;

/// Images of a table, each once, and the words that will tell where they begin.
#[derive(Default)]
struct Images {
    all: Vec<Arc<SceneImage>>,
    of_file: HashMap<String, usize>,
    uses: Vec<(usize, usize)>,
    texels: usize,
}

impl Images {
    /// Writes texels behind all records.
    fn write(&self, first_entry: usize, words: &mut Vec<f32>) {
        let mut places = Vec::new();
        for image in &self.all {
            words.resize(words.len().next_multiple_of(WORDS), 0.0);
            places.push(first_entry + words.len() / WORDS);
            words.extend(image.pixels.iter().map(packed_texel));
        }
        for &(word, image) in &self.uses {
            words[word] = places[image] as f32;
        }
    }
}

/// Appends a material's record, which begins at an entry of the table.
fn record(
    name: &str,
    textures: &Textures,
    at: usize,
    words: &mut Vec<f32>,
    images: &mut Images,
) -> Result<(), LowerError> {
    let header = words.len();
    words.resize(header + WORDS, 0.0);
    let mut next = at + 1;
    for channel in 0..CHANNELS {
        let Some((texture, pattern)) = texture_words(textures, channel) else {
            continue;
        };
        words[header + channel] = next as f32;
        next += 2;
        let begin = words.len();
        words.extend(texture);
        let Pattern::Image { path, image, .. } = pattern else {
            continue;
        };
        let Some(loaded) = &image.0 else {
            return Err(LowerError::ImageNotLoaded {
                material: name.into(),
                file: path.clone(),
            });
        };
        let index = *images.of_file.entry(path.clone()).or_insert_with(|| {
            images.texels += loaded.pixels.len();
            images.all.push(loaded.clone());
            images.all.len() - 1
        });
        if images.texels > MAX_TEXELS {
            return Err(LowerError::ImagesTooLarge {
                material: name.into(),
                file: path.clone(),
                limit: MAX_TEXELS,
            });
        }
        let texture = &mut words[begin..];
        debug_assert_eq!(texture[0], KIND_IMAGE);
        [texture[11], texture[12]] = loaded.size.map(|side| side as f32);
        images.uses.push((begin + 7, index));
    }
    Ok(())
}

fn words_of(m: &Material) -> GpuMaterial {
    let ([r, g, b], [er, eg, eb]) = (m.base_color, m.emission);
    GpuMaterial {
        base_roughness: [r, g, b, m.roughness],
        emission_metallic: [er, eg, eb, m.metallic],
    }
}
