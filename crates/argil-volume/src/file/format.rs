//! The parts of a volume file, and what can be wrong with them.

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
/// One character for each level of detail.
pub(super) const DIGITS: &[u8; 12] = b"0123456789AB";

/// A section of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// The first bytes, and the table of sections.
    Header,
    /// The description of the volume.
    Description,
    /// The scene.
    Scene,
    /// The scene's meshes.
    Meshes,
    /// Codes of an octree's bricks.
    Codes,
    /// Nodes above an octree's bricks.
    Nodes,
    /// Indices where levels of nodes begin.
    Levels,
    /// The blocks of sparse bricks.
    Blocks,
    /// Empty cubes inside the solid.
    FarInside,
    /// Cells of sparse bricks.
    Cells,
    /// Materials of sparse bricks.
    Materials,
    /// Materials of mixed bricks.
    MixedMaterials,
    /// Samples of a level, or of sparse bricks.
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
            Self::FarInside => *b"FARS",
            Self::Cells => *b"CELL",
            Self::Materials => *b"MATE",
            Self::MixedMaterials => *b"MIXD",
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
            Self::FarInside,
            Self::Cells,
            Self::Materials,
            Self::MixedMaterials,
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
            Self::FarInside => "what is far inside",
            Self::Cells => "the cells",
            Self::Materials => "the bricks' materials",
            Self::MixedMaterials => "the materials of mixed bricks",
            Self::Texels(_) => "texels",
        };
        write!(f, "section {name} ({what})")
    }
}

/// The reason why a volume file cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}")]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is not a volume file.
    #[error("{0}: not a volume file")]
    NotAVolumeFile(PathBuf),
    /// A newer program wrote the file.
    #[error(
        "{path}: format version {found} is newer than this program reads ({FORMAT_VERSION}): update argil"
    )]
    Newer {
        /// Path of the file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// The file is truncated.
    #[error(
        "{path}: {section} ends at byte {end}, and the file has {size}: it was cut short; bake it again"
    )]
    Truncated {
        /// Path of the file.
        path: PathBuf,
        /// The section that is cut off.
        section: Section,
        /// Byte at which it should end.
        end: u64,
        /// Bytes in the file.
        size: u64,
    },
    /// A section is damaged or inconsistent.
    #[error("{path}: {section}: {reason}; bake it again")]
    Content {
        /// Path of the file.
        path: PathBuf,
        /// The section.
        section: Section,
        /// What is wrong.
        reason: String,
    },
}

/// What a volume file stores of a volume, besides its grid and its encoding.
#[derive(Debug)]
pub struct FilePart<'a> {
    /// Three numbers of the volume's own: for a dense volume its levels; for bricks 1, the voxels along a brick's
    /// side, and one more.
    pub kind_parameters: [u32; 3],
    /// Its sections. Large ones are borrowed.
    pub sections: Vec<(Section, Cow<'a, [u8]>)>,
}
