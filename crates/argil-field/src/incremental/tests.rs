use super::*;
use argil_scene::{Brush, Edit, Group, Modifier, Shape};
use glam::IVec3;

fn parts() -> PartGrid {
    PartGrid {
        corner: Vec3::splat(-1.0),
        edge: 0.25,
        far: 0.1,
        base: 2.0,
    }
}

/// An edit in a large group lowers one piece, and a part's program contains only what is near.
#[test]
fn an_edit_in_a_group_costs_what_it_touches() {
    let mut scene = Scene::new();
    let outer = Group::new().scaled(0.5).smooth(0.01);
    let outer = scene.push(outer).expect("a group").node;
    let group = Group::new().at([0.1, 0.0, 0.0]);
    let group = scene.push_into(outer, group).expect("a group").node;
    let mut nodes = Vec::new();
    for i in 0..512 {
        let at = [i % 8, i / 8 % 8, i / 64].map(|c| 0.5 * c as f32 - 1.75);
        let solid = Brush::new(Shape::sphere(0.1)).at(at).smooth(0.01);
        nodes.push(scene.push_into(group, solid).expect("a brush").node);
    }
    let mut live = IncrementalProgram::new(&scene, parts()).expect("a program");
    let seen = scene.change_count();
    let by = Modifier::Translate {
        by: [0.01, 0.0, 0.0],
    };
    scene
        .apply(Edit::Transform {
            node: nodes[99],
            by,
        })
        .expect("an edit");
    let changes = scene.changes_since(seen).expect("changes");
    let upset = live.update(&scene, changes).expect("a program");
    assert!(!upset.needs_rebuild);
    assert_eq!(live.dirty_ranges().len(), 1);
    let mut list = Vec::new();
    live.part_program(IVec3::splat(2), &mut list);
    assert!((5..60).contains(&list.len()), "{}", list.len());
    // The whole program equals one that is lowered at once.
    let (whole, fresh) = (
        live.to_program(),
        Program::lower(&scene).expect("a program"),
    );
    assert_eq!(whole.magnitude, fresh.magnitude);
    for i in 0..200 {
        let p = Vec3::new(i as f32, 1.7 * i as f32, 0.3 * i as f32).map(f32::sin);
        assert_eq!(whole.distance(p), fresh.distance(p), "{p}");
    }
}

/// The check covers the piece: one in a nested group, where only it is wrong, and one that left the scene.
#[test]
fn pieces_are_checked_where_they_are() {
    let mut scene = Scene::new();
    let outer = scene.push(Group::new().scaled(0.5)).expect("a group").node;
    // It leans, so many of the copies that overlap are near a point.
    let solid = Brush::new(Shape::capsule([-0.1; 3], [0.1; 3], 0.1));
    let good = scene.push_into(outer, solid.clone()).expect("a brush").node;
    let spacing = [0.001; 3];
    let many = solid.with_modifier(Modifier::Repeat {
        spacing,
        count: None,
    });
    let bad = scene.push_into(outer, many).expect("a brush").node;
    assert_eq!(Program::check(&scene, good), Ok(()));
    for node in [bad, outer] {
        let found = Program::check(&scene, node);
        assert!(
            matches!(&found, Err(LowerError::TooManyCopies { path, .. }) if path.ends_with("[1]")),
            "{found:?}"
        );
    }
    scene.apply(Edit::Remove { node: bad }).expect("an edit");
    for node in [bad, outer] {
        assert_eq!(Program::check(&scene, node), Ok(()));
    }
}
