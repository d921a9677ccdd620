//! Plans: what is baked.

use crate::WorldError;
use argil::math::Control;
use argil::scene::Scene;
use argil::volume::{
    Band, BrickSettings, Encoding, LevelsLayout, SampleFormat, TileAddress, TileBaker,
};
use argil::{Engine, LevelsOptions, World};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use std::path::Path;

/// The version of plans and tiles that this program writes, and the only one that it reads.
const VERSION: u32 = 1;

/// What to bake of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanOptions {
    /// Edge of a voxel of the finest level, in the scene's unit.
    pub voxel_size: f32,
    /// The encoding of distances.
    pub encoding: Encoding,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            voxel_size: 0.01,
            encoding: BrickSettings::default().encoding,
        }
    }
}

/// The samples of a scene's mesh.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlanMesh {
    pub path: String,
    pub resolution: u32,
    /// BLAKE3 of the samples.
    pub hash: String,
}

/// A description of a world: small, and complete. Whoever has it bakes the same tiles.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldPlan {
    argil_world: u32,
    hash: String,
    voxel_size: f32,
    bits: u32,
    band_voxels: f32,
    /// The first voxel of the finest level, and their number.
    begin: [i32; 3],
    size: [u32; 3],
    levels: u32,
    /// The number of tiles that bounds do not rule out, of each tier, the finest first.
    tiles: Vec<u64>,
    pub(crate) meshes: Vec<PlanMesh>,
    scene: Box<RawValue>,
}

impl PartialEq for WorldPlan {
    fn eq(&self, other: &Self) -> bool {
        self.hash == other.hash
    }
}

/// A scene's field with the layout of its levels.
pub(crate) struct Prepared {
    world: World,
    pub layout: LevelsLayout,
}

fn levels_options(voxel_size: f32, encoding: Encoding) -> LevelsOptions {
    LevelsOptions {
        voxel_size: Some(voxel_size),
        settings: BrickSettings {
            encoding,
            ..BrickSettings::default()
        },
        ..LevelsOptions::default()
    }
}

impl Prepared {
    fn new(scene: &Scene, voxel_size: f32, encoding: Encoding) -> Result<Self, WorldError> {
        let options = levels_options(voxel_size, encoding);
        // On a CPU nothing is waited for.
        let built = Engine::cpu().build(scene)?;
        let world = pollster::block_on(built.with_representation_async(options))?;
        let layout = world.levels().map(|levels| *levels.layout());
        let layout = layout.ok_or_else(|| WorldError::plan("levels", "there are none"))?;
        Ok(Self { world, layout })
    }

    pub(crate) fn baker(&self) -> TileBaker<'_> {
        TileBaker::new(self.world.program(), self.layout)
    }

    pub(crate) fn materials(&self) -> usize {
        self.world.program().materials().len()
    }

    #[cfg(feature = "store")]
    pub(crate) fn palette(&self) -> Vec<argil::abi::GpuMaterial> {
        self.world.program().materials().to_vec()
    }
}

impl WorldPlan {
    /// Plans a scene whose meshes are loaded, on rayon's current threads: finds which tiles there can be, from bounds alone.
    ///
    /// # Errors
    /// If the scene cannot be built with such voxels.
    pub fn new(scene: &Scene, options: &PlanOptions) -> Result<Self, WorldError> {
        Self::with_control(scene, options, &Control::default())
    }

    /// Plans a scene as [`WorldPlan::new`] does, and can be canceled.
    ///
    /// # Errors
    /// If the scene cannot be built with such voxels, or the work was canceled.
    pub fn with_control(
        scene: &Scene,
        options: &PlanOptions,
        control: &Control,
    ) -> Result<Self, WorldError> {
        let prepared = Prepared::new(scene, options.voxel_size, options.encoding)?;
        control.begin("tiles", 0);
        let candidates = prepared.baker().candidates(control);
        if control.is_cancelled() {
            return Err(WorldError::Cancelled);
        }
        Self::of(scene, options, &prepared, counts(&candidates))
    }

    /// Describes the world of a scene whose meshes are loaded, without counting its tiles: for readers.
    ///
    /// # Errors
    /// If the scene cannot be built with such voxels.
    pub fn without_tiles(scene: &Scene, options: &PlanOptions) -> Result<Self, WorldError> {
        let prepared = Prepared::new(scene, options.voxel_size, options.encoding)?;
        Self::of(scene, options, &prepared, Vec::new())
    }

