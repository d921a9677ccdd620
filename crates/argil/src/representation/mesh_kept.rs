//! Triangles on either device.

use argil_gpu::GpuMesh;
use argil_march::Triangles;
use argil_mesh::Mesh;
use argil_volume::Lattice;

/// Triangles, and where their voxels lay.
pub(crate) struct Drawable {
    pub mesh: Triangulated,
    pub lattice: Lattice,
}

/// Triangles on either device.
pub(crate) enum Triangulated {
    Cpu(Mesh),
    Gpu(Box<GpuMesh>),
}

/// A mesh as it is drawn.
pub(crate) fn triangles(mesh: &Mesh) -> Triangles<'_> {
    Triangles {
        positions: &mesh.positions,
        normals: &mesh.normals,
        triangles: &mesh.triangles,
    }
}
