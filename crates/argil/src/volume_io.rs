//! Reads and writes volume files.

use crate::device::Device;
use crate::{Engine, Representation, VolumeFileError, World};
use argil_scene::SampledGrid;
use argil_scene::Scene;
use argil_volume::VolumeFile;
use argil_volume::{Section, StoredMesh, Volume, VolumeError};
use std::path::Path;
use std::sync::Arc;

impl Engine {
    /// Creates a world from a volume file, as a future: see [`Engine::load`]. If `allow_external` is true, meshes may lie
    /// outside the file's folder.
    ///
    /// # Errors
    /// If the file's contents are inconsistent, a mesh cannot be loaded, or the device does not accept the volume.
    pub async fn load_async(
        &self,
        stored: VolumeFile,
        path: impl AsRef<Path>,
        allow_external: bool,
    ) -> Result<(Scene, World), VolumeFileError> {
        World::load(self.clone(), stored, path.as_ref(), allow_external).await
    }
}

impl World {
    async fn load(
        engine: Engine,
        stored: VolumeFile,
        path: &Path,
        allow_external: bool,
    ) -> Result<(Scene, Self), VolumeFileError> {
        let mut scene = crate::stored_scene(&stored, path)?;
        // Files of version 1 hold no meshes.
        let folder = path.parent().unwrap_or(Path::new("."));
        let control = &engine.control;
        crate::load_meshes_with_control(&mut scene, folder, allow_external, control)?;
        let mut world = Self::new(engine, &scene)?;
        let mut stored = stored;
        let solid = world.program().aabb();
        stored
            .volume
            .set_clipped(!solid.is_finite() && !solid.is_empty());
        world.representation = Representation::of(&stored.volume);
        world.device.store_volume(stored.volume).await?;
        world.begin_following(&scene);
        Ok((scene, world))
    }

    /// Writes the volume to a file, as a future: see [`World::save`].
    ///
    /// # Errors
    /// If the world has no volume, edits are unfinished, or the file cannot be written.
    pub async fn save_async(&self, path: impl AsRef<Path>) -> Result<(), VolumeFileError> {
        let path = path.as_ref();
        self.check_finished()?;
        let volume = self.volume_async().await?;
        let volume = volume.ok_or(VolumeFileError::NoVolume)?;
        check_kind(&volume)?;
        let (scene_json, meshes) = self.scene_to_store();
        argil_scene::write_atomically(path, |out| volume.write(&scene_json, &meshes, out)).map_err(
            |source| VolumeFileError::Write {
                path: path.into(),
                source,
            },
        )
    }

    /// Writes the volume to a stream, as a future: see [`World::write`].
    ///
    /// # Errors
    /// If the world has no volume, edits are unfinished, or `out` fails.
    pub async fn write_async(
        &self,
        mut out: &mut (impl std::io::Write + ?Sized),
    ) -> std::io::Result<()> {
        self.check_finished().map_err(std::io::Error::other)?;
        let volume = self.volume_async().await.map_err(std::io::Error::other)?;
        let volume = volume.ok_or_else(|| std::io::Error::other(VolumeFileError::NoVolume))?;
        check_kind(&volume).map_err(std::io::Error::other)?;
        let (scene_json, meshes) = self.scene_to_store();
        volume.write(&scene_json, &meshes, &mut out)
    }

    /// A file whose volume lags behind its scene could never catch up.
    fn check_finished(&self) -> Result<(), VolumeFileError> {
        match self.remaining_blocks() {
            0 => Ok(()),
            blocks => Err(VolumeFileError::UnfinishedEdits { blocks }),
        }
    }

    fn scene_to_store(&self) -> (String, Vec<StoredMesh<'_>>) {
        let meshes = crate::mesh_assets::meshes_to_store(&self.scene);
        (at_time_0(&self.scene), meshes)
    }
}

fn check_kind(volume: &Volume) -> Result<(), VolumeFileError> {
    match volume {
        Volume::Levels(_) => Err(VolumeFileError::Levels),
        _ => Ok(()),
    }
}

/// Returns a scene's text for a file, at time 0.
fn at_time_0(scene: &Scene) -> String {
    if scene.time() == 0.0 {
        scene.to_json()
    } else {
        scene.baked_at_current_time().to_json()
    }
}

/// Returns the scene of a volume file, with the meshes that the file holds. `path` appears in messages. Meshes that
/// the file does not hold stay missing: see [`load_meshes`](crate::load_meshes).
///
/// # Errors
/// If the scene or a mesh in the file cannot be read.
pub fn stored_scene(stored: &VolumeFile, path: &Path) -> Result<Scene, VolumeFileError> {
    let inside = format!("{}, its scene", path.display());
    let mut scene = Scene::from_json(&stored.scene_json, inside)?;
    for mesh in &stored.meshes {
        let grid = SampledGrid::from_words(mesh.words.to_vec(), mesh.solid).ok_or_else(|| {
            VolumeError::Content {
                path: path.into(),
                section: Section::Meshes,
                reason: format!("the distances of {:?} are invalid", mesh.path),
            }
        })?;
        scene.set_mesh_grid(mesh.path.as_ref(), mesh.resolution, Arc::new(grid));
    }
    Ok(scene)
}
