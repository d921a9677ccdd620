//! The parts of stored worlds: tiles, manifests, samples of meshes, and files of edits.

use argil::field::Program;
use argil_scene::{Brush, Material, SampledGrid, Scene, Shape};
use argil_volume::{
    BrickSettings, Levels, LevelsLayout, Tile, TileAddress, TileBaker, TileCell, TileHead,
    VoxelGrid,
};
use argil_world::{Manifest, PlanOptions, WorldPlan, apply_delta};
use glam::Vec3;
use std::sync::{Arc, LazyLock};

/// The hash of the world that tiles are parts of.
const WORLD: [u8; 32] = [7; 32];
/// Bytes of a tile before its place, and before its levels, and of what the head tells of a level.
const PLACE: usize = 20;
const SECTIONS: usize = 64;
const SECTION: usize = 32;

/// A ball with a corner, of two materials, so that tiles have mixed bricks.
fn scene() -> Scene {
    let mut scene = Scene::new();
    let material = Material::default();
    scene.set_material("red", material).expect("a material");
    let cube = Brush::new(Shape::cuboid([0.8; 3])).with_material("red");
    scene.push(Shape::sphere(1.0)).expect("a ball");
    scene.push(cube.at([0.7, 0.0, 0.0])).expect("a cube");
    scene
}

/// Returns seeds, all of which a reader must accept: others would reach nothing.
fn accepted(seeds: impl IntoIterator<Item = Vec<u8>>, reader: fn(&[u8]) -> bool) -> Vec<Vec<u8>> {
    let seeds: Vec<Vec<u8>> = seeds.into_iter().collect();
    assert!(seeds.iter().all(|seed| reader(seed)), "a seed is refused");
    seeds
}

/// A small world.
struct World {
    program: Program,
    layout: LevelsLayout,
}

static SMALL: LazyLock<World> = LazyLock::new(|| {
    let program = Program::lower(&scene()).expect("a program");
    let grid = VoxelGrid::fitting(program.aabb(), None, 100).expect("a grid");
    let layout = LevelsLayout::new(grid, &BrickSettings::default()).expect("levels");
    World { program, layout }
});

/// Reads a tile, whose checksums are made right first: nothing behind them would ever be reached. What is read is used.
pub(crate) fn tile(bytes: &[u8]) -> bool {
    let mut bytes = bytes.to_vec();
    repair_tile(&mut bytes);
    let World { program, layout } = &*SMALL;
    let Some(address) = address_of(&bytes) else {
        return false;
    };
    let Ok(tile) = Tile::from_bytes(&bytes, &WORLD, address, layout) else {
        return false;
    };
    let written = tile.to_bytes(&WORLD);
    let again = Tile::from_bytes(&written, &WORLD, address, layout);
    assert!(again.is_ok_and(|again| again.to_bytes(&WORLD) == written));
    let encoding = *layout.level(0).encoding();
    let top = address.top_level(layout);
    for level in address.finest_level()..=top {
        let first = address.place.map(|c| c.wrapping_mul(2 << (top - level)));
        for i in 0..512 {
            let inner = [i % 8, i / 8 % 8, i / 64];
            let cell = [0, 1, 2].map(|axis: usize| first[axis].wrapping_add(inner[axis]));
            if let Some(TileCell::Brick(brick)) = tile.cell(level, cell) {
                assert!(brick.distances(&encoding).all(f32::is_finite));
                let _ = brick.material(Vec3::ONE, Vec3::X, &encoding, program.materials());
            }
        }
    }
    let Ok(mut levels) = Levels::bake(program, *layout, 1 << 24) else {
        return false;
    };
    let tiles: rustc_hash::FxHashMap<TileAddress, Arc<Tile>> =
        [(address, Arc::new(tile))].into_iter().collect();
    levels.set_source(Arc::new(tiles), program, true);
    let _ = levels.refine_around(program, Vec3::ZERO, 1e-6);
    true
}

/// Reads the head of a tile and as many of its levels as there are bytes, as readers behind a network do.
pub(crate) fn tile_levels(bytes: &[u8]) -> bool {
    let mut bytes = bytes.to_vec();
    repair_tile(&mut bytes);
    let layout = &SMALL.layout;
    let Some(address) = address_of(&bytes) else {
        return false;
    };
    let Ok(head) = TileHead::from_bytes(&bytes, &WORLD, address, layout) else {
        return false;
    };
    let mut tile = Tile::of_head(&head);
    tile.read_levels(&head, &bytes[TileHead::BYTES..]).is_ok()
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at + 4)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

fn address_of(bytes: &[u8]) -> Option<TileAddress> {
    let place = [0, 4, 8].map(|c| word(bytes, PLACE + c));
    let [Some(x), Some(y), Some(z)] = place else {
        return None;
    };
    Some(TileAddress {
        tier: word(bytes, PLACE - 4)?,
        place: [x, y, z].map(|c| c as i32),
    })
}

/// Makes the checksums of a tile's head and levels right, and its world.
fn repair_tile(bytes: &mut [u8]) {
    let fields = TileHead::BYTES - 32;
    if bytes.len() < TileHead::BYTES {
        return;
    }
    bytes[SECTIONS - 32..SECTIONS].copy_from_slice(&WORLD);
    let mut begin = TileHead::BYTES;
    for section in (SECTIONS..fields).step_by(SECTION) {
        let length = word(bytes, section + 12).unwrap_or_default() as usize;
        let Some(level) = bytes.get(begin..begin.saturating_add(length)) else {
            break;
        };
        if length == 0 {
            continue;
        }
        let checksum = blake3::hash(level);
        bytes[section + 16..section + 32].copy_from_slice(&checksum.as_bytes()[..16]);
        begin += length;
    }
    let checksum = blake3::hash(&bytes[..fields]);
    bytes[fields..TileHead::BYTES].copy_from_slice(checksum.as_bytes());
}

