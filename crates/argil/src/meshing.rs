//! Extracts triangle meshes from worlds.

use crate::build_context::BuildContext;
use crate::device::Device;
use crate::field_mesh::{MeshMethod, Stages, field_mesh, layout_of};
use crate::mesh_error::MeshError;
use crate::mesh_options::MeshOptions;
use crate::representation::clip_box;
use crate::vertex_error::VertexError;
use crate::{BuildError, World};
use argil_math::Aabb;
use argil_mesh::{
    Mesh, MeshFormat, MeshNormals, MeshReport, MeshSdf, MeshWriteOptions, project_to_field,
    simplify, write,
};
use argil_scene::{Extents, Scene};
use argil_volume::{CellPrograms, RESOLUTION_RANGE, Volume, VoxelGrid};
use glam::Vec3;
use rayon::prelude::*;
use std::path::Path;
use web_time::Instant;

/// A mesh, with a report.
#[derive(Clone, Debug)]
pub struct MeshOutput {
    /// The mesh.
    pub mesh: Mesh,
    /// The voxel grid that it was extracted from.
    pub voxel_grid: VoxelGrid,
    /// Counts and checks of the mesh, before vertices were duplicated for [`MeshOptions::unindexed`].
    pub report: MeshReport,
    /// Total duration in milliseconds.
    pub duration_ms: f64,
    /// Duration of each stage in milliseconds.
    pub stages_ms: Vec<(&'static str, f64)>,
    /// Upper estimate of how far simplification moved the surface, in the scene's unit.
    pub simplification_error: f32,
    /// Distance of vertices from the exact surface.
    pub surface_error: VertexError,
}

impl MeshOutput {
    /// Writes the mesh to a file, atomically, in the format of its extension: `.glb`, `.gltf`, `.obj`, `.ply`, `.stl` or
    /// `.3mf`. The axis y points up, except in `.3mf`. For a 3D printer, whose axis z points up, see [`MeshOutput::save_with`].
    ///
    /// # Errors
    /// If the extension is unknown, the file cannot be written, or the format cannot hold the mesh.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), MeshError> {
        self.save_with(path, &MeshWriteOptions::default())
    }

    /// Writes the mesh as [`MeshOutput::save`] does, with other axes or another unit.
    ///
    /// ```
    /// # use argil::prelude::*;
    /// use argil::mesh::{MeshWriteOptions, UpAxis};
    /// # let mut scene = Scene::new();
    /// # scene.push(Shape::sphere(0.5))?;
    /// # let folder = tempfile::tempdir()?;
    /// # let world = Engine::cpu().build(&scene)?.field();
    /// let output = world.mesh(&MeshOptions { resolution: 32, ..MeshOptions::default() })?;
    /// let printer = MeshWriteOptions { axes: UpAxis::ZUp, ..MeshWriteOptions::default() };
    /// output.save_with(folder.path().join("ball.stl"), &printer)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the extension is unknown, the file cannot be written, or the format cannot hold the mesh.
    pub fn save_with(
        &self,
        path: impl AsRef<Path>,
        options: &MeshWriteOptions,
    ) -> Result<(), MeshError> {
        let path = path.as_ref();
        let format =
            MeshFormat::from_path(path).ok_or_else(|| MeshError::UnknownFormat(path.into()))?;
        save_mesh(&self.mesh, format, options, path)
    }
}

