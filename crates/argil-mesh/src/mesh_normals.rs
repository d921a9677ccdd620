//! The source of normals.

/// The source of a mesh's normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum MeshNormals {
    /// The exact field's gradient at each vertex, for smooth shading.
    #[default]
    Field,
    /// The gradient of the stored samples, by central differences.
    Gradient,
    /// The triangles' own normals, for flat shading. Triangles then share no vertices.
    Face,
    /// No normals.
    None,
}
