//! OME-Zarr: a folder with an array for each level (<https://ngff.openmicroscopy.org/0.5/>), whose chunks lie in shards
//! (<https://zarr-specs.readthedocs.io/en/latest/v3/codecs/sharding-indexed/>).

use super::cells::{CELL, CellReader, Samples};
use super::tiles3d::bytes_of;
use super::{GENERATOR, WorldExportReport, begin, failed};
use crate::{ReadMode, StoredWorld, WorldError};
use argil::Engine;
use argil::glam::{IVec3, Vec3};
use argil::math::Control;
use argil::volume::{LevelsLayout, TileAddress};
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use zarrs::array::codec::GzipCodec;
use zarrs::array::{ArrayBuilder, data_type};
use zarrs::filesystem::FilesystemStore;
use zarrs::group::GroupBuilder;

/// Cells along the side of a shard, which is a file.
const CELLS: i32 = 16;
const SHARD: i32 = CELLS * CELL as i32;
/// Values along the side of a chunk.
const CHUNK: u64 = 32;
/// What tells that a folder is such an array.
const MARK: &str = "zarr.json";

/// An array: a level of the world.
struct Level {
    level: u32,
    voxel_size: f32,
    /// The minimum corner of voxel 0, in the scene's space.
    corner: Vec3,
    /// The first voxel. All levels count from the same corner.
    begin: IVec3,
    size: IVec3,
    band: f32,
}

impl Level {
    fn of(layout: &LevelsLayout, level: u32) -> Self {
        let layout_of_level = layout.level(level);
        let grid = *layout_of_level.voxel_grid();
        // Whole cells. Without the corners at the end, which no cell of a shard of their own would hold.
        let begin = CELL as i32 * (grid.begin >> 3);
        let end = grid.begin + grid.size.as_ivec3();
        Self {
            level,
            voxel_size: grid.voxel_size,
            corner: grid.corner,
            begin,
            size: end - begin,
            band: grid.voxel_size * layout.level(0).encoding().band.voxels(),
        }
    }

    fn shards(&self) -> Vec<IVec3> {
        let [nx, ny, nz] = ((self.size + SHARD - 1) / SHARD).to_array();
        let all = (0..nx * ny * nz).map(|i| IVec3::new(i % nx, i / nx % ny, i / nx / ny));
        all.collect()
    }
}

