//! Tests edits: refused edits, undo, and the speed of many edits.

use argil_scene::{Brush, Edit, EditError, Group, HistoryLimit, Modifier, NodeKind, Scene, Shape};

fn ball() -> Brush {
    Brush::new(Shape::sphere(0.5))
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of edits")]
fn refused_edits_leave_the_scene_unchanged() {
    let mut scene = Scene::new();
    let brush = scene.push(ball().with_name("ball")).unwrap().node;
    let group = scene.push(Group::new()).unwrap().node;
    let inner = scene.push_into(group, Group::new()).unwrap().node;
    let before = scene.to_json();
    let entry = || ball().into();
    let mut refused = |edit: Edit, expected: &str| {
        let error = scene.apply(edit).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error} does not say {expected}");
        assert_eq!(scene.to_json(), before);
    };
    refused(
        Edit::Insert {
            parent: brush,
            index: 0,
            desc: entry(),
        },
        "brushes[0] is a brush",
    );
    refused(
        Edit::Insert {
            parent: Scene::ROOT,
            index: 3,
            desc: entry(),
        },
        "index 3 is past the end",
    );
    refused(Edit::Remove { node: Scene::ROOT }, "root");
    refused(
        Edit::Move {
            node: group,
            parent: inner,
            index: 0,
        },
        "brushes[1] cannot be moved into itself",
    );
    refused(
        Edit::Move {
            node: brush,
            parent: Scene::ROOT,
            index: 2,
        },
        "index 3 is past the end",
    );
    refused(
        Edit::Replace {
            node: group,
            desc: entry(),
        },
        "cannot change between brush and group",
    );
    let shell = Modifier::Shell {
        half_thickness: 0.1,
    };
    refused(
        Edit::Transform {
            node: brush,
            by: shell,
        },
        "only translate, rotate and scale",
    );
    let nan = Modifier::Translate {
        by: [f32::NAN, 0.0, 0.0],
    };
    refused(
        Edit::Transform {
            node: brush,
            by: nan,
        },
        "modifiers[0].by[0]: NaN",
    );
    let gone = ball().with_material("gold").into();
    refused(
        Edit::Insert {
            parent: group,
            index: 0,
            desc: gone,
        },
        "no material \"gold\"",
    );
    let flat = Brush::new(Shape::sphere(0.0)).into();
    refused(
        Edit::Replace {
            node: brush,
            desc: flat,
        },
        "shape.radius: 0 is not positive",
    );

    // What was removed cannot be edited until it is back.
    scene.apply(Edit::Remove { node: group }).unwrap();
    let hide = Edit::SetVisible {
        node: inner,
        visible: false,
    };
    assert_eq!(scene.apply(hide.clone()), Err(EditError::NoSuchNode(inner)));
    assert!(scene.undo().is_some());
    assert!(scene.apply(hide).is_ok());
}

#[test]
fn undo_and_redo_walk_through_every_state() {
    let mut scene = Scene::new();
    let mut states = vec![scene.to_json()];
    let a = scene.push(ball()).unwrap().node;
    states.push(scene.to_json());
    let group = scene
        .push(Group::new().subtract().smooth(0.1))
        .unwrap()
        .node;
    states.push(scene.to_json());
    for edit in [
        Edit::Move {
            node: a,
            parent: group,
            index: 0,
        },
        Edit::Transform {
            node: a,
            by: Modifier::Translate {
                by: [1.0, 0.0, 0.0],
            },
        },
        Edit::Transform {
            node: a,
            by: Modifier::Translate {
                by: [0.0, 2.0, 0.0],
            },
        },
        Edit::SetVisible {
            node: group,
            visible: false,
        },
        Edit::Replace {
            node: a,
            desc: Brush::new(Shape::torus(1.0, 0.1)).into(),
        },
        Edit::Remove { node: group },
    ] {
        scene.apply(edit).unwrap();
        states.push(scene.to_json());
    }
    for state in states.iter().rev().skip(1) {
        assert!(scene.undo().is_some());
        assert_eq!(&scene.to_json(), state);
    }
    assert!(scene.undo().is_none());
    for state in states.iter().skip(1) {
        assert!(scene.redo().is_some());
        assert_eq!(&scene.to_json(), state);
    }
    assert!(scene.redo().is_none());
    // A new edit ends what could be redone.
    scene.undo();
    scene.push(ball()).unwrap();
    assert!(scene.redo().is_none());
}

/// Quadratic work would take minutes here.
#[test]
fn a_hundred_thousand_brushes_can_be_pushed_and_undone() {
    let mut scene = Scene::new();
    for i in 0..100_000 {
        scene
            .push(ball().at([i as f32, 0.0, 0.0]).smooth(0.1))
            .unwrap();
    }
    assert_eq!(scene.brush_count(), 100_000);
    for _ in 0..1000 {
        assert!(scene.undo().is_some());
    }
    assert_eq!(scene.brush_count(), 99_000);
}