impl World {
    /// Extracts the surface as triangles, as a future: see [`World::mesh`].
    ///
    /// # Errors
    /// If the representation cannot be meshed, an option is out of range, or the mesh would be too large.
    pub async fn mesh_async(&self, options: &MeshOptions) -> Result<MeshOutput, MeshError> {
        let iso = options.iso;
        if !(-1e6..=1e6).contains(&iso) {
            return Err(MeshError::NotALength(iso));
        }
        let start = Instant::now();
        let mut stages = Stages::of(self.engine());
        if let Some(levels) = self.levels() {
            return self.mesh_of_levels(levels, options, stages);
        }
        let Extracted {
            mut mesh,
            voxel_grid,
            lists,
            made,
            offset_from,
        } = self.extracted(options, &mut stages).await?;
        let program = self.program();
        let mut simplified_by = 0.0;
        if let Some(most) = options.max_triangles {
            (mesh, simplified_by) = simplify(&mesh, most).map_err(MeshError::Simplify)?;
            stages.done("simplify")?;
        }
        let needs_normals = mesh.normals.is_empty() && options.normals != MeshNormals::None;
        let needs_normals = needs_normals && options.normals != MeshNormals::Face;
        let lists = match lists {
            Some(lists) => lists,
            None => CellPrograms::of(program, &layout_of(voxel_grid)?).map_err(BuildError::from)?,
        };
        if needs_normals && options.normals == MeshNormals::Field {
            project_to_field::normals(program, &lists, &mut mesh);
            stages.done("normals")?;
        } else if needs_normals {
            if let Some(volume) = self.volume_on_cpu().or(made.as_ref()) {
                stored_normals(&mut mesh, volume);
            }
            stages.done("normals")?;
        }
        if options.materials {
            project_to_field::materials(program, &lists, &mut mesh);
            stages.done("materials")?;
        }
        self.engine().control.end();
        let duration_ms = start.elapsed().as_secs_f64() * 1e3;
        let surface = (&mesh, voxel_grid.voxel_size);
        let distances = |mesh: &Mesh| match &offset_from {
            Some(solid) => solid.distances_in_parallel(&mesh.positions),
            None => project_to_field::distances(program, &lists, mesh),
        };
        let (report, surface_error) = checked(distances, surface, options);
        if options.normals == MeshNormals::Face || options.unindexed {
            let shared = std::mem::take(&mut mesh);
            mesh = shared.unindexed(options.normals == MeshNormals::Face);
        }
        if options.normals == MeshNormals::None {
            mesh.normals = Vec::new();
        }
        Ok(MeshOutput {
            surface_error,
            mesh,
            report,
            simplification_error: simplified_by,
            voxel_grid,
            duration_ms,
            stages_ms: stages.all,
        })
    }

    /// Extracts triangles, in the way of the world's representation and of the options.
    async fn extracted(
        &self,
        options: &MeshOptions,
        stages: &mut Stages,
    ) -> Result<Extracted, MeshError> {
        let iso = options.iso;
        let mut made = None;
        let is_dual = options.method == MeshMethod::DualContouring;
        let is_volume = self.device.has_volume();
        if is_dual && (is_volume || iso != 0.0) {
            return Err(MeshError::Dual);
        }
        let by_device = if is_volume {
            let mesh = self.device.volume_mesh(options, stages).await?;
            mesh.zip(self.device.voxel_grid())
        } else if iso == 0.0 && !is_dual {
            self.of_field_on_device(options, stages).await?
        } else {
            None
        };
        let mut offset_from = None;
        let (mesh, voxel_grid, lists) = match by_device {
            Some((mesh, voxel_grid)) => (mesh, voxel_grid, None),
            None if iso == 0.0 => self.of_field(options, &mut made, stages)?,
            None if self.is_level_set(iso) => self.of_level(options, stages)?,
            None => {
                let (mesh, voxel_grid, solid) = self.of_offset(options, stages)?;
                offset_from = solid;
                (mesh, voxel_grid, None)
            }
        };
        // Without triangles, all of the surface is outside.
        let has_left = iso > 0.0 && mesh.triangles.is_empty() && !self.program().aabb().is_empty();
        if is_volume && iso != 0.0 && (has_left || is_cut_open(&mesh, &voxel_grid)) {
            return Err(MeshError::LeavesBox(iso));
        }
        Ok(Extracted {
            mesh,
            voxel_grid,
            lists,
            made,
            offset_from,
        })
    }

    pub(crate) fn mesh_grid(&self, options: &MeshOptions) -> Result<VoxelGrid, MeshError> {
        // At any point, the distance is at least the distance to the box divided by the inverse.
        let inverse = Extents::of(&self.scene)
            .node_bounds(Scene::ROOT)
            .lipschitz_inverse;
        let solid = self.program().aabb().grown(inverse * options.iso.max(0.0));
        self.grid_around(solid, options)
    }

    pub(crate) fn grid_around(
        &self,
        solid: Aabb,
        options: &MeshOptions,
    ) -> Result<VoxelGrid, MeshError> {
        let frame = clip_box(&self.scene, solid);
        let most = *RESOLUTION_RANGE.end();
        let voxel_grid =
            match options.voxel_size {
                Some(voxel) => VoxelGrid::with_voxel_size(solid, frame, voxel, most)
                    .map_err(BuildError::from)?,
                None => VoxelGrid::fitting(solid, frame, options.resolution)
                    .map_err(BuildError::from)?,
            };
        Ok(voxel_grid)
    }

