//! The bytes of a tile.
//!
//! ```text
//!   head      magic, version, bits of a sample, tier, place; the world;
//!             of each level: pages, bricks, mixed bricks, bytes, checksum; the head's checksum
//!   levels    the coarsest first: kinds of all cells · words of cells without a brick · materials · mixed materials ·
//!             packed samples
//! ```
//!
//! All numbers are little-endian. Checksums are BLAKE3, the levels' cut to 16 bytes. So a reader needs the head only, and of the
//! levels those that it wants: each is as long as all coarser ones four times. Which pages there are follows from the kinds:
//! first the tile's own, then those of its cells with bricks that are not flat, level by level.

use super::codec::{BRICK_SAMPLES, MAX_BRICK_BYTES, Reader, pack, unpack};
use super::{CellKind, TIER_LEVELS, Tile, TileAddress, TilePage};
use crate::bricks::PLACES;
use crate::levels::LevelsLayout;
use crate::levels::page::octant_place;
use crate::{MISSING_BRICK, SampleFormat, center_of, empty_word};
use argil_abi::BRICK_MIXED;
use glam::IVec3;

const MAGIC: [u8; 8] = *b"ARGILTIL";
const VERSION: u32 = 2;
/// Bytes of what a head tells of a level, and of its checksum.
const SECTION: usize = 16 + CHECKSUM;
const CHECKSUM: usize = 16;
/// Bytes before the head's own checksum.
const FIELDS: usize = 8 + 4 * 6 + 32 + TIER_LEVELS as usize * SECTION;

/// The reason why bytes are not the tile that is wanted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TileError {
    /// It ends too early, or goes on too far.
    #[error("it has {found} bytes and should have {expected}")]
    Length {
        /// Bytes that there are.
        found: u64,
        /// Bytes that the head names, or that a head takes.
        expected: u64,
    },
    /// It is something else, or of another version.
    #[error("it is no tile of version {VERSION}")]
    Magic,
    /// It belongs to another world, or to another place.
    #[error("it is another tile: {0}")]
    Other(String),
    /// Its checksum is wrong.
    #[error("its checksum is wrong: the bytes are damaged")]
    Checksum,
    /// Its contents contradict each other, although the checksum is right.
    #[error("its contents are inconsistent: {0}")]
    Contents(&'static str),
}

/// What a head tells of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Section {
    pages: u32,
    bricks: u32,
    mixed: u32,
    bytes: u32,
    checksum: [u8; CHECKSUM],
}

/// The first bytes of a tile. They tell which of the others hold which level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileHead {
    address: TileAddress,
    format: SampleFormat,
    top_level: u32,
    /// Of each level, the coarsest first.
    sections: [Section; TIER_LEVELS as usize],
}

impl TileHead {
    /// Bytes of a head.
    pub const BYTES: usize = FIELDS + 32;

    /// Reads the head of a tile of a world. `bytes` can go on behind it.
    ///
    /// # Errors
    /// If the bytes are damaged, or are not that tile.
    pub fn from_bytes(
        bytes: &[u8],
        world: &[u8; 32],
        address: TileAddress,
        layout: &LevelsLayout,
    ) -> Result<Self, TileError> {
        let Some(head) = bytes.get(..Self::BYTES) else {
            return Err(TileError::Length {
                found: bytes.len() as u64,
                expected: Self::BYTES as u64,
            });
        };
        let mut fields = Reader(&head[8..FIELDS]);
        let mut word = || fields.word().unwrap_or_default();
        let (version, bits, tier) = (word(), word(), word());
        let place = [word(), word(), word()].map(|c| c as i32);
        if head[..8] != MAGIC || version != VERSION {
            return Err(TileError::Magic);
        }
        if blake3::hash(&head[..FIELDS]).as_bytes()[..] != head[FIELDS..] {
            return Err(TileError::Checksum);
        }
        if fields.take(32).unwrap_or_default() != world {
            return Err(TileError::Other("of another world".to_owned()));
        }
        let own = TileAddress { tier, place };
        if own != address {
            return Err(TileError::Other(format!("{own}, and not {address}")));
        }
        if !address.can_be_in(layout) {
            return Err(TileError::Contents("the place"));
        }
        let format = layout.level(0).encoding.format;
        if bits != bits_of(format) {
            return Err(TileError::Contents("the bits of a sample"));
        }
        let mut sections = [Section::default(); TIER_LEVELS as usize];
        for (index, section) in sections.iter_mut().enumerate() {
            let mut word = || fields.word().unwrap_or_default();
            let [pages, bricks, mixed, bytes] = [word(), word(), word(), word()];
            let checksum = fields.take(CHECKSUM).unwrap_or_default();
            *section = Section {
                pages,
                bricks,
                mixed,
                bytes,
                checksum: checksum.try_into().unwrap_or_default(),
            };
            if pages > 1 << (3 * index)
                || bricks > 8 * pages
                || mixed > bricks
                || (pages == 0) != (bytes == 0)
                || u64::from(bytes) > max_bytes(pages, bricks, mixed)
            {
                return Err(TileError::Contents("the counts"));
            }
        }
        Ok(Self {
            address,
            format,
            top_level: address.top_level(layout),
            sections,
        })
    }

