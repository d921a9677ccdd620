//! Formats, options and errors of exported volumes.

use crate::BuildError;
use argil_vdb::Codec;
use std::path::{Path, PathBuf};

/// A file format of volumes that other programs read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[non_exhaustive]
pub enum ExportFormat {
    /// OpenVDB: Blender, Houdini, Unreal.
    Vdb,
    /// NanoVDB: renderers on GPUs.
    Nvdb,
    /// NumPy: an array `[z, y, x]` of 32-bit floats.
    Npy,
    /// NRRD: programs for scans, as 3D Slicer and ParaView.
    Nrrd,
    /// 32-bit floats, x fastest, and a `.json` file with their number and place.
    Raw,
    /// A flip-book for game engines, such as Unity's 3D textures: the layers along z as tiles of a 16-bit grayscale PNG
    /// image, row by row from the top left. [`ExportReport::tiles`] counts them. Distances are from half the band's width
    /// inside, black, to as far outside, white.
    FlipBook,
}

impl ExportFormat {
    /// All formats.
    pub const ALL: [Self; 6] = [
        Self::Vdb,
        Self::Nvdb,
        Self::Npy,
        Self::Nrrd,
        Self::Raw,
        Self::FlipBook,
    ];

    /// Returns the format of a file name's extension.
    pub fn from_path(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_lowercase();
        Self::ALL
            .into_iter()
            .find(|format| format.extension() == ending)
    }

    /// Returns the extension of file names, in lower case.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Vdb => "vdb",
            Self::Nvdb => "nvdb",
            Self::Npy => "npy",
            Self::Nrrd => "nrrd",
            Self::Raw => "raw",
            Self::FlipBook => "png",
        }
    }

    /// Whether the format stores only voxels near the surface.
    pub fn is_sparse(self) -> bool {
        matches!(self, Self::Vdb | Self::Nvdb)
    }
}

/// What the values of an exported volume mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum ExportClass {
    /// Signed distances in the scene's unit, negative inside.
    #[default]
    LevelSet,
    /// Densities: 0 outside, and from the surface inward up to 1 at half the band's width.
    Fog,
}

/// The compression of values in a `.vdb` file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum ExportCodec {
    /// Only active values, as they are. Fastest.
    #[default]
    None,
    /// Zlib. Smallest.
    Zip,
    /// Blosc with LZ4, as OpenVDB compresses by default.
    Blosc,
}

impl From<ExportCodec> for Codec {
    fn from(codec: ExportCodec) -> Self {
        match codec {
            ExportCodec::None => Self::None,
            ExportCodec::Zip => Self::Zip,
            ExportCodec::Blosc => Self::Blosc,
        }
    }
}

/// Options of [`World::export`](crate::World::export).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExportOptions {
    /// Voxels along the longest side of the scene's box.
    pub resolution: u32,
    /// Edge of a voxel in the scene's unit, instead of `resolution`.
    pub voxel_size: Option<f32>,
    /// What the values mean.
    pub class: ExportClass,
    /// Half the width of the band around the surface, in voxels, from 1 to 100. Other voxels of sparse formats have no
    /// values of their own.
    pub half_width_voxels: f32,
    /// `.vdb`, `.nvdb`: whether values stay the field's where these are bounds, as in blends. By default they are divided
    /// by the field's slope there, because programs expect distances.
    pub keep_bounds: bool,
    /// Bits of a value: 32, 16, or 8 for `.nvdb`. Dense formats have 32.
    pub bits: u32,
    /// `.vdb`: the compression.
    pub codec: ExportCodec,
    /// `.vdb`: whether a second grid, `Cd`, holds the materials' linear base colors.
    pub colors: bool,
}

impl Default for ExportOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            voxel_size: None,
            class: ExportClass::default(),
            half_width_voxels: 3.0,
            keep_bounds: false,
            bits: 32,
            codec: ExportCodec::default(),
            colors: false,
        }
    }
}

/// Facts about an exported volume.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExportReport {
    /// Edge of a voxel, in the scene's unit. The voxel with index `i` is at `voxel_size · i`.
    pub voxel_size: f32,
    /// The first and the last voxel with a value, along each axis. `None` if there is none.
    pub bounds: Option<[[i32; 3]; 2]>,
    /// Columns and rows of a flip-book.
    pub tiles: Option<[u32; 2]>,
    /// Voxels that have values of their own.
    pub voxels: u64,
    /// Whether the scene is infinite, and was cut off at its box.
    pub is_clipped: bool,
    /// Total duration in milliseconds.
    pub duration_ms: f64,
    /// Duration of each stage in milliseconds.
    pub stages_ms: Vec<(&'static str, f64)>,
}

/// The reason why a volume cannot be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The voxels are too many or too few, or the work was canceled.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The file name has no extension of a format.
    #[error("{}: unknown volume format; name it .vdb, .nvdb, .npy, .nrrd, .raw or .png", .0.display())]
    UnknownFormat(PathBuf),
    /// An option is out of range, or the format cannot hold it.
    #[error("{0}")]
    Option(String),
    /// The file cannot be written.
    #[error("{}", path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
}

/// Checks options for a format, or for a folder of dense arrays.
pub(super) fn check(
    format: Option<ExportFormat>,
    options: &ExportOptions,
) -> Result<(), ExportError> {
    let refuse = |text: String| Err(ExportError::Option(text));
    let width = options.half_width_voxels;
    if !(1.0..=100.0).contains(&width) {
        return refuse(format!(
            "band of {width} voxels: choose 1 to 100 on each side of the surface"
        ));
    }
    let ending = format.map_or("zarr", ExportFormat::extension);
    let allowed: &[u32] = match format {
        Some(ExportFormat::Vdb) => &[16, 32],
        Some(ExportFormat::Nvdb) => &[8, 16, 32],
        _ => &[32],
    };
    let is_vdb = format == Some(ExportFormat::Vdb);
    if !allowed.contains(&options.bits) {
        return refuse(format!(
            "{} bits: .{ending} files have {}: omit the option",
            options.bits,
            allowed
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join(" or ")
        ));
    }
    if options.colors && !is_vdb {
        return refuse(format!(
            "colors: .{ending} files hold one grid; write a .vdb file"
        ));
    }
    if options.codec != ExportCodec::None && !is_vdb {
        return refuse(format!(
            "compression: .{ending} files have none; write a .vdb file"
        ));
    }
    Ok(())
}
