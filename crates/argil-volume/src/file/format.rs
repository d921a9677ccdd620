//! What a volume file is made of, and what can be wrong with it.

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;

/// The version that this program writes, and the newest that it reads.
pub(super) const FORMAT_VERSION: u32 = 2;

pub(super) const MAGIC: [u8; 8] = *b"ARGILVOL";
pub(super) const HEADER_BYTES: usize = 32;
pub(super) const ENTRY_BYTES: usize = 32;
pub(super) const ALIGNMENT: u64 = 64;
pub(super) const MAX_SECTIONS: u32 = 32;
/// One for each level of detail that a volume can have.
pub(super) const DIGITS: &[u8; 12] = b"0123456789AB";

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
    pub(super) fn name(self) -> [u8; 4] {
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

    pub(super) fn of_name(name: [u8; 4]) -> Option<Self> {
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
#[derive(Debug)]
pub struct FilePart<'a> {
    /// Three numbers of its own: of a dense volume its levels, of bricks 1, the voxels along a brick's side, and one more.
    pub own: [u32; 3],
    /// Its sections, what is large borrowed.
    pub sections: Vec<(Section, Cow<'a, [u8]>)>,
}
