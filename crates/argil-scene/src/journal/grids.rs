//! Samples of shapes, as a journal holds them.

use crate::{NodeDesc, SampledGrid, Scene};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The samples of a shape.
#[derive(Serialize, Deserialize)]
pub(super) struct JournalGrid {
    /// The name of the file that a scene has for them.
    pub(super) file: String,
    resolution: u32,
    /// The bytes of that file, in base 64.
    samples: String,
}

impl JournalGrid {
    pub(super) fn of(file: &str, resolution: u32, grid: &SampledGrid) -> Self {
        Self {
            file: file.into(),
            resolution,
            samples: BASE64_STANDARD.encode(grid.to_bytes()),
        }
    }

    /// Returns the samples of all sampled shapes of a scene, each once.
    pub(super) fn all_of(scene: &Scene) -> Vec<Self> {
        let mut files = BTreeSet::new();
        let shapes = scene.iter().map(|id| &scene.node(id).desc);
        shapes
            .filter_map(|desc| sampled_shape(scene, desc))
            .filter(|(file, ..)| files.insert(*file))
            .map(|(file, resolution, grid)| Self::of(file, resolution, grid))
            .collect()
    }

    pub(super) fn to_line(&self) -> String {
        serde_json::to_string(self).expect("a grid is JSON")
    }

    /// Returns the grid that a line holds, and not an edit.
    pub(super) fn from_line(line: &str) -> Option<Self> {
        line.starts_with("{\"file\":")
            .then(|| serde_json::from_str(line).ok())?
    }

    /// Gives the samples to the shapes of a scene that lack them, until [`JournalGrid::forget`]. Returns false if they are damaged.
    pub(super) fn load_into(&self, scene: &mut Scene) -> bool {
        let bytes = BASE64_STANDARD.decode(&self.samples).ok();
        let grid = bytes.and_then(|bytes| SampledGrid::from_bytes(&bytes));
        let is_grid = grid.is_some();
        if let Some(grid) = grid {
            scene.set_mesh_grid(self.file.clone(), self.resolution, Arc::new(grid));
        }
        is_grid
    }

    /// Lets only the shapes keep the samples, as shapes have them that no file gave any.
    pub(super) fn forget(&self, scene: &mut Scene) {
        scene.grids.remove(&(self.file.clone(), self.resolution));
    }
}

/// Returns the samples of a description that no file gave to the scene: its name, its resolution and its samples.
pub(super) fn sampled_shape<'a>(
    scene: &Scene,
    desc: &'a NodeDesc,
) -> Option<(&'a str, u32, &'a SampledGrid)> {
    let (file, resolution, grid) = desc.kind.file()?;
    let grid = grid.0.as_ref().filter(|_| crate::is_grid(file))?;
    let of_file = scene.grids.get(&(file.to_owned(), resolution));
    if of_file.is_some_and(|known| Arc::ptr_eq(known, grid)) {
        return None;
    }
    Some((file, resolution, grid))
}
