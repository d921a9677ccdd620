use super::meshes::meshes_of;
use super::write::{DESCRIPTION_WORDS, DESCRIPTION_WORDS_1, KIND_BRICKS, KIND_DENSE, KIND_OCTREE};
use super::{
    ALIGNMENT, ENTRY_BYTES, FORMAT_VERSION, HEADER_BYTES, MAGIC, MAX_SECTIONS, Section, Stored,
    Volume, VolumeError,
};
use crate::bricks::{center_of, is_lonely};
use crate::{
    BLOCK_SIDE, Bits, BlockTable, BrickLayout, BrickSettings, Bricks, Dense, Encoding, FAR_SLOTS,
    FARTHEST_VOXEL, Keep, Lattice, Layout, Octree, OctreeSettings, RESOLUTIONS, Range, Texels,
    Tree,
};
use glam::{IVec3, UVec3, Vec3};
use memmap2::{Mmap, MmapMut};
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

pub(super) fn open(path: &Path) -> Result<Stored, VolumeError> {
    let io = |source| VolumeError::Io {
        path: path.into(),
        source,
    };
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if !metadata.is_file() {
        return Err(io(std::io::Error::other("is not a file")));
    }
    if metadata.len() == 0 {
        return Err(VolumeError::Other(path.into()));
    }
    // SAFETY: the map is only read. That nobody cuts the file short in the meantime is asked for in the module's text.
    let map = unsafe { Mmap::map(&file) }.map_err(io)?;
    Reader::new(Arc::new(map), path)?.read()
}

pub(super) fn copied(bytes: &[u8], path: &Path) -> Result<Stored, VolumeError> {
    let io = |source| VolumeError::Io {
        path: path.into(),
        source,
    };
    if bytes.is_empty() {
        return Err(VolumeError::Other(path.into()));
    }
    let mut map = MmapMut::map_anon(bytes.len()).map_err(io)?;
    map.copy_from_slice(bytes);
    let map = map.make_read_only().map_err(io)?;
    Reader::new(Arc::new(map), path)?.read()
}

struct Reader<'a> {
    map: Arc<Mmap>,
    path: &'a Path,
    version: u32,
    sections: Vec<(Section, std::ops::Range<usize>)>,
}

fn word(bytes: &[u8], at: usize) -> u32 {
    let four = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
    u32::from_le_bytes(four.unwrap_or_default())
}

fn long(bytes: &[u8], at: usize) -> u64 {
    u64::from(word(bytes, at)) | u64::from(word(bytes, at + 4)) << 32
}

impl<'a> Reader<'a> {
    /// Check header, table, sizes and checksums.
    fn new(map: Arc<Mmap>, path: &'a Path) -> Result<Self, VolumeError> {
        let bytes = &map[..];
        let size = bytes.len() as u64;
        let cut = |section, end| VolumeError::Truncated {
            path: path.into(),
            section,
            end,
            size,
        };
        let fault = |section, reason: &str| content(path, section, reason);
        if !bytes.starts_with(&MAGIC) {
            return Err(VolumeError::Other(path.into()));
        }
        if bytes.len() < HEADER_BYTES {
            return Err(cut(Section::Header, HEADER_BYTES as u64));
        }
        let version = word(bytes, 8);
        if version > FORMAT_VERSION {
            return Err(VolumeError::Newer {
                path: path.into(),
                found: version,
            });
        }
        let count = word(bytes, 12);
        if version == 0 || count == 0 || count > MAX_SECTIONS {
            return Err(fault(Section::Header, "its numbers make no sense"));
        }
        let table_end = HEADER_BYTES + ENTRY_BYTES * count as usize;
        let Some(table) = bytes.get(HEADER_BYTES..table_end) else {
            return Err(cut(Section::Header, table_end as u64));
        };
        let mut crc = crc32fast::Hasher::new();
        crc.update(&bytes[..24]);
        crc.update(table);
        if crc.finalize() != word(bytes, 24) {
            return Err(fault(Section::Header, "the checksum differs"));
        }

        let mut sections = Vec::new();
        for entry in table.chunks_exact(ENTRY_BYTES) {
            let name = word(entry, 0).to_le_bytes();
            let (offset, length) = (long(entry, 8), long(entry, 16));
            let Some(section) = Section::of_name(name) else {
                let name = String::from_utf8_lossy(&name).into_owned();
                let reason = format!("no section has the name {name:?}");
                return Err(fault(Section::Header, &reason));
            };
            let end = offset.checked_add(length);
            let Some(end) = end.filter(|_| offset.is_multiple_of(ALIGNMENT)) else {
                return Err(fault(section, "its place makes no sense"));
            };
            if end > size {
                return Err(cut(section, end));
            }
            if sections.iter().any(|(s, _)| *s == section) {
                return Err(fault(section, "it is there twice"));
            }
            let range = offset as usize..end as usize;
            if crc32fast::hash(&bytes[range.clone()]) != word(entry, 4) {
                return Err(fault(section, "the checksum differs: the file is damaged"));
            }
            sections.push((section, range));
        }
        if long(bytes, 16) != size {
            return Err(fault(
                Section::Header,
                "the file is longer than its header says",
            ));
        }
        Ok(Self {
            map,
            path,
            version,
            sections,
        })
    }

