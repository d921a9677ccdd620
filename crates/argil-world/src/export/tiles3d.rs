//! 3D Tiles 1.1 with implicit tiling (<https://docs.ogc.org/cs/22-025r4/22-025r4.html>): an octree of glTF meshes.
//!
//! A mesh has 64³ voxels of its level. Its triangles are those of marching cubes over the samples of the world's tiles, so meshes of
//! one level fit one another. Those of different levels do not: strips behind their borders hide the gaps.

use super::cells::{CELL, CellReader, Samples};
use super::subtree::{Availability, Place, SUBTREE_LEVELS};
use super::{GENERATOR, WorldExportReport, begin, failed};
use crate::{ReadMode, StoredWorld, WorldError};
use argil::abi::GpuMaterial;
use argil::field::Grid;
use argil::glam::{IVec3, UVec3, Vec3};
use argil::math::Control;
use argil::mesh::{Mesh, MeshFormat, MeshWriteOptions};
use argil::volume::{LevelsLayout, TileAddress, TileSource};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use serde_json::json;
use std::path::Path;
use std::sync::Arc;

/// Cells along the side of a mesh.
const CELLS: i32 = 8;
/// What tells that a folder holds such tiles.
const MARK: &str = "tileset.json";

/// A mesh to make: its level of the world, and its position in meshes of that level.
type Chunk = (u32, IVec3);

/// What became of it.
struct Made {
    /// The bytes of a glTF file, if there are triangles.
    glb: Option<Vec<u8>>,
    triangles: u64,
    has_surface: bool,
    is_refined: bool,
    missing: Vec<TileAddress>,
}

/// Where the octree lies.
struct Frame {
    /// The level of the world whose meshes are the root's children.
    top: u32,
    /// The first of them.
    first: IVec3,
}

impl Frame {
    fn of(layout: &LevelsLayout) -> Self {
        let grid = *layout.level(0).voxel_grid();
        let side = (CELLS as u32 * CELL as u32).ilog2();
        let last = grid.begin + grid.size.as_ivec3() - 1;
        let span = |level: u32| [grid.begin >> (side + level), last >> (side + level)];
        let fits = |level: &u32| {
            let [low, high] = span(*level);
            (high - low).max_element() <= 1
        };
        let top = (0..layout.root()).find(fits).unwrap_or(layout.root());
        Self {
            top,
            first: span(top)[0],
        }
    }

    /// Returns the place of a mesh in the octree.
    fn place(&self, (level, chunk): Chunk) -> Place {
        let first = self.first << (self.top - level);
        let place = (chunk - first).as_uvec3();
        (self.top - level + 1, place.to_array())
    }
}

impl StoredWorld {
    /// Writes the world as 3D Tiles into a folder: `tileset.json`, subtrees, and a glTF mesh with normals and colors for each part of
    /// each level. `voxel_size` is that of the finest level that is wanted, by default of the world's. Edits that were saved
    /// beside the world are not part of it.
    ///
    /// # Errors
    /// If the folder cannot be written, or exists and is something else; the voxel size is no length; or the work was canceled.
    pub fn export_3d_tiles(
        &self,
        path: impl AsRef<Path>,
        voxel_size: Option<f32>,
        control: &Control,
    ) -> Result<WorldExportReport, WorldError> {
        let path = path.as_ref();
        let prepared = self.plan().prepare(self.planned_scene())?;
        let (layout, palette) = (prepared.layout, prepared.palette());
        let source = self.source(ReadMode::Wait);
        let frame = Frame::of(&layout);
        let top = frame.top;
        let finest = self.plan().level_of(voxel_size, top)?;
        let folder = begin(path, MARK)?;
        let mut report = WorldExportReport {
            edits_left_out: self.deltas().len() as u64,
            ..WorldExportReport::default()
        };
        let mut all = Availability::default();
        all.add((0, [0; 3]), false);
        let mut missing: FxHashSet<TileAddress> = FxHashSet::default();
        let pairs = (0..8).map(|i| frame.first + IVec3::new(i & 1, i >> 1 & 1, i >> 2));
        let mut chunks: Vec<Chunk> = pairs.map(|chunk| (top, chunk)).collect();
        for level in (finest..=top).rev() {
            control.begin("meshes", chunks.len() as u64);
            let made: Result<Vec<Made>, WorldError> = chunks
                .par_iter()
                .map(|chunk| {
                    if control.is_cancelled() {
                        return Err(WorldError::Cancelled);
                    }
                    let made = mesh_of(*chunk, &source, &layout, &palette);
                    if let Some(glb) = &made.glb {
                        let (level, [x, y, z]) = frame.place(*chunk);
                        let name = format!("content/{level}/{x}/{y}/{z}.glb");
                        put(folder.path(), &name, glb).map_err(|error| failed(path, error))?;
                    }
                    control.advance(1);
                    Ok(Made {
                        glb: made.glb.map(|glb| glb[..0].to_vec()),
                        triangles: made.triangles,
                        ..made
                    })
                })
                .collect();
            let made = made?;
            let mut finer = Vec::new();
            for (&(_, chunk), content) in chunks.iter().zip(&made) {
                missing.extend(content.missing.iter().copied());
                if !content.has_surface {
                    continue;
                }
                all.add(frame.place((level, chunk)), content.glb.is_some());
                report.files += u64::from(content.glb.is_some());
                report.triangles += content.triangles;
                if content.is_refined && level > finest {
                    let octants = (0..8).map(|i| IVec3::new(i & 1, i >> 1 & 1, i >> 2));
                    finer.extend(octants.map(|place| (level - 1, 2 * chunk + place)));
                }
            }
            chunks = finer;
            report.levels += 1;
        }
        for ((level, [x, y, z]), bytes) in all.subtrees() {
            let name = format!("subtrees/{level}/{x}/{y}/{z}.subtree");
            put(folder.path(), &name, &bytes).map_err(|error| failed(path, error))?;
        }
        let text = tileset(&layout, &frame, finest).to_string();
        put(folder.path(), MARK, text.as_bytes()).map_err(|error| failed(path, error))?;
        report.bytes = bytes_of(folder.path());
        report.missing = missing.len() as u64;
        super::check_any(&report, self.plan().tile_count(), missing.iter().next())?;
        folder.persist(path).map_err(|error| failed(path, error))?;
        Ok(report)
    }
}

