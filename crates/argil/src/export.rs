//! Writes a world's distances for other programs.

mod dense;
mod sparse;

use crate::representation::clip_box;
use crate::{BuildError, World};
use argil_math::Aabb;
use argil_vdb::Codec;
use argil_volume::{LevelSetLayout, RESOLUTION_RANGE, VoxelGrid};
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};
use web_time::Instant;

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
}

impl ExportFormat {
    /// All formats.
    pub const ALL: [Self; 5] = [Self::Vdb, Self::Nvdb, Self::Npy, Self::Nrrd, Self::Raw];

    /// Returns the format of a file name's extension.
    pub fn from_path(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_lowercase();
        Self::ALL.into_iter().find(|own| own.extension() == ending)
    }

    /// Returns the extension of file names, in lower case.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Vdb => "vdb",
            Self::Nvdb => "nvdb",
            Self::Npy => "npy",
            Self::Nrrd => "nrrd",
            Self::Raw => "raw",
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

/// Options of [`World::export`].
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
    #[error("{}: unknown volume format; name it .vdb, .nvdb, .npy, .nrrd or .raw", .0.display())]
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

/// What volumes are written to. Code for a trait object is compiled with this crate, not with its caller.
trait ExportSink: Write + Seek {}

impl<W: Write + Seek> ExportSink for W {}

/// Measures stages.
struct ExportStages {
    begin: Instant,
    last: Instant,
    all: Vec<(&'static str, f64)>,
}

impl ExportStages {
    fn done(&mut self, stage: &'static str) {
        let now = Instant::now();
        let ms = (now - self.last).as_secs_f64() * 1e3;
        self.all.push((stage, ms));
        self.last = now;
    }
}

impl World {
    /// Writes the world's distances to a file for other programs, in the format of its extension: `.vdb`, `.nvdb`,
    /// `.npy`, `.nrrd` or `.raw`. They are sampled from the field, whatever the world's representation is, at multiples of
    /// the voxel size. An infinite scene is cut off at its box, and closed there.
    ///
    /// ```
    /// # use argil::prelude::*;
    /// use argil::ExportOptions;
    /// # let mut scene = Scene::new();
    /// # scene.push(Shape::sphere(0.5))?;
    /// # let folder = tempfile::tempdir()?;
    /// let world = Engine::cpu().build(&scene)?.field();
    /// let options = ExportOptions { resolution: 64, ..ExportOptions::default() };
    /// let report = world.export(folder.path().join("sphere.vdb"), &options)?;
    /// assert!(report.voxels > 10_000);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the extension is unknown, an option is out of range, the file cannot be written, or the engine's control
    /// canceled the work. The old file stays then.
    pub fn export(
        &self,
        path: impl AsRef<Path>,
        options: &ExportOptions,
    ) -> Result<ExportReport, ExportError> {
        let path = path.as_ref();
        let format =
            ExportFormat::from_path(path).ok_or_else(|| ExportError::UnknownFormat(path.into()))?;
        let failed = |source| ExportError::Write {
            path: path.into(),
            source,
        };
        let mut result = None;
        let written = argil_scene::write_atomically(path, |out| {
            let report = self.export_any(out, format, options);
            let failure = match &report {
                Ok(_) => Ok(()),
                Err(error) => Err(std::io::Error::other(error.to_string())),
            };
            result = Some(report);
            failure
        });
        match (result, written) {
            (Some(Err(ExportError::Write { source, .. })), _) => Err(failed(source)),
            (Some(Err(error)), _) => Err(error),
            (_, Err(error)) => Err(failed(error)),
            (report, Ok(())) => {
                let report = report.unwrap_or_else(|| Ok(ExportReport::default()))?;
                if format == ExportFormat::Raw {
                    let place = path.with_extension("raw.json");
                    let text = dense::sidecar(&report, path);
                    argil_scene::write_atomically(&place, |out| out.write_all(text.as_bytes()))
                        .map_err(|source| ExportError::Write {
                            path: place.clone(),
                            source,
                        })?;
                }
                Ok(report)
            }
        }
    }

