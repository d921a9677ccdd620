use super::meshes::meshes_of;
use super::write::{DESCRIPTION_WORDS, DESCRIPTION_WORDS_1};
use super::{
    ALIGNMENT, ENTRY_BYTES, FORMAT_VERSION, HEADER_BYTES, MAGIC, MAX_SECTIONS, Section, Stored,
    VolumeError,
};
use crate::representation::FromFileError;
use crate::{Bits, Encoding, Lattice, Range, Texels, Volume};
use glam::{UVec3, Vec3};
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
    FileReader::new(Arc::new(map), path)?.read()
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
    FileReader::new(Arc::new(map), path)?.read()
}

/// A volume file whose header, table and checksums are as they should be.
pub struct FileReader<'a> {
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

impl<'a> FileReader<'a> {
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

    /// Something is wrong with a section.
    pub(crate) fn fault(&self, section: Section, reason: &str) -> VolumeError {
        content(self.path, section, reason)
    }

    /// Where a section's bytes are.
    pub(crate) fn range(&self, section: Section) -> Result<std::ops::Range<usize>, VolumeError> {
        let found = self.sections.iter().find(|(s, _)| *s == section);
        found
            .map(|(_, range)| range.clone())
            .ok_or_else(|| self.fault(section, "it is missing"))
    }

    /// A section's bytes.
    pub(crate) fn bytes(&self, section: Section) -> Result<&[u8], VolumeError> {
        Ok(&self.map[self.range(section)?])
    }

    /// A section's numbers.
    pub(crate) fn words(&self, section: Section) -> Result<Vec<u32>, VolumeError> {
        let (words, rest) = self.bytes(section)?.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(self.fault(section, "half a number is left"));
        }
        Ok(words.iter().map(|&w| u32::from_le_bytes(w)).collect())
    }

    /// The texels of a level of detail, not copied.
    pub(crate) fn texels(&self, level: u8, bits: Bits, count: u64) -> Result<Texels, VolumeError> {
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

    /// Samples that fill whole bricks of so many bytes, not copied.
    pub(crate) fn samples(&self, bits: Bits, brick_bytes: u64) -> Result<Texels, VolumeError> {
        let section = Section::Texels(0);
        let range = self.range(section)?;
        if !(range.len() as u64).is_multiple_of(brick_bytes) {
            return Err(self.fault(section, "half a brick is left"));
        }
        Ok(Texels::Mapped {
            file: self.map.clone(),
            range,
            bits,
        })
    }

    /// The version of the format.
    pub(crate) fn version(&self) -> u32 {
        self.version
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
        let is_positive = |v: f32| v.is_finite() && v > 0.0;
        let is_sane = is_positive(range)
            && range <= 1e6
            && is_positive(lattice.voxel)
            && lattice.aabb().is_finite()
            && lattice.size.min_element() >= 1;
        if !is_sane {
            return Err(self.fault(about, "its measures make no sense"));
        }
        let encoding = Encoding {
            bits,
            range: Range::Voxels(range),
        };
        let own = [levels, brick, depth];
        let volume = Volume::from_file(kind, (&self, self.version), lattice, encoding, own);
        let volume = volume.map_err(|error| match error {
            FromFileError::Kind => self.fault(about, "a volume of an unknown kind"),
            FromFileError::Lattice => self.fault(about, "its measures make no sense"),
            FromFileError::Content(error) => error,
        })?;
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
}

fn content(path: &Path, section: Section, reason: &str) -> VolumeError {
    VolumeError::Content {
        path: path.into(),
        section,
        reason: reason.to_owned(),
    }
}
