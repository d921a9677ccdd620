//! Tests edits as lines of text.

use argil_scene::{Brush, Edit, Group, Material, Modifier, NodeDesc, Scene, Shape};

fn ball(radius: f32) -> Brush {
    Brush::new(Shape::sphere(radius)).smooth(0.05)
}

/// A log of any edits of one scene gives the same result in another scene with the same start.
#[test]
fn a_log_replays_on_another_scene() {
    let mut scene = Scene::new();
    scene.set_material("stone", Material::default()).unwrap();
    let mut other = scene.clone();
    let mut lines = Vec::new();
    let mut done = |scene: &mut Scene, edit: Edit| {
        lines.push(scene.log_line(&edit));
        scene.apply(edit).unwrap().node
    };
    let insert = |parent, index, entry: NodeDesc| Edit::Insert {
        parent,
        index,
        desc: entry,
    };
    let group = done(
        &mut scene,
        insert(Scene::ROOT, 0, Group::new().subtract().into()),
    );
    let a = done(
        &mut scene,
        insert(group, 0, ball(0.5).with_material("stone").into()),
    );
    let b = done(
        &mut scene,
        insert(Scene::ROOT, 0, ball(0.3).with_name("b").into()),
    );
    let by = Modifier::Rotate {
        axis: [0.0, 1.0, 0.0],
        degrees: 33.25,
    };
    done(&mut scene, Edit::Transform { node: a, by });
    done(
        &mut scene,
        Edit::Move {
            node: b,
            parent: group,
            index: 1,
        },
    );
    done(
        &mut scene,
        Edit::SetVisible {
            node: b,
            visible: false,
        },
    );
    let entry = ball(0.1).chamfer(0.02).hidden().into();
    done(
        &mut scene,
        Edit::Replace {
            node: a,
            desc: entry,
        },
    );
    done(&mut scene, Edit::Remove { node: b });
    for line in &lines {
        assert!(other.apply_log_line(line).unwrap().is_some(), "{line}");
    }
    assert_eq!(other, scene);
    assert_eq!(other.to_json(), scene.to_json());
    // Undone and redone by lines too.
    for line in [
        "{\"edit\": \"undo\"}",
        "{\"edit\": \"undo\"}",
        "{\"edit\": \"redo\"}",
    ] {
        other.apply_log_line(line).unwrap();
    }
    scene.undo();
    assert_eq!(other, scene);
}

/// A group is inserted with all of its contents, as one step.
#[test]
fn a_group_with_brushes_is_one_step() {
    let mut scene = Scene::new();
    let line = r#"{"edit": "insert", "entry": {"blend": 0.1, "brushes": [
        {"shape": {"type": "sphere", "radius": 1}},
        {"operator": "subtract", "brushes": [{"shape": {"type": "sphere", "radius": 0.5}}]}]}}"#;
    let outcome = scene.apply_log_line(line).unwrap().unwrap();
    assert_eq!(scene.brush_count(), 2);
    assert_eq!(scene.path(outcome.node), "brushes[0]");
    assert!(
        scene
            .node_by_path("brushes[0].brushes[1].brushes[0]")
            .is_some()
    );
    assert!(scene.undo().is_some());
    assert_eq!(scene.brush_count(), 0);
    assert!(scene.undo().is_none());
}

/// A tree joins the scene as a whole, so that its depth costs nothing for each of its nodes.
#[test]
fn a_deep_group_is_one_change() {
    let mut tree = argil_scene::NodeTree::from(ball(0.5));
    for _ in 0..20_000 {
        let mut group = argil_scene::NodeTree::from(argil_scene::Group::new());
        group.children.push(tree);
        tree = group;
    }
    let mut scene = Scene::new();
    let before = scene.change_count();
    scene.push(tree).unwrap();
    assert_eq!(scene.change_count(), before + 1);
    let whole = scene.clone();
    scene.undo().unwrap();
    assert_eq!(scene.brush_count(), 0);
    scene.redo().unwrap();
    assert_eq!(scene.change_count(), before + 3);
    assert!(scene == whole && scene.brush_count() == 1);
}

