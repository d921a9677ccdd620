//! OME-Zarr: a folder with an array for each resolution (<https://ngff.openmicroscopy.org/0.5/>), whose chunks lie in
//! shards (<https://zarr-specs.readthedocs.io/en/latest/v3/codecs/sharding-indexed/>).

use super::dense::sample;
use super::options::{ExportError, ExportOptions, ExportReport};
use super::work::ExportStages;
use crate::World;
use argil_field::Grid;
use argil_scene::TempFolder;
use argil_volume::LevelSetLayout;
use glam::{IVec3, UVec3, Vec3};
use std::path::Path;
use std::sync::Arc;
use zarrs::array::{ArrayBuilder, data_type};
use zarrs::filesystem::FilesystemStore;
use zarrs::group::GroupBuilder;

/// Values along the side of a shard, which is a file, and of a chunk.
const SHARD: u32 = 128;
const CHUNK: u64 = 32;
/// The file of a Zarr folder that tells which program generated it, and that program.
const MARK: &str = "zarr.json";
const GENERATOR: &str = concat!("argil ", env!("CARGO_PKG_VERSION"));
/// The coarsest array has at most this many values along a side.
const COARSEST: u32 = 64;

/// An array of the pyramid.
struct Level {
    voxel_size: f32,
    low: IVec3,
    size: UVec3,
}

impl World {
    /// Writes the world's distances to an OME-Zarr folder (version 0.5, Zarr 3), for programs that read parts of large
    /// volumes: arrays `[z, y, x]` of 32-bit floats, each with voxels twice as long as those of the one before. Each is
    /// sampled from the field. A folder that is there is replaced if it is empty, or if Argil wrote it.
    ///
    /// # Errors
    /// If an option is out of range, the folder cannot be written or is something else, or the engine's control canceled
    /// the work.
    pub fn export_zarr(
        &self,
        path: impl AsRef<Path>,
        options: &ExportOptions,
    ) -> Result<ExportReport, ExportError> {
        self.export_folder(path.as_ref(), options)
    }

    fn export_folder(
        &self,
        path: &Path,
        options: &ExportOptions,
    ) -> Result<ExportReport, ExportError> {
        let failed = |source: std::io::Error| ExportError::Write {
            path: path.into(),
            source,
        };
        // Before any work.
        let made = TempFolder::for_export(path, MARK).map_err(failed)?;
        super::options::check(None, options)?;
        let mut stages = ExportStages::new();
        let layout = self.export_layout(options, false)?;
        let levels = levels(&layout)?;
        self.write_levels(made.path(), &layout, options, &levels, &mut stages)
            .map_err(|error| match error {
                ExportError::Write { source, .. } => failed(source),
                error => error,
            })?;
        made.persist(path).map_err(failed)?;
        self.engine().control.end();
        let finest = &levels[0];
        let high = finest.low + finest.size.as_ivec3() - 1;
        Ok(ExportReport {
            voxel_size: layout.voxel_size,
            tiles: None,
            bounds: Some([finest.low.to_array(), high.to_array()]),
            voxels: levels.iter().map(|level| level.count()).sum(),
            is_clipped: layout.is_cut,
            duration_ms: stages.total_ms(),
            stages_ms: stages.all,
        })
    }

