//! Long programs of many instances.

use argil_field::Program;
use argil_math::Control;
use argil_scene::{Brush, Modifier, Pose, Scene, Shape};
use argil_volume::{BlockPlan, BrickLayout, BrickSettings, Bricks, VoxelGrid};

/// Returns spheres on a lattice, as a program and a layout of bricks that are larger than many of them.
fn many(side: u16, has_blend: bool) -> (Program, BrickLayout) {
    let count = u32::from(side).pow(3);
    let poses: Vec<Pose> = (0..count)
        .map(|i| {
            let side = u32::from(side);
            let place = [i % side, i / side % side, i / (side * side)];
            Pose {
                position: place.map(|c| c as f32 + 0.1 * (i % 7) as f32),
                degrees: 0.0,
                scale: 0.5 + (i % 11) as f32 / 20.0,
            }
        })
        .collect();
    let mut scene = Scene::new();
    let modifier = Modifier::Instances {
        poses: poses.into(),
    };
    let spheres = Brush::new(Shape::sphere(0.4)).with_modifier(modifier);
    scene.push(spheres).expect("spheres");
    if has_blend {
        let other = Brush::new(Shape::sphere(0.4)).at([3.0; 3]).smooth(0.2);
        scene.push(other).expect("a sphere");
    }
    let program = Program::lower(&scene).expect("a program");
    let grid = VoxelGrid::fitting(program.aabb(), None, 48).expect("a grid");
    let layout = BrickLayout::new(grid, &BrickSettings::default()).expect("a layout");
    (program, layout)
}

/// Blocks share the program of all instances if their own would be hardly shorter, and cells are pruned one by one.
#[test]
fn long_programs_are_shared_and_give_the_same_bricks() {
    for has_blend in [false, true] {
        let (program, layout) = many(34, has_blend);
        let all = program.instructions().len();
        assert!(all > 1 << 15, "{all}");
        let plan = BlockPlan::of(&program, &layout, None, &Control::default()).expect("a plan");
        assert!(plan.blocks.len() >= 8, "{}", plan.blocks.len());
        // The whole program, and what some blocks shorten to half.
        assert!(
            plan.instructions.len() < 4 * all,
            "{} of {all}",
            plan.instructions.len()
        );
        let (bricks, _) = Bricks::bake(&program, layout, None).expect("bricks");
        let (other, _, _) = Bricks::bake_with_programs(&program, layout, None).expect("bricks");
        assert!(bricks.len() > 100 && bricks == other, "{}", bricks.len());
    }
}
