//! Volumes as files.
//!
//! A file begins with `ARGILVOL`, the version, the number of sections, a checksum of header and table, and the size of the file.
//! A table follows with the name, checksum, offset and size of each section.
//!
//! | section | contents |
//! | --- | --- |
//! | `DESC` | the kind of volume, its voxel grid and its encoding |
//! | `SCEN` | the scene that it was baked from, as JSON |
//! | `MESH` | sampled distances of the scene's meshes |
//! | `CODE` | octree: Morton codes of bricks |
//! | `NODE`, `ROWS` | octree: nodes, and the first node of each level |
//! | `BLKS` | bricks: the blocks of cells, three coordinates each, counted from the grid's corner |
//! | `FARS` | bricks: cubes of blocks far inside the solid, as first block and side |
//! | `CELL` | bricks: the words of the blocks' cells; the samples of their bricks are `TEX0` |
//! | `MATE`, `MIXD` | bricks: the material of each brick, and the materials of mixed bricks |
//! | `TEX0`, `TEX1`, … | samples of level 0, of level 1, and so on |
//!
//! All numbers are little-endian, sections begin at multiples of 64 bytes, and checksums are CRC-32 (IEEE). Samples stay where a
//! reader put the file's bytes, and are not copied again. A file is not mapped: another program could cut it short.

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
compile_error!("samples of volume files are used as they are, little-endian");
