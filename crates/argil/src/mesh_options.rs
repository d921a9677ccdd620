use crate::field_mesh::MeshMethod;
use argil_mesh::MeshNormals;

/// Options of [`World::mesh`](crate::World::mesh).
///
/// ```
/// use argil::MeshOptions;
/// let options = MeshOptions { max_triangles: Some(10_000), ..MeshOptions::default() };
/// assert_eq!(options.resolution, 256);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshOptions {
    /// The algorithm that extracts triangles.
    pub method: MeshMethod,
    /// Voxels along the longest side, unless the world has a volume of its own.
    pub resolution: u32,
    /// Edge of a voxel in the scene's unit, instead of `resolution`. Marching cubes keeps details of about one voxel,
    /// and dual contouring, which also keeps sharp edges, of about two. For a 3D print, half of the nozzle's width
    /// is a good start.
    pub voxel_size: Option<f32>,
    /// Distance at which to extract the surface, in the scene's unit. Above 0 it lies outside the solid. Where the field is only a
    /// lower bound of the distance, the surface is meshed first, and offset by the distance to its triangles.
    pub iso: f32,
    /// The source of normals.
    pub normals: MeshNormals,
    /// Maximum number of triangles. `None` keeps all. Simplified meshes stay closed and manifold. They can have more
    /// triangles if fewer would open the surface.
    pub max_triangles: Option<usize>,
    /// Whether vertices get materials.
    pub materials: bool,
    /// Whether each triangle gets its own three vertices.
    pub unindexed: bool,
    /// Whether the mesh is counted and checked, which takes a third of the time. Without it, [`MeshOutput::report`](crate::MeshOutput::report) and
    /// [`MeshOutput::surface_error`](crate::MeshOutput::surface_error) are zero.
    pub checks: bool,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            method: MeshMethod::default(),
            resolution: 256,
            voxel_size: None,
            iso: 0.0,
            normals: MeshNormals::default(),
            max_triangles: None,
            materials: true,
            unindexed: false,
            checks: true,
        }
    }
}
