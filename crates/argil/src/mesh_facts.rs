//! What is known of a mesh file besides its distances.

use argil_mesh::RepairReport;

/// What is known of a mesh file besides its distances.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MeshFacts {
    /// Triangles, including those that close holes.
    pub triangles: u64,
    /// What was repaired.
    pub repairs: RepairReport,
    /// What the reader left out of the file.
    pub file_warnings: Vec<String>,
}