fn put(folder: &Path, name: &str, bytes: &[u8]) -> std::io::Result<()> {
    let path = folder.join(name);
    // It is gone once the program was interrupted, and is not to come back.
    std::fs::read_dir(folder)?;
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent)?;
    }
    std::fs::write(path, bytes)
}

/// Returns the bytes of all files in a folder.
pub(super) fn bytes_of(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let sizes = entries.map(|entry| match entry.metadata() {
        Ok(about) if about.is_dir() => bytes_of(&entry.path()),
        Ok(about) => about.len(),
        Err(_) => 0,
    });
    sizes.sum()
}

/// Describes the tiles. Theirs have z up: y of glTF is z there, and the octree's axes are turned so that they are those of the world.
fn tileset(layout: &LevelsLayout, frame: &Frame, finest: u32) -> serde_json::Value {
    let voxel = layout.level(0).voxel_grid().voxel_size;
    let side = voxel * (CELLS * CELL as i32) as f32 * (1u32 << frame.top) as f32;
    let corner = layout.level(0).voxel_grid().corner;
    let center = corner + side * (frame.first.as_vec3() + 1.0);
    let turned = |v: Vec3| [v.x, -v.z, v.y];
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| turned(side * axis));
    let numbers: Vec<f32> = [turned(center)]
        .iter()
        .chain(&axes)
        .flatten()
        .copied()
        .collect();
    let levels = frame.top - finest + 2;
    // Of the finest level: a voxel. Each coarser one has twice the error.
    let error = voxel * (1u64 << (frame.top + 1)) as f32;
    json!({
        "asset": {"version": "1.1", "generator": GENERATOR},
        "geometricError": error,
        "root": {
            "boundingVolume": {"box": numbers},
            "geometricError": error,
            "refine": "REPLACE",
            "content": {"uri": "content/{level}/{x}/{y}/{z}.glb"},
            "implicitTiling": {
                "subdivisionScheme": "OCTREE",
                "subtreeLevels": SUBTREE_LEVELS,
                "availableLevels": levels,
                "subtrees": {"uri": "subtrees/{level}/{x}/{y}/{z}.subtree"},
            },
        },
    })
}

fn mesh_of(
    (level, chunk): Chunk,
    source: &Arc<dyn TileSource>,
    layout: &LevelsLayout,
    palette: &[GpuMaterial],
) -> Made {
    let mut reader = CellReader::new(&**source, layout);
    let first = CELLS * chunk;
    let mut samples = Samples::new(CELLS as usize);
    // With a cell more at each side, for normals.
    let mut around = Samples::new(CELLS as usize + 2);
    let (mut has_surface, mut is_refined) = (false, false);
    reader.visit(level, [first - 1, first + CELLS + 1], &mut |cell| {
        if !cell.has_surface {
            return;
        }
        let distances = cell.distances();
        let inner = cell.cell - first;
        around.put((inner + 1).to_array().map(|c| c as usize), &distances);
        if inner.cmpge(IVec3::ZERO).all() && inner.cmplt(IVec3::splat(CELLS)).all() {
            samples.put(inner.to_array().map(|c| c as usize), &distances);
            has_surface = true;
            is_refined |= cell.is_refined();
        }
    });
    let mut made = Made {
        glb: None,
        triangles: 0,
        has_surface,
        is_refined,
        missing: Vec::new(),
    };
    if has_surface && samples.flood(layout.level(0).encoding().band.voxels()) {
        // In voxels, from the corner.
        let grid = Grid {
            min: Vec3::ZERO,
            spacing: Vec3::ONE,
            begin: UVec3::ZERO,
            size: UVec3::splat(samples.side() as u32),
        };
        let mut mesh = argil::mesh::marching::dense::march(&samples.values, &grid, 0.0, false);
        if !mesh.triangles.is_empty() {
            mesh.normals = mesh.positions.iter().map(|&p| normal(&around, p)).collect();
            mesh.materials = materials(&mut reader, (level, first), &mesh, palette);
            add_strips(&mut mesh, samples.side() as f32 - 1.0);
            let voxel = layout.level(level).voxel_grid().voxel_size;
            let begin = (CELL as i32 * first).as_vec3();
            let corner = layout.level(0).voxel_grid().corner;
            for position in &mut mesh.positions {
                *position = corner + voxel * (begin + *position);
            }
            let mut glb = Vec::new();
            let format = MeshFormat::Glb;
            let written = argil::mesh::write(&mesh, format, &MeshWriteOptions::default(), &mut glb);
            made.glb = written.is_ok().then_some(glb);
            made.triangles = mesh.triangles.len() as u64;
        }
    }
    made.missing = reader.missing;
    made
}

