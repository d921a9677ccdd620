//! Writes a world's distances for other programs.

mod dense;
#[cfg(feature = "png")]
mod flip_book;
mod options;
mod sparse;
mod work;
#[cfg(feature = "zarr")]
mod zarr;

use crate::representation::clip_box;
use crate::{BuildError, World};
use argil_math::Aabb;
use argil_volume::{LevelSetLayout, RESOLUTION_RANGE, VoxelGrid};
pub use options::{
    ExportClass, ExportCodec, ExportError, ExportFormat, ExportOptions, ExportReport,
};
use std::io::{Seek, Write};
use std::path::Path;
use work::{ExportSink, ExportStages, tiles};

impl World {
    /// Writes the world's distances to a file for other programs, in the format of its extension: `.vdb`, `.nvdb`,
    /// `.npy`, `.nrrd`, `.raw` or `.png` (a flip-book). They are sampled from the field, whatever the world's
    /// representation is, at multiples of the voxel size. An infinite scene is cut off at its box, and closed there.
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
        options::check(Some(format), options)?;
        let mut stages = ExportStages::new();
        if self.program().aabb().is_empty() {
            let text = "the scene is empty: there is nothing to write";
            return Err(ExportError::Option(text.into()));
        }
        let is_corrected = format.is_sparse() && !options.keep_bounds;
        let layout = self.export_layout(options, is_corrected)?;
        let what = (format, options);
        let (bounds, voxels) = match format {
            ExportFormat::FlipBook => {
                self.export_flip_book(layout, options, &mut out, &mut stages)?
            }
            _ if format.is_sparse() => sparse::write(self, layout, what, &mut out, &mut stages)?,
            _ => dense::write(self, layout, what, &mut out, &mut stages)?,
        };
        let is_tiled = format == ExportFormat::FlipBook;
        self.engine().control.end();
        Ok(ExportReport {
            voxel_size: layout.voxel_size,
            bounds,
            tiles: bounds
                .filter(|_| is_tiled)
                .map(|[low, high]| tiles((high[2] - low[2] + 1) as u32)),
            voxels,
            is_clipped: layout.is_cut,
            duration_ms: stages.total_ms(),
            stages_ms: stages.all,
        })
    }

    #[cfg(feature = "png")]
    fn export_flip_book(
        &self,
        layout: LevelSetLayout,
        options: &ExportOptions,
        out: &mut &mut dyn ExportSink,
        stages: &mut ExportStages,
    ) -> Result<work::Written, ExportError> {
        flip_book::write(self, layout, options, out, stages)
    }

    #[cfg(not(feature = "png"))]
    fn export_flip_book(
        &self,
        _: LevelSetLayout,
        _: &ExportOptions,
        _: &mut &mut dyn ExportSink,
        _: &mut ExportStages,
    ) -> Result<work::Written, ExportError> {
        let text = "this program was compiled without PNG files (the feature `png`)";
        Err(ExportError::Option(text.into()))
    }

    fn export_layout(
        &self,
        options: &ExportOptions,
        is_corrected: bool,
    ) -> Result<LevelSetLayout, BuildError> {
        let grid = self.export_grid(options)?;
        Ok(LevelSetLayout {
            voxel_size: grid.voxel_size,
            half_width_voxels: options.half_width_voxels,
            region: if grid.is_clipped {
                grid.aabb()
            } else {
                self.program().aabb()
            },
            is_cut: grid.is_clipped,
            is_corrected,
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
