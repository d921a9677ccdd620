//! Tests warnings about copies that coincide.

use argil_field::{CoincidingCopies, Program};
use argil_scene::{Brush, Edit, Group, Modifier, NodeDesc, Pose, Scene, Shape};
use glam::Vec3;

fn repeat(spacing: [f32; 3], count: Option<[u32; 3]>) -> Modifier {
    Modifier::Repeat { spacing, count }
}

fn instances(poses: &[[f32; 5]]) -> Modifier {
    let poses: Vec<Pose> = poses.iter().copied().map(Pose::from).collect();
    Modifier::Instances {
        poses: poses.into(),
    }
}

fn translate(by: [f32; 3]) -> Modifier {
    Modifier::Translate { by }
}

/// A name, a solid, modifiers of which the last makes copies, and whether all of these coincide.
type Case = (&'static str, Shape, Vec<Modifier>, bool);

fn instance_cases() -> Vec<Case> {
    let ball = || Shape::sphere(0.5);
    let cube = || Shape::cuboid([0.5; 3]);
    vec![
        (
            "equal poses",
            cube(),
            vec![instances(&[[1.0, 2.0, 3.0, 40.0, 2.0]; 3])],
            true,
        ),
        (
            "turned cubes",
            cube(),
            vec![instances(&[
                [1.0, 2.0, 3.0, 0.0, 1.0],
                [1.0, 2.0, 3.0, 90.0, 1.0],
            ])],
            true,
        ),
        (
            "oblique cubes",
            cube(),
            vec![instances(&[
                [0.0, 0.0, 0.0, 0.0, 1.0],
                [0.0, 0.0, 0.0, 45.0, 1.0],
            ])],
            false,
        ),
        (
            "poses of two sizes",
            ball(),
            vec![instances(&[
                [0.0, 0.0, 0.0, 0.0, 1.0],
                [0.0, 0.0, 0.0, 0.0, 2.0],
            ])],
            false,
        ),
        (
            "poses apart",
            ball(),
            vec![instances(&[
                [0.0, 0.0, 0.0, 0.0, 1.0],
                [3.0, 0.0, 0.0, 0.0, 1.0],
            ])],
            false,
        ),
        (
            "one pose",
            ball(),
            vec![instances(&[[0.0, 0.0, 0.0, 0.0, 1.0]])],
            false,
        ),
    ]
}

fn repetition_cases() -> Vec<Case> {
    let ball = || Shape::sphere(0.5);
    let cube = || Shape::cuboid([0.5; 3]);
    let ring = |count| Modifier::RadialRepeat { count };
    let away = || translate([1.0, 0.0, 0.0]);
    let few = Some([3, 1, 1]);
    vec![
        ("no spacing", ball(), vec![repeat([0.0; 3], None)], true),
        (
            "tiny spacing",
            ball(),
            vec![repeat([1e-6, 0.0, 0.0], few)],
            true,
        ),
        ("a row", ball(), vec![repeat([1.0, 0.0, 0.0], few)], false),
        (
            "a row that overlaps",
            ball(),
            vec![repeat([0.1, 0.0, 0.0], few)],
            false,
        ),
        (
            "one copy",
            ball(),
            vec![repeat([0.0; 3], Some([1; 3]))],
            false,
        ),
        ("a ring of balls on its axis", ball(), vec![ring(6)], true),
        ("a ring of cubes on its axis", cube(), vec![ring(4)], true),
        ("five cubes on their axis", cube(), vec![ring(5)], false),
        ("a ring of one", ball(), vec![ring(1)], false),
        (
            "a ring away from its axis",
            ball(),
            vec![away(), ring(6)],
            false,
        ),
        (
            "a ring around its axis",
            ball(),
            vec![translate([0.3, 0.0, 0.0]), ring(6)],
            false,
        ),
        (
            "copies of a row in one place",
            ball(),
            vec![
                repeat([1.5, 0.0, 0.0], few),
                repeat([0.0, 1e-6, 0.0], Some([1, 4, 1])),
            ],
            true,
        ),
    ]
}

#[test]
fn copies_in_one_place_are_found() {
    for (name, shape, modifiers, coincide) in [repetition_cases(), instance_cases()].concat() {
        let place = format!("modifiers[{}]", modifiers.len() - 1);
        let with = |mut entry: NodeDesc| {
            entry.modifiers = modifiers.clone();
            entry.name = name.to_owned();
            entry
        };
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::sphere(0.1))).expect("a brush");
        let brush: NodeDesc = Brush::new(shape.clone()).into();
        scene.push(with(brush)).expect("a brush");
        // And the same of a group.
        let group = scene.push(with(Group::new().into())).expect("a group").node;
        scene.push_into(group, Brush::new(shape)).expect("a brush");
        let expected = match coincide {
            true => vec![
                format!("brushes[1].{place} (\"{name}\")"),
                format!("brushes[2].{place} (\"{name}\")"),
            ],
            false => Vec::new(),
        };
        let found = CoincidingCopies::of(&scene);
        let places = found.iter().map(|copies| {
            copies
                .to_string()
                .split(": ")
                .next()
                .unwrap_or_default()
                .to_owned()
        });
        assert_eq!(places.collect::<Vec<_>>(), expected, "{name}");
        // Copies that coincide change no distance.
        if coincide {
            let mut plain = scene.clone();
            for copies in found {
                let mut entry = plain.node(copies.node).desc().clone();
                entry.modifiers.pop();
                let edit = Edit::Replace {
                    node: copies.node,
                    desc: entry,
                };
                plain.apply(edit).expect("an entry");
            }
            if !name.contains("pose") && !name.contains("turned") {
                let [with, without] =
                    [&scene, &plain].map(|scene| Program::lower(scene).expect("a program"));
                for at in [[0.7, 0.1, 0.2], [0.2, 0.6, -0.4], [-0.9, 0.3, 0.8]].map(Vec3::from) {
                    let difference = with.distance(at) - without.distance(at);
                    assert!(difference.abs() < 1e-4, "{name} {at}: {difference}");
                }
            }
        }
    }
}
