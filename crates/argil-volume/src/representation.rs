//! What a representation is on the CPU: one trait, which each implements in its own file, and the list of them.

use crate::{
    BrickLayout, Bricks, BricksError, Dense, EditStats, Encoding, FilePart, FileReader, Octree,
    OctreeLayout, PendingEdits, VolumeError, VoxelGrid,
};
use argil_abi::GpuMaterial;
use argil_field::IncrementalProgram;
use glam::Vec3;
use web_time::Instant;

/// Distances that are kept on the CPU.
pub trait VolumeKind: Sized + Send + Sync {
    /// Its number in a volume file.
    const KIND: u32;

    /// Where the voxels lie.
    fn voxel_grid(&self) -> &VoxelGrid;

    /// What texels mean.
    fn encoding(&self) -> &Encoding;

    /// Bytes of everything that it holds.
    fn memory_bytes(&self) -> u64;

    /// What it is, without its texels.
    fn info(&self) -> VolumeInfo;

    /// What it tells of a point in its box, and whether that is the distance there, as nearly as it is kept, and not only one that
    /// the distance does not fall short of. `None` where distances are not told everywhere.
    fn distance_in(&self, point: Vec3) -> Option<(f32, bool)>;

    /// What is kept of the material at a point of a surface, given the direction out of the solid; a place in `palette` says which.
    fn material_at(
        &self,
        _point: Vec3,
        _outwards: Vec3,
        _palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        None
    }

    /// Says whether the box cuts what is solid, of a volume that does not know.
    fn set_clipped(&mut self, _is_cut: bool) {}

    /// What following edits takes, of one that is changed in place.
    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        None
    }

    /// Lies over the box that its edits have [grown to](PendingEdits::grow_to). Nothing is sampled.
    fn grow(&mut self, _edits: &dyn PendingEdits) {}

    /// Does what its edits have left to be done, on rayon's current threads: all of it, or as much as can be done until a point in
    /// time, and at least a little.
    ///
    /// # Errors
    /// If it would take more than `budget` bytes; what was taken out of the work last is then not done.
    fn edit(
        &mut self,
        _live: &IncrementalProgram,
        _edits: &mut dyn PendingEdits,
        _budget: Option<u64>,
        _until: Option<Instant>,
    ) -> Result<EditStats, BricksError> {
        Ok(EditStats::default())
    }

    /// What a volume file keeps of it.
    fn file_parts(&self) -> FilePart<'_>;

    /// Whether a file of a version can have such a lattice.
    fn fits_file(lattice: &VoxelGrid, version: u32) -> bool;

    /// What a volume file has kept: of a lattice and encoding that make sense, and the three numbers of [`FilePart::own`].
    ///
    /// # Errors
    /// If it is damaged.
    fn from_file(
        file: &FileReader<'_>,
        lattice: VoxelGrid,
        encoding: Encoding,
        own: [u32; 3],
    ) -> Result<Self, VolumeError>;
}

/// What a volume is, without its texels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct VolumeInfo {
    /// Where the voxels lie.
    pub voxel_grid: VoxelGrid,
    /// What texels mean.
    pub encoding: Encoding,
    /// Levels of detail.
    pub levels: u32,
    /// Bytes of everything that it holds.
    pub memory_bytes: u64,
    /// Of an octree, what its bricks are.
    pub octree: Option<OctreeInfo>,
    /// Of sparse bricks, what they are.
    pub bricks: Option<BrickInfo>,
}

impl VolumeInfo {
    /// Of one level of detail, and neither a tree nor sparse bricks.
    pub fn new(voxel_grid: VoxelGrid, encoding: Encoding, memory_bytes: u64) -> Self {
        Self {
            voxel_grid,
            encoding,
            levels: 1,
            memory_bytes,
            octree: None,
            bricks: None,
        }
    }

    /// Of a volume in memory or in a file.
    pub fn of(volume: &Volume) -> Self {
        volume.info()
    }
}

/// What sparse bricks are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickInfo {
    /// Cells and bricks.
    pub layout: BrickLayout,
    /// Number of bricks.
    pub bricks: u64,
}

/// What an octree's bricks are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeInfo {
    /// Bricks and levels of nodes.
    pub layout: OctreeLayout,
    /// Number of bricks.
    pub bricks: u64,
    /// Number of nodes.
    pub nodes: u64,
}