#[test]
fn a_stroke_is_one_step() {
    let mut scene = Scene::new();
    let brush = scene.push(ball()).unwrap().node;
    let before = scene.to_json();
    scene.begin_stroke();
    for _ in 0..10_000 {
        let by = Modifier::Translate {
            by: [0.01, 0.0, 0.0],
        };
        scene.apply(Edit::Transform { node: brush, by }).unwrap();
    }
    scene.push(ball().at([9.0, 0.0, 0.0])).unwrap();
    scene.end_stroke();
    let after = scene.to_json();
    assert_eq!([scene.undo_depth(), scene.redo_depth()], [2, 0]);
    let undone = scene.undo().unwrap();
    assert_eq!(scene.to_json(), before);
    // From where the brush was to where it went.
    assert!(undone.dirty_box.contains([0.0; 3].into()));
    assert!(undone.dirty_box.contains([100.0, 0.0, 0.0].into()));
    scene.redo().unwrap();
    assert_eq!(scene.to_json(), after);
    // A stroke that did nothing leaves no step; one that is under way ends with an undo.
    scene.begin_stroke();
    scene.end_stroke();
    assert_eq!([scene.undo_depth(), scene.redo_depth()], [2, 0]);
    scene.begin_stroke();
    scene.push(ball()).unwrap();
    assert!(scene.undo().is_some());
    assert_eq!(scene.to_json(), after);
}

#[test]
fn changes_name_the_node_and_its_groups() {
    let mut scene = Scene::new();
    let group = scene.push(Group::new()).unwrap().node;
    let brush = scene.push_into(group, ball()).unwrap().node;
    let other = scene.push(Group::new()).unwrap().node;
    let seen = scene.change_count();
    let parent = other;
    let index = 0;
    scene
        .apply(Edit::Move {
            node: brush,
            parent,
            index,
        })
        .unwrap();
    scene.apply(Edit::Remove { node: other }).unwrap();
    scene.undo();
    let changes: Vec<_> = scene
        .changes_since(seen)
        .expect("changes")
        .iter()
        .map(|c| (c.node, c.parents))
        .collect();
    let expected = [
        (Some(brush), [Some(group), Some(other)]),
        (Some(other), [Some(Scene::ROOT), None]),
        (Some(other), [None, Some(Scene::ROOT)]),
    ];
    assert_eq!(changes, expected);
    let stone = argil_scene::Material::default();
    scene.set_material("stone", stone.clone()).unwrap();
    scene.set_material("stone", stone).unwrap();
    assert_eq!(scene.change_count(), seen + 4);
    assert_ne!(scene.clone().id(), scene.id());
}

/// Returns a grid of one cell with a given distance everywhere.
fn grid(distance: f32) -> std::sync::Arc<argil_scene::SampledGrid> {
    use argil_math::Aabb;
    use glam::{UVec3, Vec3};
    let same = move |_: &[Vec3], out: &mut [f32]| out.fill(distance);
    let solid = Aabb::new(Vec3::ZERO, Vec3::ONE);
    argil_scene::SampledGrid::sample(Vec3::ZERO, 1.0, UVec3::ONE, solid, &same).into()
}

#[test]
fn a_replaced_mesh_also_applies_to_undone_nodes() {
    let mut scene = Scene::new();
    let mesh = Brush::new(Shape::mesh("a.obj"));
    let Shape::Mesh { resolution, .. } = Shape::mesh("a.obj") else {
        panic!("a mesh")
    };
    let node = scene.push(mesh.clone()).expect("a mesh").node;
    let has = |scene: &Scene, wanted: f32| match &scene.node(node).desc().kind {
        NodeKind::Shape(Shape::Mesh { grid: stored, .. }) => {
            stored.0.as_deref() == Some(&*grid(wanted))
        }
        _ => false,
    };
    scene.set_mesh_grid("a.obj", resolution, grid(2.0));
    assert!(has(&scene, 2.0));
    let entry = mesh.at([1.0, 0.0, 0.0]).into();
    scene
        .apply(Edit::Replace { node, desc: entry })
        .expect("an edit");
    scene.set_mesh_grid("a.obj", resolution, grid(3.0));
    assert!(has(&scene, 3.0));
    scene.undo();
    assert!(has(&scene, 3.0), "not what it was when it was moved");
}