    pub(crate) fn of_field(
        &self,
        options: &MeshOptions,
        made: &mut Option<Volume>,
        stages: &mut Stages,
    ) -> Result<(Mesh, VoxelGrid, Option<CellPrograms>), MeshError> {
        let voxel_grid = self.mesh_grid(options)?;
        let field_mesh_parts = field_mesh(
            self.engine(),
            self.program(),
            voxel_grid,
            options.method,
            options.normals == MeshNormals::Field,
            stages,
        )?;
        let mut mesh = field_mesh_parts.mesh;
        if options.normals != MeshNormals::Field {
            mesh.normals = Vec::new();
        }
        *made = Some(field_mesh_parts.bricks.into());
        Ok((mesh, voxel_grid, Some(field_mesh_parts.lists)))
    }

    /// Meshes the field on the device, unless that leaves it to the CPU. The bricks are built, meshed and freed there.
    async fn of_field_on_device(
        &self,
        options: &MeshOptions,
        stages: &mut Stages,
    ) -> Result<Option<(Mesh, VoxelGrid)>, MeshError> {
        let voxel_grid = self.mesh_grid(options)?;
        let normals = match options.normals {
            MeshNormals::Face => MeshNormals::None,
            others => others,
        };
        let site = BuildContext {
            engine: self.engine(),
            scene: &self.scene,
            program: self.program(),
        };
        let mesh = self.device.field_mesh(&site, voxel_grid, normals, stages);
        Ok(mesh.await?.map(|mesh| (mesh, voxel_grid)))
    }
}

/// Triangles, and what is known from extracting them.
struct Extracted {
    mesh: Mesh,
    voxel_grid: VoxelGrid,
    lists: Option<CellPrograms>,
    /// Bricks that were made for the mesh.
    made: Option<Volume>,
    /// The solid that the surface is offset from.
    offset_from: Option<MeshSdf>,
}

/// Whether a volume's mesh has vertices at its outermost samples, where it ends. A clipped scene is known to be open.
fn is_cut_open(mesh: &Mesh, voxel_grid: &VoxelGrid) -> bool {
    let half = 0.5 * voxel_grid.voxel_size;
    // Samples of dense volumes are at voxel centers.
    let inner = voxel_grid.aabb().grown(-1.01 * half);
    let is_outer = |p: &Vec3| p.cmplt(inner.min).any() || p.cmpgt(inner.max).any();
    !voxel_grid.is_clipped && mesh.positions.iter().any(is_outer)
}

/// Counts and checks a mesh, if that is wanted.
fn checked(
    distances: impl Fn(&Mesh) -> Vec<f32>,
    (mesh, voxel_size): (&Mesh, f32),
    options: &MeshOptions,
) -> (MeshReport, VertexError) {
    if !options.checks {
        return (MeshReport::of(&Mesh::default()), VertexError::default());
    }
    let error = VertexError::of(&distances(mesh), options.iso, voxel_size);
    (MeshReport::of(mesh), error)
}

/// Computes normals as central differences of stored samples, over one voxel.
fn stored_normals(mesh: &mut Mesh, volume: &Volume) {
    let half = 0.5 * volume.voxel_grid().voxel_size;
    let held = volume.voxel_grid().aabb();
    let at = |p: Vec3| {
        let told = volume.distance_in(p.clamp(held.min, held.max));
        told.map_or(0.0, |(d, _)| d)
    };
    mesh.normals = mesh
        .positions
        .par_iter()
        .map(|&p| {
            let along = |axis: Vec3| at(p + half * axis) - at(p - half * axis);
            Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)).normalize_or_zero()
        })
        .collect();
}

/// Writes a mesh to a file, atomically.
///
/// # Errors
/// If the file cannot be written, or the format cannot hold the mesh.
pub fn save_mesh(
    mesh: &Mesh,
    format: MeshFormat,
    options: &MeshWriteOptions,
    path: impl AsRef<Path>,
) -> Result<(), MeshError> {
    let path = path.as_ref();
    argil_scene::write_atomically(path, |out| write(mesh, format, options, out)).map_err(|source| {
        MeshError::Write {
            path: path.into(),
            source,
        }
    })
}