    fn fault(&self, section: Section, reason: &str) -> VolumeError {
        content(self.path, section, reason)
    }

    fn range(&self, section: Section) -> Result<std::ops::Range<usize>, VolumeError> {
        let found = self.sections.iter().find(|(s, _)| *s == section);
        found
            .map(|(_, range)| range.clone())
            .ok_or_else(|| self.fault(section, "it is missing"))
    }

    fn bytes(&self, section: Section) -> Result<&[u8], VolumeError> {
        Ok(&self.map[self.range(section)?])
    }

    fn words(&self, section: Section) -> Result<Vec<u32>, VolumeError> {
        let (words, rest) = self.bytes(section)?.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(self.fault(section, "half a number is left"));
        }
        Ok(words.iter().map(|&w| u32::from_le_bytes(w)).collect())
    }

    fn texels(&self, level: u8, bits: Bits, count: u64) -> Result<Texels, VolumeError> {
        let section = Section::Texels(level);
        let range = self.range(section)?;
        let (expected, found) = (count * bits.bytes() as u64, range.len());
        if found as u64 != expected {
            let reason = format!("it has {found} bytes and should have {expected}");
            return Err(self.fault(section, &reason));
        }
        Ok(Texels::Mapped {
            file: self.map.clone(),
            range,
            bits,
        })
    }

    fn read(self) -> Result<Stored, VolumeError> {
        let about = Section::Description;
        let mut words = self.words(about)?;
        if self.version == 1 && words.len() == DESCRIPTION_WORDS_1 {
            words.extend([0, 0, 0, 1]);
        }
        let Ok(words) = <[u32; DESCRIPTION_WORDS]>::try_from(words) else {
            return Err(self.fault(about, "it has another length"));
        };
        let [
            kind,
            bits,
            range,
            x,
            y,
            z,
            voxel,
            nx,
            ny,
            nz,
            levels,
            brick,
            depth,
            first_x,
            first_y,
            first_z,
            is_cut,
        ] = words;
        let bits = match bits {
            8 => Bits::Eight,
            16 => Bits::Sixteen,
            _ => return Err(self.fault(about, "distances of neither 8 nor 16 bits")),
        };
        let range = f32::from_bits(range);
        let lattice = Lattice {
            corner: Vec3::from_array([x, y, z].map(f32::from_bits)),
            voxel: f32::from_bits(voxel),
            begin: UVec3::new(first_x, first_y, first_z).as_ivec3(),
            size: UVec3::new(nx, ny, nz),
            is_cut: is_cut != 0,
        };
        let begin = lattice.begin.to_array().map(i64::from);
        let is_countable = begin
            .iter()
            .zip(lattice.size.to_array())
            .all(|(first, size)| {
                let farthest = i64::from(FARTHEST_VOXEL);
                *first >= -farthest && first + i64::from(size) <= farthest
            });
        let is_sized = if kind == KIND_BRICKS && self.version > 1 {
            is_countable
        } else {
            RESOLUTIONS.contains(&lattice.size.max_element()) && lattice.begin == IVec3::ZERO
        };
        let is_positive = |v: f32| v.is_finite() && v > 0.0;
        let is_sane = is_positive(range)
            && range <= 1e6
            && is_positive(lattice.voxel)
            && is_sized
            && lattice.aabb().is_finite()
            && lattice.size.min_element() >= 1;
        if !is_sane {
            return Err(self.fault(about, "its measures make no sense"));
        }
        let encoding = Encoding {
            bits,
            range: Range::Voxels(range),
        };
        let volume = match kind {
            KIND_DENSE => Volume::Dense(self.dense(lattice, encoding, levels)?),
            KIND_OCTREE => Volume::Octree(self.octree(lattice, encoding, brick, depth)?),
            KIND_BRICKS => Volume::Bricks(self.bricks(lattice, encoding, brick, depth)?),
            _ => return Err(self.fault(about, "a volume of an unknown kind")),
        };
        let Ok(scene_json) = String::from_utf8(self.bytes(Section::Scene)?.to_vec()) else {
            return Err(self.fault(Section::Scene, "it is not text"));
        };
        let has_meshes = self.sections.iter().any(|(s, _)| *s == Section::Meshes);
        let meshes = match has_meshes {
            true => meshes_of(self.bytes(Section::Meshes)?)
                .ok_or_else(|| self.fault(Section::Meshes, "its lengths make no sense"))?,
            false => Vec::new(),
        };
        Ok(Stored {
            volume,
            scene_json,
            meshes,
        })
    }

    fn dense(
        &self,
        lattice: Lattice,
        encoding: Encoding,
        levels: u32,
    ) -> Result<Dense, VolumeError> {
        let most = Dense::most_levels(&lattice);
        if !(1..=most).contains(&levels) {
            let reason = format!("{levels} levels, and the volume's size makes {most} at most");
            return Err(self.fault(Section::Description, &reason));
        }
        let texels = (0..levels)
            .map(|level| self.texels(level as u8, encoding.bits, lattice.texel_count(level)))
            .collect::<Result<_, _>>()?;
        Dense::from_levels(lattice, encoding, texels)
            .ok_or_else(|| self.fault(Section::Texels(0), "its size is another"))
    }

    fn bricks(
        &self,
        lattice: Lattice,
        encoding: Encoding,
        brick: u32,
        lipschitz: u32,
    ) -> Result<Bricks, VolumeError> {
        let layout = BrickLayout::new(lattice, &BrickSettings { encoding, brick })
            .map_err(|e| self.fault(Section::Description, &e.to_string()))?;
        let samples = Section::Texels(0);
        let range = self.range(samples)?;
        if !(range.len() as u64).is_multiple_of(layout.brick_bytes()) {
            return Err(self.fault(samples, "half a brick is left"));
        }
        let pool = Texels::Mapped {
            file: self.map.clone(),
            range,
            bits: encoding.bits,
        };
        let mixed = self.words(Section::Mixed)?;
        if !mixed.len().is_multiple_of(2) {
            return Err(self.fault(Section::Mixed, "half a material is left"));
        }
        let mixed = mixed.as_chunks::<2>().0.to_vec();
        let cells = self.words(Section::Cells)?;
        let blocks = if self.version == 1 {
            all_blocks(&layout, &cells).ok_or_else(|| {
                self.fault(Section::Cells, "there are not as many as the volume has")
            })?
        } else {
            self.blocks(&layout, &cells)?
        };
        Bricks::from_parts(
            layout,
            f32::from_bits(lipschitz),
            blocks,
            (self.words(Section::Materials)?, mixed),
            pool,
        )
        .map_err(|reason| self.fault(Section::Cells, reason))
    }

    /// The table of blocks, and the words of its slots.
    fn blocks(
        &self,
        layout: &BrickLayout,
        cells: &[u32],
    ) -> Result<(BlockTable, Vec<u32>), VolumeError> {
        let signed = |section| -> Result<Vec<i32>, VolumeError> {
            Ok(self.words(section)?.iter().map(|&w| w as i32).collect())
        };
        let blocks = signed(Section::Blocks)?;
        let (blocks, rest) = blocks.as_chunks::<3>();
        if !rest.is_empty() || cells.len() != 64 * blocks.len() {
            return Err(self.fault(Section::Blocks, "there are not as many as cells"));
        }
        let farthest = FARTHEST_VOXEL / (layout.brick * BLOCK_SIDE) as i32 + 1;
        let is_near = |c: &i32| (-farthest..=farthest).contains(c);
        let [low, high] = layout.block_range();
        let mut table = BlockTable::new(low, high);
        let inside = signed(Section::Inside)?;
        let (inside, rest) = inside.as_chunks::<4>();
        for &[x, y, z, side] in inside {
            let first = IVec3::new(x, y, z);
            let is_cube = [x, y, z].iter().all(is_near)
                && (1..=1 << 21).contains(&side)
                && side.ilog2() % 3 == 0
                && side.count_ones() == 1
                && first.rem_euclid(IVec3::splat(side)) == IVec3::ZERO;
            if !is_cube || !rest.is_empty() {
                return Err(self.fault(Section::Inside, "a cube that cannot be"));
            }
            table.set_far(first, first + side, true);
        }
        let mut words = vec![0; FAR_SLOTS as usize * 64];
        for (block, own) in blocks.iter().zip(cells.as_chunks::<64>().0) {
            let at = IVec3::from_array(*block);
            if !block.iter().all(is_near) || table.find(at).is_some() {
                return Err(
                    self.fault(Section::Blocks, "a block that cannot be, or is there twice")
                );
            }
            table.insert(at);
            words.extend(own);
        }
        Ok((table, words))
    }

    fn octree(
        &self,
        lattice: Lattice,
        encoding: Encoding,
        brick: u32,
        depth: u32,
    ) -> Result<Octree, VolumeError> {
        let settings = OctreeSettings {
            encoding,
            brick,
            depth: Some(depth),
            keep: Keep::Conservative,
        };
        let layout = Layout::new(lattice, &settings)
            .map_err(|e| self.fault(Section::Description, &e.to_string()))?;
        let nodes = self.bytes(Section::Nodes)?;
        if !nodes.len().is_multiple_of(size_of::<argil_abi::Node>()) {
            return Err(self.fault(Section::Nodes, "half a node is left"));
        }
        let nodes = nodes
            .chunks_exact(size_of::<argil_abi::Node>())
            .map(bytemuck::pod_read_unaligned)
            .collect();
        let tree = Tree::from_parts(
            self.words(Section::Codes)?,
            nodes,
            self.words(Section::Levels)?,
        );
        if let Some(reason) = tree.check(&layout) {
            return Err(self.fault(Section::Nodes, reason));
        }
        let texels = self.texels(0, encoding.bits, lattice.texel_count(0))?;
        Octree::from_parts(layout, tree, texels)
            .ok_or_else(|| self.fault(Section::Texels(0), "its size is another"))
    }
}