    fn write_levels(
        &self,
        folder: &Path,
        layout: &LevelSetLayout,
        options: &ExportOptions,
        levels: &[Level],
        stages: &mut ExportStages,
    ) -> Result<(), ExportError> {
        let failed = |error: &dyn std::fmt::Display| ExportError::Write {
            path: folder.into(),
            source: std::io::Error::other(error.to_string()),
        };
        let store = FilesystemStore::new(folder).map_err(|error| failed(&error))?;
        let store: zarrs::storage::ReadableWritableListableStorage = Arc::new(store);
        let mut attributes = serde_json::Map::new();
        attributes.insert("ome".into(), multiscales(levels));
        attributes.insert("generator".into(), GENERATOR.into());
        let group = GroupBuilder::new()
            .attributes(attributes)
            .build(store.clone(), "/");
        let group = group.map_err(|error| failed(&error))?;
        group.store_metadata().map_err(|error| failed(&error))?;
        let control = &self.engine().control;
        let shards = |level: &Level| level.shards().count() as u64;
        control.begin("shards", levels.iter().map(shards).sum());
        for (i, level) in levels.iter().enumerate() {
            let [nx, ny, nz] = level.size.to_array().map(u64::from);
            let side = u64::from(SHARD);
            let array = ArrayBuilder::new(
                vec![nz, ny, nx],
                vec![side; 3],
                data_type::float32(),
                f32::NAN,
            )
            .subchunk_shape(vec![CHUNK; 3])
            .dimension_names(["z", "y", "x"].into())
            .build(store.clone(), &format!("/{i}"))
            .map_err(|error| failed(&error))?;
            array.store_metadata().map_err(|error| failed(&error))?;
            for shard in level.shards() {
                self.check_export_cancelled()?;
                let values = level.shard(self, layout, options, shard);
                let place = [shard.z, shard.y, shard.x].map(u64::from);
                array
                    .store_chunk(&place, values)
                    .map_err(|error| failed(&error))?;
                control.advance(1);
            }
        }
        stages.done("shards");
        Ok(())
    }
}

impl Level {
    fn count(&self) -> u64 {
        self.size.to_array().map(u64::from).iter().product()
    }

    fn shards(&self) -> impl Iterator<Item = UVec3> {
        let [nx, ny, nz] = self.size.to_array().map(|n| n.div_ceil(SHARD));
        (0..nx * ny * nz).map(move |i| UVec3::new(i % nx, i / nx % ny, i / nx / ny))
    }

    /// Samples a shard. Beyond the box there is no number.
    fn shard(
        &self,
        world: &World,
        layout: &LevelSetLayout,
        options: &ExportOptions,
        shard: UVec3,
    ) -> Vec<f32> {
        let begin = SHARD * shard;
        let part = Grid {
            min: self.voxel_size * self.low.as_vec3(),
            spacing: Vec3::splat(self.voxel_size),
            begin,
            size: (self.size - begin).min(UVec3::splat(SHARD)),
        };
        let samples = sample(world, layout, options.class, &part);
        let side = SHARD as usize;
        let mut values = vec![f32::NAN; side * side * side];
        let [nx, ny] = [part.size.x as usize, part.size.y as usize];
        for (row, row_samples) in samples.chunks(nx).enumerate() {
            let first = (row / ny * side + row % ny) * side;
            values[first..first + nx].copy_from_slice(row_samples);
        }
        values
    }
}

fn levels(layout: &LevelSetLayout) -> Result<Vec<Level>, ExportError> {
    if layout.region.is_empty() {
        let text = "the scene is empty: there is no box to sample";
        return Err(ExportError::Option(text.into()));
    }
    let mut levels = Vec::new();
    loop {
        let voxel_size = layout.voxel_size * (1 << levels.len()) as f32;
        let low = (layout.region.min / voxel_size).floor().as_ivec3() - 1;
        let high = (layout.region.max / voxel_size).ceil().as_ivec3() + 1;
        let size = (high - low + 1).as_uvec3();
        levels.push(Level {
            voxel_size,
            low,
            size,
        });
        if size.max_element() <= COARSEST || levels.len() > 16 {
            return Ok(levels);
        }
    }
}

/// Describes the arrays as OME-Zarr does.
fn multiscales(levels: &[Level]) -> serde_json::Value {
    let axis = |name: &str| serde_json::json!({"name": name, "type": "space"});
    let datasets: Vec<_> = levels
        .iter()
        .enumerate()
        .map(|(i, level)| {
            let [x, y, z] = (level.voxel_size * level.low.as_vec3()).to_array();
            let scale = [level.voxel_size; 3];
            serde_json::json!({
                "path": i.to_string(),
                "coordinateTransformations": [
                    {"type": "scale", "scale": scale},
                    {"type": "translation", "translation": [z, y, x]},
                ],
            })
        })
        .collect();
    serde_json::json!({
        "version": "0.5",
        "multiscales": [{
            "name": "distance",
            "axes": [axis("z"), axis("y"), axis("x")],
            "datasets": datasets,
        }],
    })
}
