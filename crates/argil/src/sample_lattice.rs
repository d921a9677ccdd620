//! Where a world's samples are.

use crate::device::Device;
use crate::{Representation, World};
use argil_field::SampleLattice;

impl World {
    /// Returns where the world's finest samples are, to be passed to [`bake_history`](crate::bake_history). Edits then read most
    /// samples near the surface without interpolation. Returns `None` for a world without samples: a field, or a mesh.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use argil::prelude::*;
    /// let mut scene = Scene::new();
    /// scene.push(Shape::sphere(1.0))?;
    /// let world = Engine::cpu().build(&scene)?.bricks(64)?;
    /// let lattice = world.sample_lattice().ok_or("no samples")?;
    /// assert!((lattice.voxel_size - 2.0 / 60.0).abs() < 1e-4);
    /// # Ok(())
    /// # }
    /// ```
    pub fn sample_lattice(&self) -> Option<SampleLattice> {
        let grid = self.device.voxel_grid()?;
        // Texels have their samples at their centers, and bricks at corners of voxels.
        let inner = match self.representation() {
            Representation::Field | Representation::Mesh(_) => return None,
            Representation::Dense(_) | Representation::Octree(_) => 0.5 * grid.voxel_size,
            Representation::Bricks(_) | Representation::Levels(_) => 0.0,
        };
        Some(SampleLattice {
            origin: grid.corner + inner,
            voxel_size: grid.voxel_size,
        })
    }
}
