//! Volumes as files.
//!
//! ```text
//!   "ARGILVOL"  version  sections  crc of header and table  size of the file
//!   table: name, crc, offset, size of each section
//!   DESC  what the volume is        SCEN  the scene that it was made from, as JSON
//!   MESH  the distances of the meshes that the scene names
//!   CODE  codes of bricks           NODE  nodes           ROWS  where each level of nodes begins
//!   BLKS  which blocks of cells sparse bricks have: three numbers each, from the lattice's corner on
//!   FARS  cubes of blocks that are far inside: where they begin, and their side
//!   CELL  what is in each cell of those blocks, whose bricks' samples are TEX0
//!   MATE  what each brick looks like        MIXD  the materials of mixed bricks
//!   TEX0  texels of level 0         TEX1  of level 1 …
//! ```
//!
//! All numbers are little-endian, sections begin at multiples of 64 bytes, checksums are CRC-32 (IEEE). A file that is
//! read is mapped into memory: its texels are not copied. A file must not be cut short by others while it is open.

mod format;
mod meshes;
mod read;
mod reader;
mod write;

pub use format::{FilePart, Section, VolumeError};
pub use meshes::StoredMesh;
pub use read::VolumeFile;
pub use reader::FileReader;

#[cfg(target_endian = "big")]
compile_error!("volume files are mapped as they are, little-endian");