#[test]
fn renaming_meshes_also_renames_them_in_the_history() {
    let mut scene = Scene::new();
    let Shape::Mesh { resolution, .. } = Shape::mesh("") else {
        panic!("a mesh")
    };
    for path in ["a.obj", "b.obj"] {
        scene.push(Brush::new(Shape::mesh(path))).expect("a mesh");
        scene.set_mesh_grid(path, resolution, grid(2.0));
    }
    let node = scene.node(Scene::ROOT).children()[0];
    let entry = Brush::new(Shape::mesh("a.obj")).at([1.0, 0.0, 0.0]).into();
    scene
        .apply(Edit::Replace { node, desc: entry })
        .expect("an edit");
    let line = r#"{"edit": "rename_meshes", "paths": {"a.obj": "b.obj", "b.obj": "c.obj"}}"#;
    let mut other = scene.clone();
    assert_eq!(other.apply_log_line(line).expect("a line"), None);
    assert_eq!(other.mesh_paths(), ["b.obj", "c.obj"]);
    // It was no step: what is undone is the edit before it.
    assert_eq!(
        [other.undo_depth(), other.redo_depth()],
        [scene.undo_depth(), scene.redo_depth()]
    );
    other.undo();
    assert_eq!(other.mesh_paths(), ["b.obj", "c.obj"]);
    assert!(other.node(node).desc().modifiers.is_empty());
    // What is put in by its new name is known.
    other
        .push(Brush::new(Shape::mesh("c.obj")))
        .expect("a mesh");
    assert!(other.missing_meshes().is_empty());
    other
        .push(Brush::new(Shape::mesh("a.obj")))
        .expect("a mesh");
    assert_eq!(other.missing_meshes(), [("a.obj".to_owned(), resolution)]);
}

/// A follower that missed forgotten changes is told to start again, and no list grows without limit.
#[test]
fn recent_changes_are_stored() {
    let mut scene = Scene::new();
    let ball = scene.push(Brush::new(Shape::sphere(0.5))).expect("a brush");
    let by = Modifier::Translate {
        by: [1e-4, 0.0, 0.0],
    };
    let first = scene.change_count();
    for _ in 0..20_000 {
        let (node, by) = (ball.node, by.clone());
        scene.apply(Edit::Transform { node, by }).expect("an edit");
        scene.undo();
    }
    assert_eq!(scene.change_count(), first + 40_000);
    assert!(scene.changes_since(first).is_none());
    assert!(scene.changes_since(first + 50_000).is_none());
    let last = scene.changes_since(first + 39_990).expect("the last");
    assert_eq!(last.len(), 10);
    scene.push(Brush::new(Shape::sphere(0.1))).expect("a brush");
    scene.push(Brush::new(Shape::sphere(0.1))).expect("a brush");
    scene.forget_history(1);
    assert_eq!([scene.undo_depth(), scene.redo_depth()], [1, 0]);
    assert!(scene.undo().is_some() && scene.undo().is_none());
}

/// A history with a limit stays within it, by steps or by bytes, and frees what only it referred to. Thousands of
/// rotations of one node stay a few modifiers.
#[test]
fn histories_keep_to_a_limit() {
    let mut scene = Scene::new();
    let ball = scene.push(Brush::new(Shape::sphere(0.5))).expect("a brush");
    scene.set_history_limit(HistoryLimit {
        steps: 100,
        ..HistoryLimit::default()
    });
    for i in 0..2_000 {
        let node = ball.node;
        let by = Modifier::Rotate {
            axis: [1.0, (i % 3) as f32, 0.0],
            degrees: 1.0,
        };
        scene.apply(Edit::Transform { node, by }).expect("an edit");
        let other = scene.push(Brush::new(Shape::sphere(0.1)).with_name("x".repeat(500)));
        let node = other.expect("a brush").node;
        scene.apply(Edit::Remove { node }).expect("an edit");
        assert!(scene.undo_depth() <= 100);
    }
    assert!(scene.node(ball.node).desc().modifiers.len() <= 6);
    let steps = scene.undo_depth();
    for _ in 0..steps {
        assert!(scene.undo().is_some());
    }
    assert!(scene.undo().is_none());
    while scene.redo().is_some() {}
    scene.set_history_limit(HistoryLimit {
        bytes: 10_000,
        ..HistoryLimit::default()
    });
    let few = scene.undo_depth();
    assert!((1..steps).contains(&few), "{few} of {steps}");
    let fresh = scene.clone();
    while scene.undo().is_some() {}
    while scene.redo().is_some() {}
    assert!(scene == fresh);
}

/// A node of another scene is refused, even if a node of this scene has the same number. Clones know the nodes from
/// before the clone.
#[test]
fn nodes_of_other_scenes_are_refused() {
    let (mut one, mut other) = (Scene::new(), Scene::new());
    let mine = one.push(ball()).expect("a brush").node;
    let theirs = other.push(ball()).expect("a brush").node;
    assert_eq!(mine.index(), theirs.index());
    let remove = |node| Edit::Remove { node };
    assert_eq!(
        one.apply(remove(theirs)),
        Err(EditError::NoSuchNode(theirs))
    );
    assert!(one.get(theirs).is_none() && one.get(mine).is_some());
    let into = Edit::Insert {
        parent: theirs,
        index: 0,
        desc: ball().into(),
    };
    assert!(one.apply(into).is_err());
    let mut copy = one.clone();
    let in_copy = copy.push(ball()).expect("a brush").node;
    one.push(ball()).expect("a brush");
    assert!(one.apply(remove(in_copy)).is_err());
    assert!(copy.apply(remove(mine)).is_ok());
    assert!(one.get(mine).is_some());
}