#[test]
fn lines_that_cannot_be_done_say_why_and_change_nothing() {
    let mut scene = Scene::new();
    scene.push(ball(0.5)).unwrap();
    let before = scene.to_json();
    for (line, reason) in [
        ("", "EOF"),
        ("{", "column 1"),
        ("[]", "missing field `edit`"),
        ("{\"edit\": \"explode\"}", "unknown variant `explode`"),
        (
            "{\"edit\": \"undo\", \"twice\": 1}",
            "unknown field `twice`",
        ),
        ("{\"edit\": \"remove\"}", "missing field `node`"),
        (
            "{\"edit\": \"remove\", \"node\": 3}",
            "column 28: node: invalid type",
        ),
        (
            "{\"edit\": \"remove\", \"node\": \"brushes[7]\"}",
            "no brushes[7]",
        ),
        (
            "{\"edit\": \"remove\", \"node\": \"brushes[0].x\"}",
            "no brushes[0].x",
        ),
        ("{\"edit\": \"remove\", \"node\": \"\"}", "root group"),
        (
            "{\"edit\": \"insert\", \"into\": \"brushes[0]\", \"entry\": {\"brushes\": []}}",
            "brushes[0] is a brush",
        ),
        (
            "{\"edit\": \"insert\", \"entry\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0}}}",
            "shape.radius: 0 is not positive",
        ),
        (
            "{\"edit\": \"insert\", \"entry\": {\"brushes\": [{\"shape\": {\"type\": \"sphere\", \"radius\": -1}}]}}",
            "shape.radius: -1",
        ),
        (
            "{\"edit\": \"insert\", \"index\": 9, \"entry\": {\"brushes\": []}}",
            "index 9 is past the end",
        ),
        (
            "{\"edit\": \"transform\", \"node\": \"brushes[0]\", \"by\": {\"type\": \"translate\", \"by\": [1e999, 0, 0]}}",
            "number out of range",
        ),
        (
            "{\"edit\": \"transform\", \"node\": \"brushes[0]\", \"by\": {\"type\": \"translate\", \"by\": [NaN, 0, 0]}}",
            "column",
        ),
        ("{\"edit\": \"redo\"}", "nothing to redo"),
    ] {
        let error = scene.apply_log_line(line).expect_err(line).to_string();
        assert!(
            error.contains(reason),
            "{line}: {error} does not say {reason}"
        );
        assert_eq!(scene.to_json(), before, "{line}");
    }
}

