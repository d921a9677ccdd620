//! What tells that a world is finished.

use crate::{WorldError, WorldPlan};
use argil::math::Aabb;
use argil::scene::{SampledGrid, Scene};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What a finished world is. It is written last.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifest {
    /// The number of tiles.
    pub tiles: u64,
    /// Their bytes.
    pub bytes: u64,
    /// What was baked.
    pub plan: WorldPlan,
}

impl Manifest {
    /// Reads a manifest. `place` appears in messages.
    ///
    /// # Errors
    /// If the bytes are no manifest, or one of another version.
    pub fn from_bytes(bytes: &[u8], place: &str) -> Result<Self, WorldError> {
        let broken = |reason: String| WorldError::plan(place, reason);
        let text = std::str::from_utf8(bytes).map_err(|error| broken(error.to_string()))?;
        let manifest: Self = serde_json::from_str(text)
            .map_err(|error| broken(format!("this is no manifest of a world: {error}")))?;
        // Checks the version and the hash.
        let plan = WorldPlan::from_json(&manifest.plan.to_json(), place)?;
        Ok(Self { plan, ..manifest })
    }
}

impl WorldPlan {
    /// Returns the names of the objects with the samples of the scene's meshes.
    pub fn mesh_names(&self) -> impl Iterator<Item = String> {
        (0..self.meshes.len()).map(|index| format!("meshes/{index}"))
    }

    /// Gives a scene the samples of one of its meshes, as the object of that name holds them. `folder` is the world's.
    ///
    /// # Errors
    /// If the bytes are others than those of the plan.
    pub fn set_mesh(
        &self,
        scene: &mut Scene,
        index: usize,
        bytes: &[u8],
        folder: &str,
    ) -> Result<(), WorldError> {
        let Some(mesh) = self.meshes.get(index) else {
            return Ok(());
        };
        let grid = (blake3::hash(bytes).to_hex().as_str() == mesh.hash)
            .then(|| mesh_of(bytes))
            .flatten();
        let grid = grid.ok_or_else(|| {
            WorldError::plan(
                format!("{folder}/meshes/{index}"),
                format!("the samples of {} are missing or damaged", mesh.path),
            )
        })?;
        scene.set_mesh_grid(mesh.path.as_str(), mesh.resolution, Arc::new(grid));
        Ok(())
    }
}

/// Reads the samples of a mesh.
fn mesh_of(bytes: &[u8]) -> Option<SampledGrid> {
    let (numbers, rest) = bytes.as_chunks::<4>();
    let numbers: Vec<f32> = numbers
        .iter()
        .map(|number| f32::from_le_bytes(*number))
        .collect();
    let [a, b, c, d, e, f] = *numbers.first_chunk::<6>()?;
    let solid = Aabb::new([a, b, c].into(), [d, e, f].into());
    let grid = SampledGrid::from_words(numbers[6..].to_vec(), solid);
    grid.filter(|_| rest.is_empty())
}
