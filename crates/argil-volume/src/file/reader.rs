//! Checks a volume file's sections.

use super::format::{
    ALIGNMENT, ENTRY_BYTES, FORMAT_VERSION, HEADER_BYTES, MAGIC, MAX_SECTIONS, Section, VolumeError,
};
use crate::{SampleFormat, Texels};
use memmap2::Mmap;
use std::path::Path;
use std::sync::Arc;

/// Bytes of memory that tables may take for each byte of a file, and for any file. A block takes 268 bytes, and at most seven nodes
/// of 2 KiB.
const MEMORY_PER_BYTE: u64 = 64;
const FREE_BYTES: u64 = 1 << 20;

/// A volume file with a valid header, table and checksums.
#[derive(Debug)]
pub struct FileReader<'a> {
    pub(super) map: Arc<Mmap>,
    pub(super) path: &'a Path,
    pub(super) version: u32,
    pub(super) sections: Vec<(Section, std::ops::Range<usize>)>,
}

fn word(bytes: &[u8], at: usize) -> u32 {
    let four = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
    u32::from_le_bytes(four.unwrap_or_default())
}

fn long(bytes: &[u8], at: usize) -> u64 {
    u64::from(word(bytes, at)) | u64::from(word(bytes, at + 4)) << 32
}

impl<'a> FileReader<'a> {
    /// Checks header, table, sizes and checksums.
    pub(super) fn new(map: Arc<Mmap>, path: &'a Path) -> Result<Self, VolumeError> {
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
            return Err(VolumeError::NotAVolumeFile(path.into()));
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
            return Err(fault(Section::Header, "invalid version or section count"));
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
                return Err(fault(section, "invalid offset"));
            };
            if end > size {
                return Err(cut(section, end));
            }
            if sections.iter().any(|(s, _)| *s == section) {
                return Err(fault(section, "duplicate section"));
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

    /// Creates an error about a section.
    pub(crate) fn fault(&self, section: Section, reason: &str) -> VolumeError {
        content(self.path, section, reason)
    }

    /// Returns the range of a section's bytes.
    pub(crate) fn range(&self, section: Section) -> Result<std::ops::Range<usize>, VolumeError> {
        let found = self.sections.iter().find(|(s, _)| *s == section);
        found
            .map(|(_, range)| range.clone())
            .ok_or_else(|| self.fault(section, "it is missing"))
    }

    /// Returns a section's bytes.
    pub(crate) fn bytes(&self, section: Section) -> Result<&[u8], VolumeError> {
        Ok(&self.map[self.range(section)?])
    }

    /// Returns a section's numbers.
    pub(crate) fn words(&self, section: Section) -> Result<Vec<u32>, VolumeError> {
        let (words, rest) = self.bytes(section)?.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(self.fault(section, "its length is not a multiple of 4 bytes"));
        }
        Ok(words.iter().map(|&w| u32::from_le_bytes(w)).collect())
    }

    /// Returns a section's numbers with signs.
    pub(crate) fn signed(&self, section: Section) -> Result<Vec<i32>, VolumeError> {
        Ok(bytemuck::allocation::cast_vec(self.words(section)?))
    }

    /// Returns the most bytes that tables of the file's contents may take.
    pub(crate) fn max_memory_bytes(&self) -> u64 {
        FREE_BYTES + MEMORY_PER_BYTE * self.map.len() as u64
    }

    /// Returns the samples of a level, without copying.
    pub(crate) fn texels(
        &self,
        level: u8,
        bits: SampleFormat,
        count: u64,
    ) -> Result<Texels, VolumeError> {
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
            format: bits,
        })
    }

    /// Returns samples that fill whole bricks of a number of bytes, without copying.
    pub(crate) fn samples(
        &self,
        bits: SampleFormat,
        brick_bytes: u64,
    ) -> Result<Texels, VolumeError> {
        let section = Section::Texels(0);
        let range = self.range(section)?;
        if !(range.len() as u64).is_multiple_of(brick_bytes) {
            return Err(self.fault(section, "its length is not a multiple of a brick"));
        }
        Ok(Texels::Mapped {
            file: self.map.clone(),
            range,
            format: bits,
        })
    }

    /// Returns the version of the format.
    pub(crate) fn version(&self) -> u32 {
        self.version
    }
}

fn content(path: &Path, section: Section, reason: &str) -> VolumeError {
    VolumeError::Content {
        path: path.into(),
        section,
        reason: reason.to_owned(),
    }
}