/// What follows of the list of representations.
macro_rules! volumes {
    ($($name:ident),*) => {
        /// A volume of any kind.
        #[derive(Clone, PartialEq)]
        #[expect(
            clippy::large_enum_variant,
            reason = "volumes are few, and hold megabytes elsewhere"
        )]
        #[derive(Debug)]
        pub enum Volume {
            $(#[doc = concat!("[`", stringify!($name), "`](struct@", stringify!($name), ")")] $name($name),)*
        }

        impl Volume {
            /// Where the voxels lie.
            pub fn voxel_grid(&self) -> &VoxelGrid {
                match self { $(Self::$name(own) => VolumeKind::voxel_grid(own),)* }
            }

            /// What texels mean.
            pub fn encoding(&self) -> &Encoding {
                match self { $(Self::$name(own) => VolumeKind::encoding(own),)* }
            }

            /// Bytes of everything that it holds.
            pub fn memory_bytes(&self) -> u64 {
                match self { $(Self::$name(own) => VolumeKind::memory_bytes(own),)* }
            }

            /// What it is, without its texels.
            pub fn info(&self) -> VolumeInfo {
                match self { $(Self::$name(own) => own.info(),)* }
            }

            /// See [`VolumeKind::distance_in`].
            pub fn distance_in(&self, point: Vec3) -> Option<(f32, bool)> {
                match self { $(Self::$name(own) => own.distance_in(point),)* }
            }

            /// See [`VolumeKind::material_at`].
            pub fn material_at(
                &self,
                point: Vec3,
                outwards: Vec3,
                palette: &[GpuMaterial],
            ) -> Option<GpuMaterial> {
                match self { $(Self::$name(own) => own.material_at(point, outwards, palette),)* }
            }

            /// Says whether the box cuts what is solid, of a volume that does not know: files of version 1 do not tell.
            pub fn set_clipped(&mut self, is_cut: bool) {
                match self { $(Self::$name(own) => own.set_clipped(is_cut),)* }
            }

            /// See [`VolumeKind::edits`].
            pub fn edits(&self) -> Option<Box<dyn PendingEdits>> {
                match self { $(Self::$name(own) => own.edits(),)* }
            }

            /// See [`VolumeKind::grow`].
            pub fn grow(&mut self, edits: &dyn PendingEdits) {
                match self { $(Self::$name(own) => VolumeKind::grow(own, edits),)* }
            }

            /// See [`VolumeKind::edit`].
            ///
            /// # Errors
            /// As there.
            pub fn edit(
                &mut self,
                live: &IncrementalProgram,
                edits: &mut dyn PendingEdits,
                budget: Option<u64>,
                until: Option<Instant>,
            ) -> Result<EditStats, BricksError> {
                match self { $(Self::$name(own) => VolumeKind::edit(own, live, edits, budget, until),)* }
            }

            /// Its number in a file, and what that keeps of it.
            pub(crate) fn file_parts(&self) -> (u32, FilePart<'_>) {
                match self { $(Self::$name(own) => ($name::KIND, own.file_parts()),)* }
            }

            /// What a file has kept of the kind of a number; `None` if there is no such kind, or its lattice cannot be one's.
            pub(crate) fn from_file(
                kind: u32,
                (file, version): (&FileReader<'_>, u32),
                lattice: VoxelGrid,
                encoding: Encoding,
                own: [u32; 3],
            ) -> Result<Self, FromFileError> {
                match kind {
                    $($name::KIND if $name::fits_file(&lattice, version) => {
                        Ok(Self::$name($name::from_file(file, lattice, encoding, own)?))
                    })*
                    $($name::KIND)|* => Err(FromFileError::Lattice),
                    _ => Err(FromFileError::Kind),
                }
            }
        }

        $(impl From<$name> for Volume {
            fn from(own: $name) -> Self {
                Self::$name(own)
            }
        })*
    };
}

/// Why a file's volume is none.
pub(crate) enum FromFileError {
    Kind,
    Lattice,
    Content(VolumeError),
}

impl From<VolumeError> for FromFileError {
    fn from(error: VolumeError) -> Self {
        Self::Content(error)
    }
}

/// The list of representations on the CPU: a name here and the traits, in a file a crate, make one. It calls another macro with all
/// names, for who does something with each.
#[doc(hidden)]
#[macro_export]
macro_rules! all_volumes {
    ($then:ident) => {
        $then!(Dense, Octree, Bricks);
    };
}

all_volumes!(volumes);
