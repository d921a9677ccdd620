//! Kinds of volumes on the CPU: a trait, which each kind implements in its own file, and the list of all kinds.

use crate::{
    BrickLayout, Bricks, BricksError, Dense, EditStats, Encoding, FilePart, FileReader, Levels,
    Octree, OctreeLayout, PendingEdits, VolumeError, VoxelGrid,
};
use argil_abi::GpuMaterial;
use argil_field::IncrementalProgram;
use glam::Vec3;
use web_time::Instant;

/// A kind of stored distances on the CPU.
pub trait VolumeKind: Sized + Send + Sync {
    /// Its number in a volume file.
    const KIND: u32;

    /// Returns the voxel grid.
    fn voxel_grid(&self) -> &VoxelGrid;

    /// Returns the format and band of samples.
    fn encoding(&self) -> &Encoding;

    /// Returns the bytes of everything.
    fn memory_bytes(&self) -> u64;

    /// Describes the volume.
    fn info(&self) -> VolumeInfo;

    /// Returns the distance at a point of the box, and whether it is a sampled distance or a lower bound. Returns
    /// `None` if the kind does not know distances everywhere.
    fn distance_in(&self, point: Vec3) -> Option<(f32, bool)>;

    /// Returns the stored material at a point of the surface, given the outward direction and the program's
    /// materials.
    fn material_at(
        &self,
        _point: Vec3,
        _outwards: Vec3,
        _palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        None
    }

    /// Sets whether the box clips the solid, for a volume that does not know.
    fn set_clipped(&mut self, _is_cut: bool) {}

    /// Returns the state for edits in place, if this kind supports them.
    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        None
    }

    /// Grows to the box that the edits have [grown to](PendingEdits::grow_to). Samples nothing.
    fn grow(&mut self, _edits: &dyn PendingEdits) {}

    /// Processes remaining edits on rayon's current threads, all of them or until a point in time, and at least a
    /// little.
    ///
    /// # Errors
    /// If the result would exceed `budget` bytes. The batch in progress is lost then.
    fn edit(
        &mut self,
        _live: &IncrementalProgram,
        _edits: &mut dyn PendingEdits,
        _budget: Option<u64>,
        _until: Option<Instant>,
    ) -> Result<EditStats, BricksError> {
        Ok(EditStats::default())
    }

    /// Returns what a volume file stores.
    fn file_parts(&self) -> FilePart<'_>;

    /// Whether a file of a version can have such a grid.
    fn fits_file(voxel_grid: &VoxelGrid, version: u32) -> bool;

    /// Reads a volume from a file with a valid grid and encoding, and the three numbers of [`FilePart::kind_parameters`].
    ///
    /// # Errors
    /// If the file is damaged.
    fn from_file(
        file: &FileReader<'_>,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        own: [u32; 3],
    ) -> Result<Self, VolumeError>;
}

/// A description of a volume, without its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct VolumeInfo {
    /// The voxel grid.
    pub voxel_grid: VoxelGrid,
    /// The format and band of samples.
    pub encoding: Encoding,
    /// Number of levels of detail.
    pub levels: u32,
    /// Bytes of everything.
    pub memory_bytes: u64,
    /// Details of an octree.
    pub octree: Option<OctreeInfo>,
    /// Details of sparse bricks.
    pub bricks: Option<BrickInfo>,
}

impl VolumeInfo {
    /// Describes a volume with one level, and without octree or bricks.
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

    /// Describes a volume in memory or in a file.
    pub fn of(volume: &Volume) -> Self {
        volume.info()
    }
}

/// Details of sparse bricks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickInfo {
    /// Cells and bricks.
    pub layout: BrickLayout,
    /// Number of bricks.
    pub bricks: u64,
}

/// Details of an octree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeInfo {
    /// Bricks, and levels of nodes.
    pub layout: OctreeLayout,
    /// Number of bricks.
    pub bricks: u64,
    /// Number of nodes.
    pub nodes: u64,
}

