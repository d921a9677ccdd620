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

mod meshes;
mod read;
mod write;

use crate::Volume;
pub use meshes::StoredMesh;
pub use read::FileReader;
use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};

/// The version that this program writes, and the newest that it reads.
pub const FORMAT_VERSION: u32 = 2;

const MAGIC: [u8; 8] = *b"ARGILVOL";
const HEADER_BYTES: usize = 32;
const ENTRY_BYTES: usize = 32;
const ALIGNMENT: u64 = 64;
const MAX_SECTIONS: u32 = 32;
/// One for each level of detail that a volume can have.
const DIGITS: &[u8; 12] = b"0123456789AB";

/// A part of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// The first bytes and the table of sections.
    Header,
    /// What the volume is.
    Description,
    /// The scene.
    Scene,
    /// The scene's meshes.
    Meshes,
    /// Codes of bricks.
    Codes,
    /// Nodes above bricks.
    Nodes,
    /// Where levels of nodes begin.
    Levels,
    /// Which blocks of cells there are.
    Blocks,
    /// What is far inside.
    Inside,
    /// Words of cells.
    Cells,
    /// What bricks look like.
    Materials,
    /// The materials of mixed bricks.
    Mixed,
    /// Texels of a level of detail, or the samples of bricks.
    Texels(u8),
}

impl Section {
    fn name(self) -> [u8; 4] {
        match self {
            Self::Header => *b"HEAD",
            Self::Description => *b"DESC",
            Self::Scene => *b"SCEN",
            Self::Meshes => *b"MESH",
            Self::Codes => *b"CODE",
            Self::Nodes => *b"NODE",
            Self::Levels => *b"ROWS",
            Self::Blocks => *b"BLKS",
            Self::Inside => *b"FARS",
            Self::Cells => *b"CELL",
            Self::Materials => *b"MATE",
            Self::Mixed => *b"MIXD",
            Self::Texels(level) => [b'T', b'E', b'X', DIGITS[usize::from(level) % DIGITS.len()]],
        }
    }

    fn of_name(name: [u8; 4]) -> Option<Self> {
        let texels = (0..DIGITS.len() as u8).map(Self::Texels);
        [
            Self::Description,
            Self::Scene,
            Self::Meshes,
            Self::Codes,
            Self::Nodes,
            Self::Levels,
            Self::Blocks,
            Self::Inside,
            Self::Cells,
            Self::Materials,
            Self::Mixed,
        ]
        .into_iter()
        .chain(texels)
        .find(|s| s.name() == name)
    }
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.name();
        let name = String::from_utf8_lossy(&name);
        let what = match self {
            Self::Header => "the header",
            Self::Description => "what the volume is",
            Self::Scene => "the scene",
            Self::Meshes => "the scene's meshes",
            Self::Codes => "the bricks' codes",
            Self::Nodes => "the tree's nodes",
            Self::Levels => "the tree's levels",
            Self::Blocks => "the blocks",
            Self::Inside => "what is far inside",
            Self::Cells => "the cells",
            Self::Materials => "the bricks' materials",
            Self::Mixed => "the materials of mixed bricks",
            Self::Texels(_) => "texels",
        };
        write!(f, "section {name} ({what})")
    }
}

/// Why a volume file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// The file could not be opened or read.
    #[error("{path}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is not a volume file at all.
    #[error("{0}: not a volume file")]
    Other(PathBuf),
    /// It was written by a newer program.
    #[error(
        "{path}: format version {found} is newer than this program reads ({FORMAT_VERSION}): update argil"
    )]
    Newer {
        /// Which file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// It ends too early.
    #[error(
        "{path}: {section} ends at byte {end}, and the file has {size}: it was cut short; bake it again"
    )]
    Truncated {
        /// Which file.
        path: PathBuf,
        /// What is cut.
        section: Section,
        /// Where it should end.
        end: u64,
        /// Bytes there are.
        size: u64,
    },
    /// A part is not what it should be.
    #[error("{path}: {section}: {reason}; bake it again")]
    Content {
        /// Which file.
        path: PathBuf,
        /// Which part.
        section: Section,
        /// What is wrong.
        reason: String,
    },
}

/// What a volume file keeps of a volume, besides its lattice and its encoding.
pub struct FilePart<'a> {
    /// Three numbers of its own: of a dense volume its levels, of bricks 1, the voxels along a brick's side, and one more.
    pub own: [u32; 3],
    /// Its sections, what is large borrowed.
    pub sections: Vec<(Section, Cow<'a, [u8]>)>,
}

impl Volume {
    /// Writes a file's bytes, with the scene that the volume was made from, as a scene file's text, and the meshes that it names.
    ///
    /// # Errors
    /// If `out` does not take them.
    pub fn write(
        &self,
        scene_json: &str,
        meshes: &[StoredMesh<'_>],
        out: impl std::io::Write,
    ) -> std::io::Result<()> {
        write::write(self, scene_json, meshes, out)
    }
}

/// What a volume file holds.
#[derive(Clone, PartialEq)]
pub struct Stored {
    /// The distances.
    pub volume: Volume,
    /// The scene that they were sampled from, as a scene file's text; may be empty.
    pub scene_json: String,
    /// The meshes that the scene names; none in files of version 1.
    pub meshes: Vec<StoredMesh<'static>>,
}

impl Stored {
    /// Whether a file begins as volume files do.
    pub fn is_volume_file(path: &Path) -> bool {
        // What is read from a pipe cannot be read again.
        if !std::fs::metadata(path).is_ok_and(|m| m.is_file()) {
            return false;
        }
        let mut begin = [0; 8];
        let read = std::fs::File::open(path)
            .and_then(|mut f| std::io::Read::read_exact(&mut f, &mut begin));
        read.is_ok() && begin == MAGIC
    }

    /// Read a file by mapping it into memory.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, VolumeError> {
        read::open(path.as_ref())
    }

    /// Read a file's bytes. `path` stands in messages only.
    pub fn from_bytes(bytes: &[u8], path: impl AsRef<Path>) -> Result<Self, VolumeError> {
        read::copied(bytes, path.as_ref())
    }
}

#[cfg(target_endian = "big")]
compile_error!("volume files are mapped as they are, little-endian");