/// A misspelt name is named at its column, with the nearest right one, wherever it is in a line.
#[test]
fn misspelt_names_are_named_at_their_place() {
    let scene = Scene::new();
    let sphere = |field: &str| format!(r#"{{"shape": {{"type": "sphere", "{field}": 0.1}}}}"#);
    let insert = |entry: &str| format!(r#"{{"edit": "insert", "entry": {entry}}}"#);
    let (ball, wrong) = (sphere("radius"), sphere("raduis"));
    let deep = (0..60).fold(ball.clone(), |inner, _| {
        format!(r#"{{"brushes": [{inner}]}}"#)
    });
    assert!(scene.read_action(&insert(&deep)).is_ok());
    for (line, misspelt, right) in [
        (insert(&wrong), "raduis", "radius"),
        (insert(&format!(r#"{{"brushes": [{ball}, {wrong}]}}"#)), "raduis", "radius"),
        (insert(&ball.replace("sphere", "spere")), "spere", "sphere"),
        (insert(&ball.replace("\"shape\"", "\"blnd\": 0.1, \"shape\"")), "blnd", "blend"),
        (insert(&ball).replace("\"entry\"", "\"indx\": 0, \"entry\""), "indx", "index"),
        (insert(&ball).replace("insert", "insrt"), "insrt", "insert"),
        (
            r#"{"edit": "transform", "node": "brushes[0]", "by": {"type": "rotate", "axis": [0, 1, 0], "degree": 3}}"#.into(),
            "degree",
            "degrees",
        ),
        (
            r#"{"edit": "set_material", "name": "stone", "material": {"rougness": 0.5}}"#.into(),
            "rougness",
            "roughness",
        ),
        (r#"{"edit": "set_view", "view": {"ligts": []}}"#.into(), "ligts", "lights"),
    ] {
        let error = scene.read_action(&line).expect_err(&line).to_string();
        assert!(error.contains(&format!("did you mean `{right}`?")), "{line}: {error}");
        let column = 1 + line.find(&format!("\"{misspelt}\"")).expect(misspelt);
        assert!(error.starts_with(&format!("column {column}: ")), "{line}: {error}");
    }
}

/// An edit that a check refuses leaves no trace, in a stroke or outside. The steps to undo and redo stay.
#[test]
fn refused_edits_leave_no_trace() {
    #[derive(Debug, thiserror::Error)]
    #[error("no")]
    struct No;
    let refuse = Err(());
    let accept = Ok(());
    let checked = |scene: &mut Scene, line: &str, answer: Result<(), ()>| {
        let action = scene.read_action(line)?;
        scene.perform_checked(&action, |_, _| answer.map_err(|()| No))
    };
    let ball = r#"{"edit":"insert","entry":{"shape":{"type":"sphere","radius":0.5}}}"#;
    let group = r#"{"edit":"insert","entry":{"brushes":[{"shape":{"type":"sphere","radius":0.5}},{"brushes":[]}]}}"#;
    let grow = r#"{"edit":"transform","node":"brushes[0]","by":{"type":"scale","by":2}}"#;
    let mut scene = Scene::new();
    for _ in 0..3 {
        checked(&mut scene, ball, accept).expect("an edit");
    }
    assert!(scene.undo().is_some());
    let (before, lengths) = (scene.clone(), [scene.undo_depth(), scene.redo_depth()]);
    let counts = |scene: &Scene| (scene.node_count(), scene.change_count());
    let (seen, mut copy) = (counts(&scene), scene.replica());
    for line in [ball, group, grow] {
        assert!(checked(&mut scene, line, refuse).is_err());
        assert!(scene == before && [scene.undo_depth(), scene.redo_depth()] == lengths);
        assert_eq!(counts(&scene), seen);
    }
    // Who follows it by what was done, and not what was refused, has nodes of the same ids.
    let action = scene.read_action(group).expect("a line");
    let outcomes = [&mut scene, &mut copy].map(|scene| scene.perform(&action).expect("an edit"));
    assert_eq!(
        outcomes[0].map(|outcome| outcome.node),
        outcomes[1].map(|outcome| outcome.node)
    );
    assert!(scene.undo().is_some() && scene == before);
    let lengths = [scene.undo_depth(), scene.redo_depth()];
    // Within a stroke what was done before in it stays.
    scene.begin_stroke();
    checked(&mut scene, grow, accept).expect("an edit");
    let within = scene.clone();
    for line in [grow, group, ball] {
        assert!(checked(&mut scene, line, refuse).is_err());
        assert!(scene == within);
    }
    checked(&mut scene, grow, accept).expect("an edit");
    scene.end_stroke();
    assert_eq!(
        [scene.undo_depth(), scene.redo_depth()],
        [lengths[0] + 1, 0]
    );
    assert!(scene.undo().is_some());
    assert!(scene == before);
    let modifiers = |scene: &Scene| {
        let first = scene.node(Scene::ROOT).children()[0];
        scene.node(first).desc().modifiers.len()
    };
    assert!(scene.redo().is_some() && modifiers(&scene) == 2);
}

/// A node that is a brush and a group at once is refused before any change, at any depth. No stroke stays open.
#[test]
fn a_brush_that_is_also_a_group_is_refused() {
    let ball = r#"{"shape":{"type":"sphere","radius":0.5}}"#;
    let both = r#"{"shape":{"type":"sphere","radius":0.5},"brushes":[{"brushes":[]}]}"#;
    let mut scene = Scene::new();
    let line = |entry: &str| format!(r#"{{"edit":"insert","entry":{entry}}}"#);
    scene.apply_log_line(&line(ball)).expect("an edit");
    let (before, lengths) = (scene.clone(), [scene.undo_depth(), scene.redo_depth()]);
    let deep = format!(r#"{{"brushes":[{ball},{{"brushes":[{both}]}}]}}"#);
    for entry in [both.to_owned(), format!(r#"{{"brushes":[{both}]}}"#), deep] {
        let refused = scene.apply_log_line(&line(&entry)).expect_err("both");
        assert!(refused.to_string().contains("this has both"), "{refused}");
        assert!(scene == before && [scene.undo_depth(), scene.redo_depth()] == lengths);
    }
    // Two steps are two.
    scene.apply_log_line(&line(ball)).expect("an edit");
    scene.apply_log_line(&line(ball)).expect("an edit");
    assert!(scene.undo().is_some());
    assert_eq!(scene.brush_count(), 2);
}

/// An index beyond the end is refused, and does not wrap around.
#[test]
fn an_absurd_index_is_refused() {
    let mut scene = Scene::new();
    let ball = r#"{"edit":"insert","entry":{"shape":{"type":"sphere","radius":0.5}}}"#;
    scene.apply_log_line(ball).expect("an edit");
    let before = scene.clone();
    for line in [
        format!(
            r#"{{"edit":"move","node":"brushes[0]","index":{}}}"#,
            usize::MAX
        ),
        format!(
            r#"{{"edit":"insert","index":{},"entry":{{"brushes":[]}}}}"#,
            usize::MAX
        ),
    ] {
        let error = scene
            .apply_log_line(&line)
            .expect_err("no such place")
            .to_string();
        assert!(error.contains("past the end"), "{error}");
        assert!(scene == before);
    }
}