    fn of(
        scene: &Scene,
        options: &PlanOptions,
        prepared: &Prepared,
        tiles: Vec<u64>,
    ) -> Result<Self, WorldError> {
        if let Some(image) = scene.texture_images().first() {
            let reason = format!(
                "a texture names the image \"{image}\", which worlds of tiles do not hold: use another pattern"
            );
            return Err(WorldError::plan("the scene", reason));
        }
        let grid = *prepared.layout.level(0).voxel_grid();
        let text = scene.to_json().trim().to_owned();
        let broken = |error: serde_json::Error| WorldError::plan("the scene", error.to_string());
        let compact: Box<RawValue> = RawValue::from_string(text).map_err(broken)?;
        let mut plan = Self {
            argil_world: VERSION,
            hash: String::new(),
            voxel_size: grid.voxel_size,
            bits: match options.encoding.format {
                SampleFormat::Snorm8 => 8,
                SampleFormat::Snorm16 => 16,
            },
            band_voxels: options.encoding.band.voxels(),
            begin: grid.begin.to_array(),
            size: grid.size.to_array(),
            levels: prepared.layout.count(),
            tiles,
            meshes: meshes_of(scene),
            scene: compact,
        };
        plan.hash = plan.computed_hash();
        Ok(plan)
    }

    /// Returns the hash of all that determines the tiles. It names the world's folder.
    fn computed_hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut add = |part: &[u8]| {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        };
        add(&VERSION.to_le_bytes());
        add(&self.voxel_size.to_le_bytes());
        add(&self.bits.to_le_bytes());
        add(&self.band_voxels.to_le_bytes());
        add(&self.begin.map(i32::to_le_bytes).concat());
        add(&self.size.map(u32::to_le_bytes).concat());
        for mesh in &self.meshes {
            add(mesh.path.as_bytes());
            add(&mesh.resolution.to_le_bytes());
            add(mesh.hash.as_bytes());
        }
        add(self.scene.get().as_bytes());
        hasher.finalize().to_hex()[..32].to_owned()
    }

    /// Returns the plan with the hash of what is in it, for tests that change plans.
    #[doc(hidden)]
    pub fn with_computed_hash(self) -> Self {
        let hash = self.computed_hash();
        Self { hash, ..self }
    }

    /// Returns the hash, which names the world's folder in a store.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Returns the hash in the form that tiles have.
    pub(crate) fn tile_key(&self) -> [u8; 32] {
        *blake3::hash(self.hash.as_bytes()).as_bytes()
    }

    /// Returns the number of tiles that bounds do not rule out, of each tier, the finest first.
    pub fn tiles(&self) -> &[u64] {
        &self.tiles
    }

    /// Returns the number of all tiles that bounds do not rule out.
    pub fn tile_count(&self) -> u64 {
        self.tiles
            .iter()
            .fold(0, |all, count| all.saturating_add(*count))
    }

    /// Returns the edge of a voxel of the finest level, in the scene's unit.
    pub fn voxel_size(&self) -> f32 {
        self.voxel_size
    }

    /// Returns the number of voxels of the finest level along each axis.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// Returns the number of levels.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Returns the encoding of distances.
    pub fn encoding(&self) -> Encoding {
        Encoding {
            format: match self.bits {
                8 => SampleFormat::Snorm8,
                _ => SampleFormat::Snorm16,
            },
            band: Band::Voxels(self.band_voxels),
        }
    }

    /// Returns the options of levels that have the world's voxels.
    pub fn levels_options(&self) -> LevelsOptions {
        levels_options(self.voxel_size, self.encoding())
    }

    /// Returns the finest level whose voxels are as long as `voxel_size`, or a little longer. By default 0, the finest.
    #[cfg(feature = "store")]
    pub(crate) fn level_of(
        &self,
        voxel_size: Option<f32>,
        coarsest: u32,
    ) -> Result<u32, WorldError> {
        let size = voxel_size.unwrap_or(self.voxel_size);
        if !(size > 0.0 && size.is_finite()) {
            return Err(WorldError::VoxelSize(size));
        }
        let level = (size / self.voxel_size).max(1.0).log2() - 1e-3;
        Ok((level.ceil() as u32).min(coarsest))
    }

    /// Returns the scene as text.
    pub fn scene_json(&self) -> &str {
        self.scene.get()
    }

    /// Returns the scene, without the samples of its meshes.
    ///
    /// # Errors
    /// If the plan holds no scene.
    pub fn scene(&self) -> Result<Scene, WorldError> {
        let scene = Scene::from_json(self.scene.get(), "the plan's scene");
        scene.map_err(|error| WorldError::plan("the plan's scene", error.to_string()))
    }

    /// Returns the plan as text.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }

    /// Reads a plan. `place` appears in messages.
    ///
    /// # Errors
    /// If the text is no plan, was changed by hand, or is of another version.
    pub fn from_json(text: &str, place: &str) -> Result<Self, WorldError> {
        let head: Head = serde_json::from_str(text).map_err(|error| {
            WorldError::plan(
                place,
                format!("this is no plan of a world: {error}. Make one with `argil world plan`"),
            )
        })?;
        if head.argil_world != VERSION {
            let reason = format!(
                "this is a plan of version {}, and this program reads version {VERSION}: make it again",
                head.argil_world
            );
            return Err(WorldError::plan(place, reason));
        }
        let plan: Self = serde_json::from_str(text)
            .map_err(|error| WorldError::plan(place, format!("the plan is broken: {error}")))?;
        if plan.computed_hash() != plan.hash || !matches!(plan.bits, 8 | 16) {
            let reason =
                "the plan was changed after it was made: its hash is another one. Make a new plan";
            return Err(WorldError::plan(place, reason));
        }
        Ok(plan)
    }

    /// Reads the file of a plan.
    ///
    /// # Errors
    /// If it cannot be read, or is no plan.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, WorldError> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|reason| WorldError::Io {
            path: path.into(),
            reason,
        })?;
        Self::from_json(&text, &path.display().to_string())
    }

    /// Builds the scene's field.
    ///
    /// # Errors
    /// If it is not the scene that was planned.
    pub(crate) fn prepare(&self, scene: &Scene) -> Result<Prepared, WorldError> {
        if scene.to_json().trim() != self.scene.get().trim() {
            let reason = "its brushes, materials or view are others";
            return Err(WorldError::Changed(reason.to_owned()));
        }
        let meshes = meshes_of(scene);
        let changed = self.meshes.iter().find(|mesh| !meshes.contains(mesh));
        if changed.is_some() || meshes.len() != self.meshes.len() {
            let path = changed.map_or("a mesh", |mesh| &mesh.path);
            return Err(WorldError::Changed(format!("{path} has other contents")));
        }
        let prepared = Prepared::new(scene, self.voxel_size, self.encoding())?;
        let levels = prepared.layout.count();
        if levels != self.levels {
            let reason = format!("it has {levels} levels, and the plan {}", self.levels);
            return Err(WorldError::Changed(reason));
        }
        let grid = *prepared.layout.level(0).voxel_grid();
        if grid.begin.to_array() != self.begin || grid.size.to_array() != self.size {
            let reason = format!(
                "it has {} voxels from {}, and the plan tells {:?} from {:?}",
                grid.size, grid.begin, self.size, self.begin
            );
            return Err(WorldError::Changed(reason));
        }
        Ok(prepared)
    }
}