    /// Returns the bytes of the tile with all levels.
    pub fn total_bytes(&self) -> u64 {
        self.bytes_to(0)
    }

    /// Returns the bytes of the tile as far as it holds a level and all coarser ones.
    pub fn bytes_to(&self, level: u32) -> u64 {
        let above = (self.top_level + 1).saturating_sub(level) as usize;
        let sections = &self.sections[..above.min(self.sections.len())];
        let levels: u64 = sections.iter().map(|own| u64::from(own.bytes)).sum();
        Self::BYTES as u64 + levels
    }
}

/// Returns the most bytes that a level with some pages, bricks and mixed bricks takes.
fn max_bytes(pages: u32, bricks: u32, mixed: u32) -> u64 {
    let [pages, bricks, mixed] = [pages, bricks, mixed].map(u64::from);
    let word = size_of::<u32>() as u64;
    let words = 8 * pages + bricks + 2 * PLACES as u64 * mixed;
    8 * pages + word * words + MAX_BRICK_BYTES as u64 * bricks
}

fn bits_of(format: SampleFormat) -> u32 {
    match format {
        SampleFormat::Snorm8 => 8,
        SampleFormat::Snorm16 => 16,
    }
}

impl Tile {
    /// Returns the tile as bytes: always the same for the same tile. `world` is the hash of what it is a part of.
    pub fn to_bytes(&self, world: &[u8; 32]) -> Vec<u8> {
        let mut out = Vec::with_capacity(TileHead::BYTES + self.texels.len());
        out.extend_from_slice(&MAGIC);
        let [x, y, z] = self.address.place.map(|c| c as u32);
        for word in [VERSION, bits_of(self.format), self.address.tier, x, y, z] {
            out.extend_from_slice(&word.to_le_bytes());
        }
        out.extend_from_slice(world);
        let mut at = out.len();
        out.resize(TileHead::BYTES, 0);
        for pages in self.pages.chunk_by(|a, b| a.level == b.level) {
            let begin = out.len();
            let [bricks, mixed] = self.write_level(pages, &mut out);
            let bytes = out.len() - begin;
            let checksum = blake3::hash(&out[begin..]);
            for count in [pages.len(), bricks, mixed, bytes] {
                out[at..at + 4].copy_from_slice(&(count as u32).to_le_bytes());
                at += 4;
            }
            out[at..at + CHECKSUM].copy_from_slice(&checksum.as_bytes()[..CHECKSUM]);
            at += CHECKSUM;
        }
        let checksum = blake3::hash(&out[..FIELDS]);
        out[FIELDS..TileHead::BYTES].copy_from_slice(checksum.as_bytes());
        out
    }

    /// Writes the pages of a level. Returns the number of their bricks and of the mixed ones.
    fn write_level(&self, pages: &[TilePage], out: &mut Vec<u8>) -> [usize; 2] {
        let (Some(first), Some(last)) = (pages.first(), pages.last()) else {
            return [0; 2];
        };
        for page in pages {
            out.extend(page.kinds.map(|kind| kind as u8));
        }
        for page in pages {
            for (kind, word) in page.kinds.iter().zip(page.words) {
                if !kind.has_brick() {
                    out.extend_from_slice(&word.to_le_bytes());
                }
            }
        }
        let begin = first.first_brick as usize;
        let end = last.first_brick as usize + last.brick_count();
        let materials = &self.materials[begin..end];
        let mixed = mixed_among(materials);
        let first_mixed = PLACES * first.first_mixed as usize;
        let mixtures = &self.mixed[first_mixed..first_mixed + PLACES * mixed];
        for word in materials.iter().chain(mixtures.as_flattened()) {
            out.extend_from_slice(&word.to_le_bytes());
        }
        pack(&self.texels.as_chunks().0[begin..end], out);
        [materials.len(), mixed]
    }

    /// Reads a tile of a world, with all its levels.
    ///
    /// # Errors
    /// If the bytes are damaged, or are not that tile.
    pub fn from_bytes(
        bytes: &[u8],
        world: &[u8; 32],
        address: TileAddress,
        layout: &LevelsLayout,
    ) -> Result<Self, TileError> {
        let head = TileHead::from_bytes(bytes, world, address, layout)?;
        let (found, expected) = (bytes.len() as u64, head.total_bytes());
        if found != expected {
            return Err(TileError::Length { found, expected });
        }
        let mut tile = Self::of_head(&head);
        tile.read_levels(&head, &bytes[TileHead::BYTES..])?;
        Ok(tile)
    }

    /// Creates a tile of which no level was read yet.
    pub fn of_head(head: &TileHead) -> Self {
        Self {
            address: head.address,
            format: head.format,
            finest_held: head.top_level + 1,
            pages: Vec::new(),
            materials: Vec::new(),
            mixed: Vec::new(),
            texels: Vec::new(),
        }
    }

