//! Pruned programs and programs far from the origin, against the whole program at the origin.

use argil_field::{Evaluator, Program, Pruner};
use argil_scene::{Brush, Group, Modifier, Pose, Scene, Shape};
use glam::{DVec3, Vec3};

/// Far spheres, instances of which two are near, and what is near, so that groups begin and end anywhere in a run of
/// instructions that are dropped.
fn scene(lead: u16, count: u16) -> Result<Scene, Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    // Smaller than a stone, whose own frame is here too.
    scene.push(Shape::sphere(0.05))?;
    for i in 0..lead {
        scene.push(Brush::new(Shape::sphere(0.5)).at([60.0 + f32::from(i), 0.0, 0.0]))?;
    }
    let poses: Vec<Pose> = (0..count)
        .map(|i| Pose {
            position: if i % 30 == 7 {
                [0.7, 0.1 * f32::from(i % 4), 0.0]
            } else {
                [90.0 + 3.0 * f32::from(i), f32::from(i % 5), 0.0]
            },
            degrees: f32::from(i) * 13.0,
            scale: 1.0,
        })
        .collect();
    // An instance has seven instructions, so that groups end anywhere in a run of eight.
    let stones = Group::new().with_modifier(Modifier::Instances {
        poses: poses.into(),
    });
    let stones = scene.push(stones)?.node;
    scene.push_into(stones, Shape::cuboid([0.3, 0.2, 0.1]))?;
    scene.push_into(stones, Shape::cuboid([0.1, 0.3, 0.1]))?;
    scene.push(
        Brush::new(Shape::sphere(0.2))
            .at([0.0, 0.5, 0.0])
            .smooth(0.1),
    )?;
    Ok(scene)
}

#[test]
fn a_pruned_program_has_the_distances_of_the_whole_one() -> Result<(), Box<dyn std::error::Error>> {
    let centers: Vec<Vec3> = (0..8u8)
        .map(|i| Vec3::new(f32::from(i & 1), f32::from(i >> 1 & 1), f32::from(i >> 2)) - 0.5)
        .collect();
    for (lead, count) in (0..48).map(|i| (i % 5, 24 + i)) {
        let program = Program::lower(&scene(lead, count)?)?;
        let all = program.instructions();
        let mut pruner = Pruner::new(&program);
        pruner.classify_cells(all, &centers, 0.9, &mut [0.0; 8]);
        let marks = pruner.cell_marks();
        let mut evaluator = Evaluator::new(&program);
        for (cell, center) in centers.iter().enumerate() {
            let (mut list, mut marked) = (Vec::new(), Vec::new());
            pruner.prune_into(all, cell, &mut list);
            pruner.prune_marked_into(all, &marks, cell, &mut marked);
            assert_eq!(list, marked);
            assert!(
                list.len() < all.len() / 2,
                "{} of {}",
                list.len(),
                all.len()
            );
            let along = |axis: usize| [-0.4, 0.0, 0.3].map(|by: f32| center[axis] + by);
            let [x, y, z] = [along(0), along(1), along(2)];
            let (mut whole, mut pruned) = ([0.0; 3], [0.0; 3]);
            evaluator.distances(&x, &y, &z, &mut whole);
            evaluator.distances_with(&list, &x, &y, &z, &mut pruned);
            assert_eq!(
                whole, pruned,
                "{lead} far spheres, {count} instances, cell {cell}"
            );
        }
    }
    Ok(())
}

#[test]
fn an_endless_repetition_is_as_precise_anywhere() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let column = Brush::new(Shape::cuboid([0.5, 1.2, 0.5])).rotated([0.0, 1.0, 0.0], 30.0);
    scene.push(column.with_modifier(Modifier::Repeat {
        spacing: [4.0, 0.0, 4.0],
        count: None,
    }))?;
    let program = Program::lower(&scene)?;
    let mut evaluator = Evaluator::new(&program);
    let (x, y, z) = ([0.713, 1.9, -3.2], [0.31, 1.3, 0.0], [1.017, -0.4, 2.6]);
    let (mut near, mut far) = ([0.0; 3], [0.0; 3]);
    evaluator.distances(&x, &y, &z, &mut near);
    evaluator.set_origin(Some(DVec3::new(400_000.0, 0.0, -100_000.0)));
    evaluator.distances(&x, &y, &z, &mut far);
    for (near, far) in near.iter().zip(far) {
        assert!((near - far).abs() < 1e-6, "{near} {far}");
    }
    Ok(())
}
