//! Sessions of random edits, each compared with a fresh bake.

use crate::{EditRig, RandomTables};
use argil_field::{IncrementalProgram, Program};
use argil_volume::{BrickSettings, Encoding};

/// Larger solids are undone, in voxels along their longest side: they test nothing more, and take longer.
const MAX_VOXELS: f32 = 16.0;
/// Scenes with more iterations of loops are undone, too.
const MAX_ITERATIONS: u64 = 200;

/// A session ends when its bricks hold more samples.
const MAX_SAMPLES: u64 = 20_000;

/// Applies random edits of all rows to a random scene on a small grid. Returns the number of edits, which is smaller
/// if the solid becomes large, and of rebuilds.
///
/// # Errors
/// The first edit after which bricks differ from a fresh bake, with the scene before and after it.
pub fn random_session(seed: u64, edits: usize) -> Result<[usize; 2], String> {
    let mut tables = RandomTables::new(seed);
    let nodes = 2 + tables.pick(5);
    let mut scene = tables.scene(nodes);
    let settings = BrickSettings {
        brick_size_voxels: [4, 8][tables.pick(2)],
        encoding: Encoding::default(),
    };
    let resolution = 8 + tables.pick(6) as u32;
    let program = Program::lower(&scene);
    if program.map_or(true, |program| program.max_iterations() > MAX_ITERATIONS) {
        return Ok([0, 0]);
    }
    let mut rig = EditRig::of(&mut scene, resolution, &settings);
    for edit in 0..edits {
        if rig.bricks().len() as u64 * u64::from(rig.layout.brick_samples()) > MAX_SAMPLES {
            return Ok([edit, rig.rebakes]);
        }
        let before = scene.to_json();
        tables.edit(&mut scene);
        let layout = rig.layout;
        let is_slow = |program: Program| {
            let solid = program.aabb();
            let voxels = solid.size().max_element() / layout.voxel_grid().voxel_size;
            solid.is_finite() && voxels > MAX_VOXELS
                || program.max_iterations() > MAX_ITERATIONS
                || IncrementalProgram::new(&scene, layout.parts(&program)).is_err()
        };
        // A world refuses what cannot be lowered.
        if Program::lower(&scene).map_or(true, is_slow) {
            scene.undo();
        }
        rig.follow(&mut scene);
        let (differing, first) = rig.compare(&scene);
        if differing != 0 {
            let first = first.unwrap_or_default();
            return Err(format!(
                "seed {seed}, edit {edit}: {differing} cells differ at resolution {resolution}, {settings:?}, as\n\
                 {first}\n\
                 before: {before}\nafter: {}",
                scene.to_json()
            ));
        }
    }
    Ok([edits, rig.rebakes])
}
