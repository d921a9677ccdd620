//! Kept as triangles.

use super::mesh_kept::{Drawable, Triangulated, triangles};
use super::options::{BuildTimes, Kept, Options, Site};
use crate::BuildError;
use crate::field_mesh::{MeshMethod, Stages, field_mesh, field_mesh_on_gpu};
use argil_gpu::{GpuMesh, MarchNormals};
use argil_mesh::exact;
use argil_volume::{Lattice, Volume};

/// Triangles to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshViaOptions {
    /// Voxels along the longest side.
    pub resolution: u32,
    /// How triangles are found.
    pub method: MeshMethod,
    /// Whether each has its own normal, the 2023 study's true ones; else corners have the exact field's.
    pub flat: bool,
}

impl Default for MeshViaOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            method: MeshMethod::default(),
            flat: false,
        }
    }
}

impl Options for MeshViaOptions {
    const WORD: &'static str = "mesh";
    const ABOUT: &'static str = "Triangles, drawn in the order of their depth";

    fn at(resolution: u32) -> Self {
        Self {
            resolution,
            ..Self::default()
        }
    }

    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn of(_: &Volume) -> Option<Self> {
        None
    }

    async fn build(
        &self,
        site: &Site<'_>,
        lattice: Lattice,
    ) -> Result<(Kept, BuildTimes), BuildError> {
        let Site {
            engine, program, ..
        } = *site;
        if let Some(field) = site.field
            && self.method == MeshMethod::MarchingCubes
        {
            let normals = if self.flat {
                MarchNormals::Face
            } else {
                MarchNormals::Field
            };
            let made = field_mesh_on_gpu(engine, field, program, lattice, normals, self.flat);
            let (mesh, stages) = made.await?;
            let mesh = Triangulated::Gpu(Box::new(mesh));
            let times = BuildTimes::of_stages(stages);
            return Ok((Kept::Mesh(Drawable { mesh, lattice }), times));
        }
        let mut stages = Stages::of(engine);
        let made = field_mesh(engine, program, lattice, self.method, &mut stages)?;
        let mut mesh = made.mesh;
        if self.flat {
            mesh = mesh.unshared(true);
            stages.done("unshare")?;
        } else if mesh.normals.is_empty() {
            exact::normals(program, &made.lists, &mut mesh);
            stages.done("normals")?;
        }
        let mesh = match site.field {
            Some(field) => {
                let uploaded = GpuMesh::upload(field, triangles(&mesh))?;
                Triangulated::Gpu(Box::new(uploaded))
            }
            None => Triangulated::Cpu(mesh),
        };
        let times = BuildTimes::of_stages(stages.all);
        Ok((Kept::Mesh(Drawable { mesh, lattice }), times))
    }
}
