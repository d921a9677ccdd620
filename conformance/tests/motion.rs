//! Which brushes edits move, and how far.

use argil_conformance::{CaseRng, all_cases};
use argil_field::{IncrementalProgram, MovedBrush, PartGrid, Program};
use argil_scene::{Brush, Edit, Group, Modifier, Scene, Shape};
use glam::{DAffine3, DQuat, DVec3, Vec3};

const PARTS: PartGrid = PartGrid {
    corner: Vec3::splat(-2.0),
    edge: 0.5,
    far: 0.2,
    base: 4.0,
};

/// What edits do to a node, and the same as a map of the scene.
fn transforms() -> [(Modifier, DAffine3); 4] {
    let shift = [0.1, -0.05, 0.2];
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.4);
    [
        (
            Modifier::Translate { by: shift },
            DAffine3::from_translation(Vec3::from(shift).as_dvec3()),
        ),
        (
            Modifier::Rotate {
                axis: [1.0, 2.0, -0.5],
                degrees: 0.4_f32.to_degrees(),
            },
            DAffine3::from_quat(turn),
        ),
        (
            Modifier::Scale { by: 1.25 },
            DAffine3::from_scale(DVec3::splat(1.25)),
        ),
        (
            Modifier::Stretch {
                by: [1.2, 0.9, 1.0],
            },
            DAffine3::from_scale(DVec3::new(1.2, 0.9, 1.0)),
        ),
    ]
}

/// Any node of any case that an edit moves, turns or scales says so: each of its brushes has the inverse of the edit. An edit of
/// anything else says that nothing moved.
#[test]
fn what_edits_move_is_known() {
    let mut numbers = CaseRng::new(3);
    for case in all_cases() {
        let mut scene = case.scene;
        let program = Program::lower(&scene).expect("a program");
        let mut live = IncrementalProgram::new(&scene, PARTS).expect("a program");
        let shapes = program.instructions().iter();
        let brushes = shapes
            .filter(|instr| instr.op < argil_abi::OP_SHAPES_END)
            .count();
        for (by, map) in transforms() {
            let mut found = Vec::new();
            for node in scene.node(Scene::ROOT).children().to_vec() {
                let before = scene.change_count();
                let is_refused = match &by {
                    Modifier::Stretch { .. } => {
                        let mut desc = scene.node(node).desc().clone();
                        desc.modifiers.push(by.clone());
                        scene.apply(Edit::Replace { node, desc }).is_err()
                    }
                    _ => scene
                        .apply(Edit::Transform {
                            node,
                            by: by.clone(),
                        })
                        .is_err(),
                };
                assert!(!is_refused, "{}: {by:?}", case.name);
                let changes = scene.changes_since(before).expect("changes");
                live.update(&scene, changes).expect("a program");
                found.extend(live.moved().expect("few brushes"));
            }
            // A stretch around what turned is no longer told from a change of the form.
            if !matches!(by, Modifier::Stretch { .. }) {
                assert!(
                    found.len() >= brushes,
                    "{}: {by:?}: {}",
                    case.name,
                    found.len()
                );
            }
            for moved in found {
                let point = numbers.point(1.0).as_dvec3();
                let [expected, found] =
                    [map.inverse(), moved.before_from_now].map(|map| map.transform_point3(point));
                assert!(
                    found.distance(expected) < 2e-5,
                    "{}: {by:?}: {found}, not {expected}",
                    case.name
                );
            }
        }
        // Another operator moves nothing.
        for node in scene.node(Scene::ROOT).children().to_vec() {
            let before = scene.change_count();
            let mut desc = scene.node(node).desc().clone();
            desc.operator.blend += 0.01;
            if scene.apply(Edit::Replace { node, desc }).is_err() {
                continue;
            }
            let changes = scene.changes_since(before).expect("changes");
            live.update(&scene, changes).expect("a program");
            assert_eq!(live.moved().as_deref(), Some(&[][..]), "{}", case.name);
        }
    }
}

/// Two balls that change their places in a blended group did not move. One that does is followed, and a group of very many balls is
/// not.
#[test]
fn one_thing_moves_in_a_piece() {
    let balls = |count: u16| {
        let mut scene = Scene::new();
        let group = scene.push(Group::new().smooth(0.02)).expect("a group").node;
        let at = |number: u16| [0.001 * f32::from(number), 0.3 * f32::from(number % 2), 0.0];
        let all = (0..count).map(|number| {
            let ball = Brush::new(Shape::sphere(0.1)).at(at(number));
            scene.push_into(group, ball).expect("a ball").node
        });
        let all: Vec<_> = all.collect();
        (scene, group, all)
    };
    let by = || Modifier::Translate {
        by: [0.1, 0.0, 0.0],
    };
    let moved = |scene: &mut Scene, edit: Edit| {
        let mut live = IncrementalProgram::new(scene, PARTS).expect("a program");
        let before = scene.change_count();
        scene.apply(edit).expect("an edit");
        let changes = scene.changes_since(before).expect("changes");
        live.update(scene, changes).expect("a program");
        let all = live.moved()?;
        let is_moved = |brush: &&MovedBrush| brush.before_from_now != DAffine3::IDENTITY;
        Some(all.iter().filter(is_moved).count())
    };
    let (mut scene, group, nodes) = balls(2);
    let swap = Edit::Move {
        node: nodes[0],
        parent: group,
        index: 1,
    };
    assert_eq!(moved(&mut scene, swap), Some(0));
    let (node, by_one) = (nodes[1], by());
    let one = Edit::Transform { node, by: by_one };
    assert_eq!(moved(&mut scene, one), Some(1));
    let whole = |node| Edit::Transform { node, by: by() };
    assert_eq!(moved(&mut scene, whole(group)), Some(2));
    let (mut scene, group, _) = balls(1100);
    assert_eq!(moved(&mut scene, whole(group)), None);
}