/// Of version 1, which has the words of all blocks of the box: the table of those that are not far from everything.
fn all_blocks(layout: &BrickLayout, cells: &[u32]) -> Option<(BlockTable, Vec<u32>)> {
    let [low, high] = layout.block_range();
    let size = (high - low).as_uvec3();
    let count = size
        .to_array()
        .map(|n| n as usize)
        .iter()
        .product::<usize>();
    if cells.len() != 64 * count {
        return None;
    }
    let mut table = BlockTable::new(low, high);
    let mut words = vec![0; FAR_SLOTS as usize * 64];
    let far = 0.999 * layout.far_length();
    for (at, own) in (0u32..).zip(cells.as_chunks::<64>().0) {
        let place = UVec3::new(at % size.x, at / size.x % size.y, at / size.x / size.y);
        let block = low + place.as_ivec3();
        let center = center_of(own[0]);
        let is_far = |&w: &u32| is_lonely(w) && w >> 31 != 0 && center_of(w).abs() >= far;
        if own.iter().all(is_far) {
            table.set_far(block, block + 1, center < 0.0);
        } else {
            table.insert(block);
            words.extend(own);
        }
    }
    Some((table, words))
}

fn content(path: &Path, section: Section, reason: &str) -> VolumeError {
    VolumeError::Content {
        path: path.into(),
        section,
        reason: reason.to_owned(),
    }
}
