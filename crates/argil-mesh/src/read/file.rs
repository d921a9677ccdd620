//! The contents of a mesh file.

use crate::Mesh;

/// The contents of a mesh file.
///
/// ```
/// # use argil_mesh::{MeshFormat, from_bytes};
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let file = from_bytes(text, MeshFormat::Obj, "a.obj".as_ref())?;
/// assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
/// assert!(file.warnings.is_empty());
/// # Ok::<(), argil_mesh::MeshReadError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// The triangles of all objects.
    pub mesh: Mesh,
    /// Describes what was left out or uncertain, one sentence each.
    pub warnings: Vec<String>,
}