    /// Reads more levels. `bytes` begin behind those of the levels that were read before. What is left of them behind the
    /// last whole level is not looked at. After an error, the tile holds the levels before the one that is wrong.
    ///
    /// # Errors
    /// If the bytes are damaged.
    pub fn read_levels(&mut self, head: &TileHead, mut bytes: &[u8]) -> Result<(), TileError> {
        while self.finest_held > self.address.finest_level() {
            let index = (head.top_level + 1 - self.finest_held) as usize;
            let section = &head.sections[index];
            let Some((own, rest)) = bytes.split_at_checked(section.bytes as usize) else {
                break;
            };
            if own.is_empty() {
                // No page is refined to this level.
                if index > 0 && !self.places_below(false).is_empty() {
                    return Err(TileError::Contents("the number of pages"));
                }
                self.finest_held -= 1;
                continue;
            }
            if blake3::hash(own).as_bytes()[..CHECKSUM] != section.checksum {
                return Err(TileError::Checksum);
            }
            let held = [
                self.pages.len(),
                self.materials.len(),
                self.mixed.len(),
                self.texels.len(),
            ];
            if let Err(error) = self.read_level(Reader(own), section, index == 0) {
                self.pages.truncate(held[0]);
                self.materials.truncate(held[1]);
                self.mixed.truncate(held[2]);
                self.texels.truncate(held[3]);
                return Err(error);
            }
            self.finest_held -= 1;
            bytes = rest;
        }
        Ok(())
    }

    fn read_level(
        &mut self,
        mut rest: Reader<'_>,
        section: &Section,
        is_top: bool,
    ) -> Result<(), TileError> {
        let ends = || TileError::Contents("they end too early");
        let places = self.places_below(is_top);
        let first = self.pages.len();
        let mut first_brick = self.materials.len();
        let before = first_brick;
        if places.len() != section.pages as usize {
            return Err(TileError::Contents("the number of pages"));
        }
        for place in places {
            let codes = rest.take(8).ok_or_else(ends)?;
            let mut kinds = [CellKind::Clear; 8];
            for (kind, &code) in kinds.iter_mut().zip(codes) {
                *kind = CellKind::of_code(code).ok_or(TileError::Contents("a cell's kind"))?;
            }
            let page = TilePage {
                level: self.finest_held - 1,
                place: place.to_array(),
                kinds,
                words: [MISSING_BRICK; 8],
                first_brick: first_brick as u32,
                first_mixed: 0,
            };
            first_brick += page.brick_count();
            self.pages.push(page);
        }
        let bricks = first_brick - before;
        if bricks != section.bricks as usize {
            return Err(TileError::Contents("the number of bricks"));
        }
        for page in &mut self.pages[first..] {
            for (kind, word) in page.kinds.iter().zip(&mut page.words) {
                if !kind.has_brick() {
                    *word = rest.word().ok_or_else(ends)?;
                    if empty_word(center_of(*word)) != *word || !center_of(*word).is_finite() {
                        return Err(TileError::Contents("the distance of a cell"));
                    }
                }
            }
        }
        for _ in 0..bricks {
            let material = rest.word().ok_or_else(ends)?;
            if material & BRICK_MIXED != 0 && material & !BRICK_MIXED >= section.mixed {
                return Err(TileError::Contents("the material of a brick"));
            }
            self.materials.push(material);
        }
        let mut mixed = self.mixed.len() / PLACES;
        for _ in 0..section.mixed as usize * PLACES {
            let [Some(a), Some(b)] = [rest.word(), rest.word()] else {
                return Err(ends());
            };
            self.mixed.push([a, b]);
        }
        for page in &mut self.pages[first..] {
            page.first_mixed = mixed as u32;
            let begin = page.first_brick as usize;
            mixed += mixed_among(&self.materials[begin..begin + page.brick_count()]);
        }
        if PLACES * mixed != self.mixed.len() {
            return Err(TileError::Contents("the number of mixed materials"));
        }
        self.texels.reserve(bricks * BRICK_SAMPLES);
        let from = self.texels.len();
        for _ in 0..bricks {
            unpack(&mut rest, &mut self.texels).ok_or_else(ends)?;
        }
        let max_code = self.format.max_code() as u16;
        if self.texels[from..]
            .iter()
            .any(|code| code.unsigned_abs() > max_code)
        {
            return Err(TileError::Contents("the samples of a brick"));
        }
        if !rest.0.is_empty() {
            return Err(TileError::Contents("they go on too far"));
        }
        Ok(())
    }

    /// Returns the places of the pages of the next finer level.
    fn places_below(&self, is_top: bool) -> Vec<IVec3> {
        if is_top {
            return vec![self.address.place.into()];
        }
        let above = self
            .pages
            .iter()
            .filter(|page| page.level == self.finest_held);
        let refined = above.flat_map(|page| {
            let cells = (0u32..8).filter(|&i| page.kinds[i as usize] == CellKind::Brick);
            cells.map(|i| 2 * IVec3::from_array(page.place) + octant_place(i))
        });
        refined.collect()
    }
}

/// Counts the mixed materials.
fn mixed_among(materials: &[u32]) -> usize {
    let mixed = materials.iter().filter(|&own| own & BRICK_MIXED != 0);
    mixed.count()
}