/// Returns the tiles of a small world.
pub(crate) fn tiles() -> Vec<Vec<u8>> {
    let World { program, layout } = &*SMALL;
    let baker = TileBaker::new(program, *layout);
    let candidates = baker.candidates(&argil::math::Control::default());
    let some = candidates.into_iter().take(8);
    accepted(
        some.map(|address| baker.bake(address).to_bytes(&WORLD)),
        |bytes| tile(bytes) && tile_levels(bytes),
    )
}

static PLAN: LazyLock<String> = LazyLock::new(|| plan().to_json());

fn plan() -> WorldPlan {
    let options = PlanOptions {
        voxel_size: 0.05,
        ..PlanOptions::default()
    };
    WorldPlan::new(&scene(), &options).expect("a plan")
}

/// Reads a manifest, and the scene and the levels of its plan. The plan's hash is made right first.
pub(crate) fn manifest(bytes: &[u8]) -> bool {
    let repaired = serde_json::from_slice::<Manifest>(bytes).map(|manifest| Manifest {
        plan: manifest.plan.with_computed_hash(),
        ..manifest
    });
    let repaired = repaired.and_then(|manifest| serde_json::to_vec(&manifest));
    let bytes = repaired.as_deref().unwrap_or(bytes);
    let Ok(manifest) = Manifest::from_bytes(bytes, "manifest.json") else {
        return false;
    };
    let plan = &manifest.plan;
    let _ = (plan.size(), plan.levels(), plan.encoding());
    let _ = (plan.levels_options(), plan.scene());
    assert!(plan.mesh_names().count() <= bytes.len());
    true
}

pub(crate) fn manifests() -> Vec<Vec<u8>> {
    let plan = plan();
    let seed = Manifest {
        tiles: plan.tile_count(),
        bytes: 100_000,
        plan,
    };
    let bytes = serde_json::to_vec(&seed).expect("a manifest");
    accepted([bytes], manifest)
}

/// Reads the samples of a world's mesh, which a plan names by their hash.
pub(crate) fn mesh(bytes: &[u8]) -> bool {
    let hash = blake3::hash(bytes).to_hex();
    let mesh = format!(r#"[{{"path":"a.obj","resolution":32,"hash":"{hash}"}}]"#);
    let text = PLAN.replace("\"meshes\": []", &format!("\"meshes\": {mesh}"));
    let plan: WorldPlan = serde_json::from_str(&text).expect("a plan");
    let text =
        r#"{"argil":1,"brushes":[{"shape":{"type":"mesh","path":"a.obj","resolution":32}}]}"#;
    let mut scene = Scene::from_json(text, "a.json").expect("a scene");
    if plan.set_mesh(&mut scene, 0, bytes, "world").is_err() {
        return false;
    }
    if let Ok(program) = Program::lower(&scene) {
        assert!(!program.distance(Vec3::new(0.1, 0.2, 0.3)).is_nan());
    }
    true
}

/// Returns the samples of a ball.
pub(crate) fn meshes() -> Vec<Vec<u8>> {
    let ball = |[x, y, z]: [f32; 3]| Vec3::new(x, y, z).length() - 0.5;
    let grid = SampledGrid::from_fn([[-0.5; 3], [0.5; 3]], 16, ball).expect("a grid");
    let ends = [-0.5f32, -0.5, -0.5, 0.5, 0.5, 0.5];
    let numbers = ends.iter().chain(grid.words());
    let bytes = numbers.flat_map(|number| number.to_le_bytes()).collect();
    accepted([bytes], mesh)
}

/// Performs edits of a stored world.
pub(crate) fn delta(bytes: &[u8]) -> bool {
    apply_delta(&mut scene(), bytes, "edits/000001.jsonl").is_ok()
}

/// Returns files of edits of all kinds.
pub(crate) fn deltas() -> Vec<Vec<u8>> {
    let lines = [
        r#"{"edit":"insert","entry":{"shape":{"type":"sphere","radius":0.1},"modifiers":[{"type":"translate","by":[1,0,0]}]}}"#,
        r#"{"edit":"insert","into":"","index":0,"entry":{"brushes":[{"shape":{"type":"box","half_size":[1,1,1]}}]}}"#,
        r#"{"edit":"transform","node":"brushes[0]","by":{"type":"scale","by":2}}"#,
        r#"{"edit":"set_visible","node":"brushes[1]","visible":false}"#,
        r#"{"edit":"begin_stroke"}"#,
        r#"{"edit":"move","node":"brushes[1]","into":"brushes[0]","index":0}"#,
        r#"{"edit":"remove","node":"brushes[0].brushes[0]"}"#,
        r#"{"edit":"end_stroke"}"#,
        r#"{"edit":"set_material","name":"red","material":{"roughness":0.5}}"#,
        r#"{"edit":"undo"}"#,
        r#"{"edit":"redo"}"#,
    ];
    let first = lines[0].as_bytes().to_vec();
    accepted([lines.join("\n").into_bytes(), first], delta)
}
