//! Meshes of random scenes of all rows of the tables are closed and manifold: from bricks, simplified, and from levels.

use argil_conformance::{RandomTables, all_cases};
use argil_field::Program;
use argil_mesh::levels::mesh_levels;
use argil_mesh::{Mesh, MeshReport, marching, simplify};
use argil_scene::Scene;
use argil_volume::{BrickLayout, BrickSettings, Bricks, Levels, LevelsLayout, VoxelGrid};

/// Random scenes beside those of the tables.
const SCENES: u64 = 60;
/// Programs that take longer are left out.
const MAX_ITERATIONS: u64 = 2000;

/// Returns programs whose solids are of a limited size.
fn programs() -> impl Iterator<Item = (String, Program)> {
    let cases = all_cases().into_iter().map(|case| (case.name, case.scene));
    let random = (0..SCENES).map(|seed| {
        let scene = RandomTables::new(seed).scene(3);
        (format!("random scene {seed}: {}", scene.to_json()), scene)
    });
    cases.chain(random).filter_map(|(name, scene): (_, Scene)| {
        let program = Program::lower(&scene).ok()?;
        let is_small = program.aabb().is_finite() && program.max_iterations() < MAX_ITERATIONS;
        is_small.then_some((name, program))
    })
}

fn layout(program: &Program, resolution: u32) -> Option<BrickLayout> {
    let grid = VoxelGrid::fitting(program.aabb(), None, resolution).ok()?;
    BrickLayout::new(grid, &BrickSettings::default()).ok()
}

fn assert_manifold(name: &str, mesh: &Mesh) {
    let report = MeshReport::of(mesh);
    assert!(
        report.triangles == 0 || report.is_watertight(),
        "{name}: {report:?}"
    );
}

#[test]
fn simplified_meshes_are_manifold() {
    let mut compared = 0;
    for (name, program) in programs() {
        let Some(layout) = layout(&program, 40) else {
            continue;
        };
        let (bricks, _) = Bricks::bake(&program, layout, None).expect("bricks");
        let mesh = marching::bricks::march(&bricks).mesh;
        assert_manifold(&name, &mesh);
        for share in [3, 10, 50] {
            let (coarse, _) = simplify(&mesh, mesh.triangles.len() / share).expect("a mesh");
            assert_manifold(&format!("1/{share} of {name}"), &coarse);
        }
        compared += 1;
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn meshes_of_levels_are_manifold() {
    let mut compared = 0;
    for (name, program) in programs() {
        let Some(finest) = layout(&program, 128) else {
            continue;
        };
        let grid = *finest.voxel_grid();
        let layout = LevelsLayout::new(grid, &BrickSettings::default()).expect("a layout");
        let mut levels = Levels::bake(&program, layout, 1 << 28).expect("levels");
        // Voxels have the size of one where the eye is, and eight times that at the far side.
        let eye = program.aabb().min;
        levels.refine_around(&program, eye, 0.1);
        assert_manifold(&name, &mesh_levels(&levels).mesh);
        compared += 1;
    }
    assert!(compared > 100, "{compared}");
}