    /// Writes distances as [`World::export`] does, to a stream.
    ///
    /// # Errors
    /// If an option is out of range, `out` fails, or the engine's control canceled the work.
    pub fn export_to(
        &self,
        out: &mut (impl Write + Seek),
        format: ExportFormat,
        options: &ExportOptions,
    ) -> Result<ExportReport, ExportError> {
        self.export_any(out, format, options)
    }

    fn export_any(
        &self,
        mut out: &mut dyn ExportSink,
        format: ExportFormat,
        options: &ExportOptions,
    ) -> Result<ExportReport, ExportError> {
        check(format, options)?;
        let now = Instant::now();
        let mut stages = ExportStages {
            begin: now,
            last: now,
            all: Vec::new(),
        };
        let grid = self.export_grid(options)?;
        let layout = LevelSetLayout {
            voxel_size: grid.voxel_size,
            half_width_voxels: options.half_width_voxels,
            region: if grid.is_clipped {
                grid.aabb()
            } else {
                self.program().aabb()
            },
            is_cut: grid.is_clipped,
            is_corrected: format.is_sparse() && !options.keep_bounds,
        };
        let what = (format, options);
        let (bounds, voxels) = match format.is_sparse() {
            true => sparse::write(self, layout, what, &mut out, &mut stages)?,
            false => dense::write(self, layout, what, &mut out, &mut stages)?,
        };
        self.engine().control.end();
        Ok(ExportReport {
            voxel_size: grid.voxel_size,
            bounds,
            voxels,
            is_clipped: grid.is_clipped,
            duration_ms: stages.begin.elapsed().as_secs_f64() * 1e3,
            stages_ms: stages.all,
        })
    }

    fn export_grid(&self, options: &ExportOptions) -> Result<VoxelGrid, BuildError> {
        let solid = self.program().aabb();
        let frame = clip_box(&self.scene, solid);
        let most = *RESOLUTION_RANGE.end();
        let empty = solid.is_empty().then_some(Aabb::EMPTY);
        Ok(match options.voxel_size {
            Some(voxel) => VoxelGrid::with_voxel_size(solid, frame.or(empty), voxel, most)?,
            None => VoxelGrid::fitting(solid, frame.or(empty), options.resolution)?,
        })
    }

    fn check_export_cancelled(&self) -> Result<(), ExportError> {
        match self.engine().control.is_cancelled() {
            true => Err(BuildError::Cancelled.into()),
            false => Ok(()),
        }
    }
}

fn check(format: ExportFormat, options: &ExportOptions) -> Result<(), ExportError> {
    let refuse = |text: String| Err(ExportError::Option(text));
    let width = options.half_width_voxels;
    if !(1.0..=100.0).contains(&width) {
        return refuse(format!(
            "band of {width} voxels: choose 1 to 100 on each side of the surface"
        ));
    }
    let ending = format.extension();
    let allowed: &[u32] = match format {
        ExportFormat::Vdb => &[16, 32],
        ExportFormat::Nvdb => &[8, 16, 32],
        _ => &[32],
    };
    if !allowed.contains(&options.bits) {
        return refuse(format!(
            "{} bits: .{ending} files have {allowed:?}",
            options.bits
        ));
    }
    if options.colors && format != ExportFormat::Vdb {
        return refuse(format!(
            "colors: .{ending} files hold one grid; write a .vdb file"
        ));
    }
    if options.codec != ExportCodec::None && format != ExportFormat::Vdb {
        return refuse(format!(
            "compression: .{ending} files have none; write a .vdb file"
        ));
    }
    Ok(())
}

fn write_failed(source: std::io::Error) -> ExportError {
    ExportError::Write {
        path: PathBuf::new(),
        source,
    }
}

/// Returns the density of a distance.
fn density(distance: f32, half_width: f32) -> f32 {
    (-distance / half_width).clamp(0.0, 1.0)
}