/// Generates [`Volume`] from the list of kinds.
macro_rules! volumes {
    ($($name:ident),*) => {
        /// A volume of any kind.
        #[derive(Clone, PartialEq)]
        #[derive(Debug)]
        pub enum Volume {
            $(#[doc = concat!("[`", stringify!($name), "`](struct@", stringify!($name), ")")] $name($name),)*
        }

        impl Volume {
            /// Returns the voxel grid.
            pub fn voxel_grid(&self) -> &VoxelGrid {
                match self { $(Self::$name(own) => VolumeKind::voxel_grid(own),)* }
            }

            /// Returns the format and band of samples.
            pub fn encoding(&self) -> &Encoding {
                match self { $(Self::$name(own) => VolumeKind::encoding(own),)* }
            }

            /// Returns the bytes of everything.
            pub fn memory_bytes(&self) -> u64 {
                match self { $(Self::$name(own) => VolumeKind::memory_bytes(own),)* }
            }

            /// Describes the volume, without its samples.
            pub fn info(&self) -> VolumeInfo {
                match self { $(Self::$name(own) => own.info(),)* }
            }

            /// Returns the distance at a point of the box: see [`VolumeKind::distance_in`].
            pub fn distance_in(&self, point: Vec3) -> Option<(f32, bool)> {
                match self { $(Self::$name(own) => own.distance_in(point),)* }
            }

            /// Returns the stored material at a point of the surface: see [`VolumeKind::material_at`].
            pub fn material_at(
                &self,
                point: Vec3,
                outward: Vec3,
                palette: &[GpuMaterial],
            ) -> Option<GpuMaterial> {
                match self { $(Self::$name(own) => own.material_at(point, outward, palette),)* }
            }

            /// Sets whether the box clips the solid. Files of version 1 do not say.
            pub fn set_clipped(&mut self, is_cut: bool) {
                match self { $(Self::$name(own) => own.set_clipped(is_cut),)* }
            }

            /// Returns the state for edits in place: see [`VolumeKind::edits`].
            pub fn edits(&self) -> Option<Box<dyn PendingEdits>> {
                match self { $(Self::$name(own) => own.edits(),)* }
            }

            /// Grows to the box that edits have grown to: see [`VolumeKind::grow`].
            pub fn grow(&mut self, edits: &dyn PendingEdits) {
                match self { $(Self::$name(own) => VolumeKind::grow(own, edits),)* }
            }

            /// Processes remaining edits: see [`VolumeKind::edit`].
            ///
            /// # Errors
            /// If the result would exceed `budget` bytes.
            pub fn edit(
                &mut self,
                live: &IncrementalProgram,
                edits: &mut dyn PendingEdits,
                budget: Option<u64>,
                until: Option<Instant>,
            ) -> Result<EditStats, BricksError> {
                match self { $(Self::$name(own) => VolumeKind::edit(own, live, edits, budget, until),)* }
            }

            /// Returns the kind's number, and what a file stores of the volume.
            pub(crate) fn file_parts(&self) -> (u32, FilePart<'_>) {
                match self { $(Self::$name(own) => ($name::KIND, own.file_parts()),)* }
            }

            /// Reads a volume of a kind from a file.
            ///
            /// # Errors
            /// If there is no such kind, its grid does not fit, or the file is damaged.
            pub(crate) fn from_file(
                kind: u32,
                (file, version): (&FileReader<'_>, u32),
                voxel_grid: VoxelGrid,
                encoding: Encoding,
                own: [u32; 3],
            ) -> Result<Self, FromFileError> {
                match kind {
                    $($name::KIND if $name::fits_file(&voxel_grid, version) => {
                        Ok(Self::$name($name::from_file(file, voxel_grid, encoding, own)?))
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

/// The reason why a file's volume cannot be read.
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

/// The list of volume kinds. Each is a name here, and an implementation of the traits in one file per crate. The
/// macro calls another macro with all names.
#[doc(hidden)]
#[macro_export]
macro_rules! all_volumes {
    ($then:ident) => {
        $then!(Dense, Octree, Bricks, Levels);
    };
}

all_volumes!(volumes);
