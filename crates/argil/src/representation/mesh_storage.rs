//! Triangles of a world, on either device.

use argil_gpu::GpuMesh;
use argil_mesh::Mesh;
use argil_render::Triangles;
use argil_volume::VoxelGrid;

/// Triangles, and the voxel grid that they came from.
#[derive(Debug)]
pub(crate) struct MeshStorage {
    pub mesh: StoredTriangles,
    pub voxel_grid: VoxelGrid,
}

/// Triangles on either device.
#[derive(Debug)]
pub(crate) enum StoredTriangles {
    Cpu(Mesh),
    Gpu(Box<GpuMesh>),
}

/// Borrows a mesh in the form that is rendered.
pub(crate) fn triangles(mesh: &Mesh) -> Triangles<'_> {
    Triangles {
        positions: &mesh.positions,
        normals: &mesh.normals,
        triangles: &mesh.triangles,
    }
}

/// The size of a world's mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshCounts {
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices.
    pub vertices: u64,
}