impl StoredWorld {
    /// Writes the world's distances to an OME-Zarr folder (version 0.5, Zarr 3, in shards of 128³ and chunks of 32³, packed by gzip):
    /// arrays `[z, y, x]` of 32-bit floats at the corners of voxels, in the scene's unit, each with voxels twice as long as those
    /// of the one before. Distances end at the width of the band, on both sides. Within a voxel of the surface they are those of the
    /// field; farther away they are interpolated from coarser levels, and can be off by two voxels, also too large. `voxel_size` is that of the finest array, by
    /// default the world's. Edits that were saved beside the world are not part of it.
    ///
    /// # Errors
    /// If the folder cannot be written, or exists and is something else; the voxel size is no length; or the work was canceled.
    pub fn export_zarr(
        &self,
        path: impl AsRef<Path>,
        voxel_size: Option<f32>,
        control: &Control,
    ) -> Result<WorldExportReport, WorldError> {
        let path = path.as_ref();
        let prepared = self.plan().prepare(self.planned_scene())?;
        let layout = prepared.layout;
        let finest = self.plan().level_of(voxel_size, layout.root())?;
        let levels: Vec<Level> = (finest..=layout.root())
            .map(|level| Level::of(&layout, level))
            .collect();
        let folder = begin(path, MARK)?;
        let wrong =
            |error: &dyn std::fmt::Display| failed(path, std::io::Error::other(error.to_string()));
        let store = FilesystemStore::new(folder.path()).map_err(|error| wrong(&error))?;
        let store: zarrs::storage::ReadableWritableListableStorage = Arc::new(store);
        let mut attributes = serde_json::Map::new();
        attributes.insert("ome".into(), multiscales(&levels));
        attributes.insert("generator".into(), GENERATOR.into());
        let group = GroupBuilder::new()
            .attributes(attributes)
            .build(store.clone(), "/");
        let group = group.map_err(|error| wrong(&error))?;
        group.store_metadata().map_err(|error| wrong(&error))?;
        // Only where no surface is near: which side that is on.
        let field = Engine::cpu().build(self.planned_scene())?.field();
        let query = field.query();
        let source = self.source(ReadMode::Wait);
        let mut missing: FxHashSet<TileAddress> = FxHashSet::default();
        let files = AtomicU64::new(0);
        for (index, level) in levels.iter().enumerate() {
            let [nx, ny, nz] = level.size.to_array().map(|n| n as u64);
            let codec = GzipCodec::new(4).map_err(|error| wrong(&error))?;
            let array = ArrayBuilder::new(
                vec![nz, ny, nx],
                vec![SHARD as u64; 3],
                data_type::float32(),
                level.band,
            )
            .subchunk_shape(vec![CHUNK; 3])
            .bytes_to_bytes_codecs(vec![Arc::new(codec)])
            .dimension_names(["z", "y", "x"].into())
            .build(store.clone(), &format!("/{index}"))
            .map_err(|error| wrong(&error))?;
            array.store_metadata().map_err(|error| wrong(&error))?;
            let shards = level.shards();
            control.begin("shards", shards.len() as u64);
            let lost: Result<Vec<Vec<TileAddress>>, WorldError> = shards
                .par_iter()
                .map(|&shard| {
                    if control.is_cancelled() {
                        return Err(WorldError::Cancelled);
                    }
                    let mut reader = CellReader::new(&*source, &layout);
                    let outside = || {
                        let middle = level.begin + SHARD * shard + SHARD / 2;
                        let middle = level.corner + level.voxel_size * middle.as_vec3();
                        let mut d = [0.0];
                        query.distances(&[middle.to_array()], &mut d);
                        d[0] > 0.0
                    };
                    if let Some(values) = values_of(level, shard, &mut reader, outside) {
                        let place = [shard.z, shard.y, shard.x].map(|c| c as u64);
                        array
                            .store_chunk(&place, values)
                            .map_err(|error| wrong(&error))?;
                        files.fetch_add(1, Ordering::Relaxed);
                    }
                    control.advance(1);
                    Ok(reader.missing)
                })
                .collect();
            missing.extend(lost?.into_iter().flatten());
        }
        let report = WorldExportReport {
            levels: levels.len() as u32,
            files: files.into_inner(),
            bytes: bytes_of(folder.path()),
            triangles: 0,
            missing: missing.len() as u64,
            edits_left_out: self.deltas().len() as u64,
        };
        super::check_any(&report, self.plan().tile_count(), missing.iter().next())?;
        folder.persist(path).map_err(|error| failed(path, error))?;
        Ok(report)
    }
}

/// Returns the values of a shard, or `None` if all of it is far outside.
fn values_of(
    level: &Level,
    shard: IVec3,
    reader: &mut CellReader<'_>,
    outside: impl Fn() -> bool,
) -> Option<Vec<f32>> {
    let first = (level.begin + SHARD * shard) / CELL as i32;
    let mut samples = Samples::new(CELLS as usize);
    reader.visit(level.level, [first, first + CELLS], &mut |cell| {
        let inner = (cell.cell - first).to_array().map(|c| c as usize);
        if cell.has_surface {
            samples.put(inner, &cell.distances());
        } else {
            samples.put_far(inner, &cell.distances());
        }
    });
    let side = SHARD as usize;
    let band = level.band / level.voxel_size;
    let before = samples.values.clone();
    let found = if samples.flood(band) {
        samples.mend(&before, band);
        samples.values.clone()
    } else {
        match samples.without_surface(band) {
            Some(values) => values,
            None => {
                return (!outside()).then(|| vec![-level.band; side * side * side]);
            }
        }
    };
    if found.iter().all(|&value| value >= band) {
        return None;
    }
    let all = samples.side();
    let mut values = Vec::with_capacity(side * side * side);
    for row in 0..side * side {
        let from = all * (row % side + all * (row / side));
        let distances = &found[from..from + side];
        values.extend(distances.iter().map(|value| level.voxel_size * value));
    }
    Some(values)
}

/// Describes the arrays as OME-Zarr does.
fn multiscales(levels: &[Level]) -> Value {
    let axis = |name: &str| json!({"name": name, "type": "space"});
    let datasets: Vec<Value> = levels
        .iter()
        .enumerate()
        .map(|(index, level)| {
            let [x, y, z] = (level.corner + level.voxel_size * level.begin.as_vec3()).to_array();
            let scale = [level.voxel_size; 3];
            json!({
                "path": index.to_string(),
                "coordinateTransformations": [
                    {"type": "scale", "scale": scale},
                    {"type": "translation", "translation": [z, y, x]},
                ],
            })
        })
        .collect();
    json!({
        "version": "0.5",
        "multiscales": [{
            "name": "distance",
            "axes": [axis("z"), axis("y"), axis("x")],
            "datasets": datasets,
        }],
    })
}
