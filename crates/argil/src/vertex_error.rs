//! How far a mesh is from the exact surface.

/// How far the vertices of a mesh are from the exact surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VertexError {
    /// Root mean square of the distances, in voxels.
    pub rms_voxels: f64,
    /// Maximum distance, in voxels.
    pub max_voxels: f64,
}

impl VertexError {
    /// Computes the error of vertices from their distances, for a surface at distance `iso`.
    pub(crate) fn of(distances: &[f32], iso: f32, voxel_size: f32) -> Self {
        let voxels = |d: f32| f64::from((d - iso).abs() / voxel_size);
        let square: f64 = distances.iter().map(|&d| voxels(d).powi(2)).sum();
        Self {
            rms_voxels: (square / distances.len().max(1) as f64).sqrt(),
            max_voxels: distances.iter().map(|&d| voxels(d)).fold(0.0, f64::max),
        }
    }
}
