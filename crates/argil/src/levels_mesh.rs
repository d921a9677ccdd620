//! Extracts triangles from worlds of levels of detail.

use crate::field_mesh::{MeshMethod, Stages};
use crate::memory::{available_memory, without_budget};
use crate::{MeshError, MeshOptions, MeshOutput, VertexError, World};
use argil_mesh::levels::{mesh_levels, project_levels};
use argil_mesh::{MeshNormals, MeshReport};
use argil_volume::{BrickSettings, BricksError, Levels, LevelsLayout};
use web_time::Instant;

/// Rows of the image whose pixels determine the size of triangles.
const IMAGE_ROWS: f32 = 720.0;
/// The part of free memory that bricks may take. The mesh needs the rest.
const BRICKS_SHARE: u64 = 4;

impl World {
    /// Meshes levels: voxels are as large as pixels of an image from the scene's camera, wherever they are.
    pub(crate) fn mesh_of_levels(
        &self,
        levels: &Levels,
        options: &MeshOptions,
        mut stages: Stages,
    ) -> Result<MeshOutput, MeshError> {
        let start = Instant::now();
        let is_usual = options.iso == 0.0
            && options.method != MeshMethod::DualContouring
            && options.max_triangles.is_none()
            && options.normals != MeshNormals::Gradient;
        if !is_usual {
            return Err(MeshError::Levels);
        }
        let program = self.program();
        let camera = self.camera();
        let half_height = (0.5 * camera.field_of_view_degrees).to_radians().tan();
        let pixel_width = 2.0 * half_height / IMAGE_ROWS;
        // Levels are baked on the CPU, whatever the device.
        let budget = available_memory().unwrap_or(u64::MAX) / BRICKS_SHARE;
        let refuse = |error: BricksError| without_budget(error.into(), None);
        // A mesh does not reach to the horizon.
        let grid = *levels.layout().level(0).voxel_grid();
        let layout = if grid.is_clipped {
            let grid = grid.recomputed(program.aabb(), Some(self.view_bounds()));
            let grid = grid.map_err(BricksError::from).map_err(refuse)?;
            let settings = BrickSettings {
                encoding: *levels.layout().level(0).encoding(),
                ..BrickSettings::default()
            };
            LevelsLayout::new(grid, &settings).map_err(refuse)?
        } else {
            *levels.layout()
        };
        let mut whole = Levels::bake(program, layout, budget).map_err(refuse)?;
        let size = levels.pixel_error() * pixel_width;
        let filled = whole.refine_around(program, camera.eye, size);
        if filled.is_full {
            let bricks = whole.brick_count();
            let needed =
                whole.memory_bytes() + filled.remaining * levels.layout().level(0).brick_bytes();
            return Err(refuse(BricksError::Budget {
                bricks,
                needed,
                budget,
            })
            .into());
        }
        stages.done("bake")?;
        let mut made = mesh_levels(&whole);
        stages.done("march")?;
        let distances = project_levels(program, &mut whole, &mut made);
        stages.done("project")?;
        let voxels = distances
            .iter()
            .zip(&made.voxel_sizes)
            .map(|(d, voxel)| d / voxel);
        let surface_error = VertexError::of(&voxels.collect::<Vec<f32>>(), 0.0, 1.0);
        let mut mesh = made.mesh;
        let report = MeshReport::of(&mesh);
        if !options.materials {
            mesh.materials = Vec::new();
        }
        if options.normals == MeshNormals::Face || options.unindexed {
            mesh = mesh.unindexed(options.normals == MeshNormals::Face);
        }
        if options.normals == MeshNormals::None {
            mesh.normals = Vec::new();
        }
        self.engine().control.end();
        Ok(MeshOutput {
            mesh,
            voxel_grid: *whole.layout().finest_grid(),
            report,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            stages_ms: stages.all,
            simplification_error: 0.0,
            surface_error,
        })
    }
}
