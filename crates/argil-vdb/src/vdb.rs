//! OpenVDB files: `.vdb`.
//!
//! The layout is that of OpenVDB's file version 224 (`io/Archive.cc`, `io/Compression.h` and `tree/` of
//! <https://github.com/AcademySoftwareFoundation/openvdb>). Versions 222 to 225 are read.

mod bytes;
mod metadata;
mod read;
mod topology;
mod values;
mod write;

pub use read::{GridInfo, VdbFile};
pub use write::{GridWriter, VdbWriter, WriteOptions, write};

/// First bytes of a file, as a little-endian integer of 64 bits.
const MAGIC: u64 = 0x5644_4220;
/// The version that is written.
const FILE_VERSION: u32 = 224;
/// Bits of the compression flags of a grid.
const FLAG_ZIP: u32 = 1;
const FLAG_ACTIVE_MASK: u32 = 2;
const FLAG_BLOSC: u32 = 4;