/// Returns the gradient at a position in voxels, one cell inside of the samples.
fn normal(around: &Samples, at: Vec3) -> Vec3 {
    let at = at + CELL as f32;
    let side = around.side();
    let first = at.floor().min(Vec3::splat(side as f32 - 3.0));
    let share = at - first;
    let [x, y, z] = first.to_array().map(|c| c as isize);
    let value = |dx: isize, dy: isize, dz: isize| {
        let place = [x + dx, y + dy, z + dz].map(|c| c as usize);
        around.values[place[0] + side * (place[1] + side * place[2])]
    };
    let mut sum = Vec3::ZERO;
    for corner in 0..8isize {
        let [i, j, k] = [corner & 1, corner >> 1 & 1, corner >> 2];
        let weight = |bit: isize, share: f32| if bit == 1 { share } else { 1.0 - share };
        let weight = weight(i, share.x) * weight(j, share.y) * weight(k, share.z);
        let middle = value(i, j, k);
        // Beyond the cells with surface nothing is known: one side only.
        let slope = |low: f32, high: f32| match (low.is_nan(), high.is_nan()) {
            (false, false) => 0.5 * (high - low),
            (true, false) => high - middle,
            (false, true) => middle - low,
            (true, true) => 0.0,
        };
        let gradient = Vec3::new(
            slope(value(i - 1, j, k), value(i + 1, j, k)),
            slope(value(i, j - 1, k), value(i, j + 1, k)),
            slope(value(i, j, k - 1), value(i, j, k + 1)),
        );
        if gradient.is_finite() {
            sum += weight * gradient;
        }
    }
    sum.try_normalize().unwrap_or(Vec3::Y)
}

/// Returns the material of each vertex.
fn materials(
    reader: &mut CellReader<'_>,
    (level, first): (u32, IVec3),
    mesh: &Mesh,
    palette: &[GpuMaterial],
) -> Vec<GpuMaterial> {
    let default = palette.first().copied().unwrap_or_default();
    if palette.len() < 2 {
        return vec![default; mesh.positions.len()];
    }
    let mut of_cells: FxHashMap<IVec3, Vec<usize>> = FxHashMap::default();
    for (index, position) in mesh.positions.iter().enumerate() {
        let cell = (*position / CELL as f32)
            .as_ivec3()
            .min(IVec3::splat(CELLS - 1));
        of_cells.entry(cell).or_default().push(index);
    }
    let mut found = vec![default; mesh.positions.len()];
    reader.visit(level, [first, first + CELLS], &mut |found_cell| {
        let inner = found_cell.cell - first;
        for &index in of_cells.get(&inner).into_iter().flatten() {
            let at = mesh.positions[index] - (CELL as i32 * inner).as_vec3();
            let material = found_cell.material(at, mesh.normals[index], palette);
            found[index] = material.unwrap_or(default);
        }
    });
    found
}

/// Adds a strip of two voxels behind each border, which hides gaps to coarser meshes.
fn add_strips(mesh: &mut Mesh, side: f32) {
    let mut edges: FxHashMap<[u32; 2], i32> = FxHashMap::default();
    for &[a, b, c] in &mesh.triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *edges.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    let is_border = |p: Vec3| p.min_element() <= 0.0 || p.max_element() >= side;
    let mut behind: FxHashMap<u32, u32> = FxHashMap::default();
    let mut strips = Vec::new();
    for &[a, b, c] in &mesh.triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let is_open = edges[&[from.min(to), from.max(to)]] == 1;
            let ends = [from, to].map(|v| mesh.positions[v as usize]);
            if is_open && ends.into_iter().all(is_border) {
                strips.push([from, to]);
            }
        }
    }
    for [from, to] in strips {
        let [low_from, low_to] = [from, to].map(|vertex| {
            *behind.entry(vertex).or_insert_with(|| {
                let index = vertex as usize;
                let position = mesh.positions[index] - 2.0 * mesh.normals[index];
                mesh.positions.push(position);
                mesh.normals.push(mesh.normals[index]);
                mesh.materials.push(mesh.materials[index]);
                (mesh.positions.len() - 1) as u32
            })
        });
        mesh.triangles.push([to, from, low_from]);
        mesh.triangles.push([to, low_from, low_to]);
    }
}