/// What tells the version.
#[derive(Deserialize)]
struct Head {
    argil_world: u32,
}

/// Counts the tiles of each tier.
fn counts(candidates: &[TileAddress]) -> Vec<u64> {
    let tiers = candidates.iter().map(|candidate| candidate.tier + 1).max();
    let mut counts = vec![0; tiers.unwrap_or(0) as usize];
    for candidate in candidates {
        counts[candidate.tier as usize] += 1;
    }
    counts
}

/// Describes the samples of a scene's meshes.
fn meshes_of(scene: &Scene) -> Vec<PlanMesh> {
    let loaded = scene.loaded_meshes().into_iter();
    loaded
        .map(|(path, resolution, grid)| {
            let bytes = mesh_bytes(grid);
            PlanMesh {
                path: path.to_owned(),
                resolution,
                hash: blake3::hash(&bytes).to_hex().to_string(),
            }
        })
        .collect()
}

/// Returns the samples of a mesh as bytes: its box, and the samples, little-endian.
pub(crate) fn mesh_bytes(grid: &argil::scene::SampledGrid) -> Vec<u8> {
    let solid = grid.solid();
    let ends = [solid.min.to_array(), solid.max.to_array()].concat();
    let numbers = ends.iter().chain(grid.words());
    numbers.flat_map(|number| number.to_le_bytes()).collect()
}
