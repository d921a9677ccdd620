//! Tests what a user does, from presses and drags to the scene.
//!
//! *Length.* A test for each action of a user.

use crate::common::{Begin, Desk};
use argil::scene::{NodeKind, Scene, Shape};
use eframe::egui::{Key, Modifiers, Vec2};

fn desk() -> Desk {
    Desk::new(Begin::default())
}

/// Opens a scene that has only a selected sphere of radius 0.5 at the center.
fn with_a_ball() -> Desk {
    let mut desk = desk();
    desk.step();
    desk.choose("File", "New");
    desk.click("Add Sphere");
    desk
}

fn count(desk: &Desk) -> usize {
    desk.scene().brush_count()
}

fn names(desk: &Desk) -> Vec<String> {
    let scene = desk.scene();
    scene
        .iter()
        .filter(|&n| n != Scene::ROOT)
        .map(|n| desk.studio().document().name_of(n))
        .collect()
}

#[test]
fn a_shape_is_added_moved_and_taken_back() {
    let mut desk = desk();
    desk.step();
    desk.choose("File", "New");
    assert_eq!(count(&desk), 0);
    desk.click("Add Sphere");
    assert_eq!(count(&desk), 1);
    let before = desk.scene().to_json();
    desk.click("Move");
    let middle = desk.place_of("Viewport");
    desk.drag(middle, middle + Vec2::new(80.0, 20.0), Modifiers::NONE);
    let moved = desk.scene().to_json();
    assert_ne!(moved, before);
    let (names, done) = desk.studio().document().history();
    assert_eq!(
        (names, done),
        (&["Add shape".to_owned(), "Move".to_owned()][..], 2)
    );
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(desk.scene().to_json(), before);
    desk.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(desk.scene().to_json(), moved);
    desk.choose("Edit", "Undo");
    desk.choose("Edit", "Undo");
    assert_eq!(count(&desk), 0);
}

#[test]
fn handles_duplicate_rotate_and_scale() {
    let mut desk = with_a_ball();
    let middle = desk.place_of("Viewport");
    desk.click("Move");
    desk.drag(middle, middle + Vec2::new(90.0, 0.0), Modifiers::SHIFT);
    assert_eq!(count(&desk), 2);
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(count(&desk), 1);
    desk.click("Sphere");
    desk.click("Scale");
    desk.drag(middle, middle + Vec2::new(0.0, 60.0), Modifiers::NONE);
    desk.click("Rotate");
    // The outer ring turns about the line of sight.
    let right = middle + Vec2::new(96.0, 0.0);
    desk.drag(right, middle + Vec2::new(0.0, 96.0), Modifiers::NONE);
    let (names, _) = desk.studio().document().history();
    assert_eq!(names[1..], ["Scale", "Rotate"]);
}

/// A handle of one axis scales one axis. A shape that has no length along an axis has no handle there.
#[test]
fn handles_of_one_axis_scale_one_axis() {
    let mut desk = with_a_ball();
    desk.click("Scale");
    let middle = desk.place_of("Viewport");
    let radii = |desk: &Desk| {
        let scene = desk.scene();
        let node = scene.node(Scene::ROOT).children()[0];
        match scene.node(node).desc().kind {
            NodeKind::Shape(Shape::Ellipsoid { radii }) => Some(radii),
            _ => None,
        }
    };
    // Up is y: the handle stands above the middle.
    let end = middle + Vec2::new(0.0, -60.0);
    desk.drag(end, end + Vec2::new(0.0, -60.0), Modifiers::NONE);
    let [x, y, z] = radii(&desk).expect("an ellipsoid");
    assert!(x == z && y > 1.5 * x, "{x} {y} {z}");
    desk.press(Modifiers::COMMAND, Key::Z);
    assert!(radii(&desk).is_none());
}

/// Escape closes an open menu and does nothing else.
#[test]
fn escape_closes_the_open_popup() {
    let mut desk = with_a_ball();
    assert_eq!(desk.studio().document().selection.len(), 1);
    desk.click("File");
    assert!(desk.has("Quit") || desk.has("New"));
    desk.press(Modifiers::NONE, Key::Escape);
    assert_eq!(desk.studio().document().selection.len(), 1);
    assert!(!desk.has("New"));
    desk.press(Modifiers::NONE, Key::Escape);
    assert!(desk.studio().document().selection.is_empty());
}

/// A change that cannot be rendered is refused before it is recorded: the document, the history and the log do not
/// contain it.
#[test]
fn edits_that_cannot_be_drawn_are_refused() {
    let mut desk = with_a_ball();
    let before = (
        desk.scene().to_json(),
        count(&desk),
        desk.studio().document().history().0.len(),
    );
    let studio = desk.window.state_mut();
    let node = studio.document().scene().node(Scene::ROOT).children()[0];
    let mut entry = studio.document().scene().node(node).desc().clone();
    // Beside the middle of its cell, so that many copies are near a point.
    let by = [0.3; 3];
    entry
        .modifiers
        .push(argil::scene::Modifier::Translate { by });
    entry.modifiers.push(argil::scene::Modifier::Repeat {
        spacing: [0.001; 3],
        count: None,
    });
    let refused = studio.document_mut().replace("Repeat", node, entry);
    assert!(refused.is_err());
    let after = (
        desk.scene().to_json(),
        count(&desk),
        desk.studio().document().history().0.len(),
    );
    assert!(before == after);
}

#[test]
fn brushes_are_picked_hidden_locked_renamed_and_grouped() {
    let mut desk = with_a_ball();
    let middle = desk.place_of("Viewport");
    desk.press(Modifiers::NONE, Key::Escape);
    assert!(desk.studio().document().selection.is_empty());
    desk.click_at(middle, Modifiers::NONE);
    assert_eq!(desk.studio().document().selection.len(), 1);
    // What is locked cannot be picked.
    desk.click("Lock or unlock Sphere");
    desk.press(Modifiers::NONE, Key::Escape);
    desk.click_at(middle, Modifiers::NONE);
    assert!(desk.studio().document().selection.is_empty());
    desk.click("Lock or unlock Sphere");
    desk.click("Hide or show Sphere");
    desk.click_at(middle, Modifiers::NONE);
    assert!(desk.studio().document().selection.is_empty());
    desk.click("Hide or show Sphere");
    desk.click("Sphere");
    desk.press(Modifiers::NONE, Key::F2);
    desk.type_text("head");
    desk.press(Modifiers::NONE, Key::Enter);
    assert_eq!(names(&desk), ["head"]);
    desk.press(Modifiers::COMMAND, Key::D);
    desk.press(Modifiers::COMMAND, Key::A);
    desk.press(Modifiers::COMMAND, Key::G);
    assert_eq!(names(&desk), ["Group", "head", "head"]);
    desk.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::G);
    assert_eq!(names(&desk), ["head", "head"]);
    desk.press(Modifiers::NONE, Key::Delete);
    assert_eq!(count(&desk), 0);
}

#[test]
fn a_subtractive_brush_is_picked_where_it_has_carved() {
    let mut desk = Desk::new(Begin::default());
    desk.step();
    desk.choose("File", "New");
    desk.click("Add Box");
    desk.click("Add Sphere");
    // The ball, half as large again, in front of the box and taken away.
    let scene = desk.scene();
    let ball = scene.node(Scene::ROOT).children()[1];
    let mut entry = scene.node(ball).desc().clone();
    entry.operator.kind = argil::scene::OperatorKind::Subtract;
    entry.modifiers.push(argil::scene::Modifier::Translate {
        by: [0.1, 0.1, 0.25],
    });
    desk.window
        .state_mut()
        .document_mut()
        .replace("Carve", ball, entry)
        .expect("an entry");
    desk.press(Modifiers::NONE, Key::Escape);
    desk.press(Modifiers::NONE, Key::Home);
    let middle = desk.place_of("Viewport");
    desk.click_at(middle, Modifiers::NONE);
    assert_eq!(desk.studio().document().selection, [ball]);
}

#[test]
fn a_dragged_value_is_one_step_and_lists_are_reordered() {
    let mut desk = with_a_ball();
    let value = desk.place_of("Sphere radius");
    desk.drag(value, value + Vec2::new(40.0, 0.0), Modifiers::NONE);
    let radius = |desk: &Desk| {
        let node = desk.scene().node(Scene::ROOT).children()[0];
        match &desk.scene().node(node).desc().kind {
            NodeKind::Shape(Shape::Sphere { radius }) => *radius,
            _ => panic!("a ball"),
        }
    };
    assert!(radius(&desk) > 0.5, "{}", radius(&desk));
    let (names_of_steps, _) = desk.studio().document().history();
    assert_eq!(names_of_steps, ["Add shape", "Change sphere"]);
    desk.click("Add Torus");
    assert_eq!(names(&desk), ["Sphere", "Torus"]);
    let (from, to) = (desk.place_of("Torus"), desk.place_of("Sphere"));
    desk.drag(from, to - Vec2::new(0.0, 8.0), Modifiers::NONE);
    assert_eq!(names(&desk), ["Torus", "Sphere"]);
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(names(&desk), ["Sphere", "Torus"]);
}

#[test]
fn strokes_add_carve_smooth_and_are_one_step_each() {
    let mut desk = with_a_ball();
    desk.press(Modifiers::NONE, Key::Home);
    let middle = desk.place_of("Viewport");
    for (i, key) in [Key::Num1, Key::Num2].into_iter().enumerate() {
        desk.press(Modifiers::NONE, key);
        let at = middle + Vec2::new(0.0, 60.0 * i as f32);
        desk.drag(
            at - Vec2::new(60.0, 0.0),
            at + Vec2::new(60.0, 0.0),
            Modifiers::NONE,
        );
    }
    let (steps, done) = desk.studio().document().history();
    assert_eq!(steps, ["Add shape", "Add stroke", "Carve stroke"]);
    assert_eq!(done, 3);
    assert!(count(&desk) > 4, "{}", count(&desk));
    desk.press(Modifiers::NONE, Key::Num3);
    desk.drag(middle - Vec2::new(60.0, 0.0), middle, Modifiers::NONE);
    let (steps, _) = desk.studio().document().history();
    assert_eq!(steps.last().map(String::as_str), Some("Smooth stroke"));
    for _ in 0..3 {
        desk.press(Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(count(&desk), 1);
}

#[test]
fn commands_are_found_and_shortcuts_reassigned() {
    let mut desk = with_a_ball();
    desk.press(Modifiers::COMMAND, Key::K);
    desk.type_text("dupl");
    desk.press(Modifiers::NONE, Key::Enter);
    assert_eq!(count(&desk), 2);
    desk.press(Modifiers::NONE, Key::F1);
    // The sheet takes a few frames to find its size.
    desk.window.run_steps(20);
    desk.click("Shortcut of Undo");
    desk.press(Modifiers::ALT, Key::U);
    desk.click("Close");
    desk.press(Modifiers::ALT, Key::U);
    assert_eq!(count(&desk), 1);
    // The one before is no longer.
    desk.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(count(&desk), 2);
}

#[test]
fn scenes_are_saved_and_opened_and_nothing_is_lost_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("ball.json");
    let mut desk = with_a_ball();
    desk.choose("File", "New");
    // There is something to lose.
    desk.click("Cancel");
    assert_eq!(count(&desk), 1);
    desk.choose("File", "New");
    desk.answers.borrow_mut().push(file.clone());
    desk.click("Save");
    assert_eq!(count(&desk), 0);
    assert_eq!(Scene::open(&file).expect("a scene").brush_count(), 1);
    desk.answers.borrow_mut().push(file.clone());
    desk.press(Modifiers::COMMAND, Key::O);
    assert_eq!(count(&desk), 1);
    assert!(!desk.studio().document().is_changed());
    // What cannot be read leaves what is there.
    std::fs::write(&file, "{").expect("a file");
    desk.answers.borrow_mut().push(file.clone());
    desk.press(Modifiers::COMMAND, Key::O);
    assert_eq!(count(&desk), 1);
    assert!(
        desk.studio()
            .note()
            .is_some_and(|n| n.contains("ball.json"))
    );
}

#[test]
fn meshes_are_exported_and_imported_in_the_background() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("ball.obj");
    let mut desk = with_a_ball();
    desk.answers.borrow_mut().push(mesh.clone());
    desk.press(Modifiers::COMMAND, Key::E);
    desk.until_told("Exported");
    assert!(mesh.exists());
    desk.answers.borrow_mut().push(mesh);
    desk.press(Modifiers::COMMAND, Key::I);
    desk.until_told("Imported");
    assert_eq!(names(&desk), ["Sphere", "ball"]);
    // What is done to a mesh that is no solid is told.
    let open = folder.path().join("open.obj");
    let corners =
        "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
    let faces = "f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    std::fs::write(&open, format!("{corners}{faces}")).expect("a file");
    desk.answers.borrow_mut().push(open);
    desk.press(Modifiers::COMMAND, Key::I);
    desk.until_told("closed 1 hole");
    let picture = folder.path().join("ball.png");
    desk.answers.borrow_mut().push(picture.clone());
    desk.press(Modifiers::COMMAND, Key::P);
    desk.until_told("ball.png");
    assert!(picture.exists());
}

#[test]
fn volumes_of_other_programs_are_exported_and_imported() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut desk = with_a_ball();
    for name in ["copy.vdb", "copy.nvdb"] {
        let file = folder.path().join(name);
        desk.answers.borrow_mut().push(file.clone());
        desk.choose("File", "Export volume…");
        desk.until_told("voxels");
        assert!(file.exists());
        desk.answers.borrow_mut().push(file);
        desk.press(Modifiers::COMMAND, Key::I);
        desk.until_told("Imported");
    }
    assert_eq!(names(&desk), ["Sphere", "copy", "copy"]);
}

#[test]
fn unsaved_work_is_restored_after_a_crash() {
    let folder = tempfile::tempdir().expect("a folder");
    let begin = || Begin {
        recovery: Some(folder.path().into()),
        ..Begin::default()
    };
    let mut desk = Desk::new(begin());
    desk.step();
    desk.choose("File", "New");
    desk.click("Add Sphere");
    desk.click("Add Torus");
    let before = desk.scene().to_json();
    // Its process is gone: a journal of another is left.
    let left = std::fs::read_dir(folder.path()).expect("a folder");
    let journal = left
        .flatten()
        .map(|file| file.path())
        .find(|path| path.extension().is_some_and(|e| e == "journal"))
        .expect("a journal");
    let other = folder.path().join("4294967294-1.journal");
    std::fs::copy(journal, &other).expect("a copy");
    drop(desk);
    let mut desk = Desk::new(begin());
    desk.step();
    desk.click("Restore");
    assert_eq!(desk.scene().to_json(), before);
    assert!(desk.studio().document().is_changed());
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(count(&desk), 1);
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(count(&desk), 0);
}

#[test]
fn keys_wait_until_the_pointer_lets_go() {
    let mut desk = with_a_ball();
    let middle = desk.place_of("Viewport");
    let before = desk.scene().to_json();
    desk.click("Sculpt");
    desk.hold(middle);
    desk.move_to(middle + Vec2::new(20.0, 0.0));
    // Undo and other tools would pull the stroke from under the hand.
    desk.press(Modifiers::COMMAND, Key::Z);
    desk.press(Modifiers::NONE, Key::W);
    desk.press(Modifiers::NONE, Key::Delete);
    desk.move_to(middle + Vec2::new(40.0, 10.0));
    desk.let_go(middle + Vec2::new(40.0, 10.0));
    let (names, done) = desk.studio().document().history();
    assert_eq!((names.len(), done), (2, 2), "{names:?}");
    let children = desk.scene().node(Scene::ROOT).children().len();
    assert_eq!(children, 2, "the ball, and the stroke's group");
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(desk.scene().to_json(), before);
}

#[test]
fn unsaved_work_stays_until_it_is_discarded() {
    let mut desk = with_a_ball();
    desk.press(Modifiers::COMMAND, Key::O);
    desk.window.run_steps(20);
    // The dialog is answered by nothing: it was given up.
    desk.click("Do not save");
    assert_eq!(count(&desk), 1);
    assert!(desk.studio().document().is_changed());
    // So is what cannot be opened.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cut.json");
    std::fs::write(&path, "{\"argil\": 1, ").expect("a file");
    desk.answers.borrow_mut().push(path);
    desk.press(Modifiers::COMMAND, Key::O);
    desk.window.run_steps(20);
    desk.click("Do not save");
    assert_eq!(count(&desk), 1);
    assert!(desk.studio().document().is_changed());
}

#[test]
fn a_node_that_is_gone_is_not_edited() {
    let mut desk = with_a_ball();
    desk.click("Add Torus");
    desk.press(Modifiers::COMMAND, Key::G);
    let group = desk.scene().node(Scene::ROOT).children()[1];
    let node = desk.scene().node(group).children()[0];
    let entry = desk.scene().node(node).desc().clone();
    let document = desk.window.state_mut().document_mut();
    let removal = argil::scene::Edit::Remove { node: group };
    document.edit("Delete", removal).expect("an edit");
    // Where it was in its group, there is the ball in the scene.
    let before = document.scene().to_json();
    assert!(document.replace("Move", node, entry).is_err());
    assert_eq!(document.scene().to_json(), before);
}

#[test]
fn a_crash_after_a_save_restores_later_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let sessions = folder.path().join("sessions");
    let begin = || Begin {
        recovery: Some(sessions.clone()),
        ..Begin::default()
    };
    // What was saved is left as by another process, which is gone.
    let crash = || {
        let files = std::fs::read_dir(&sessions).expect("a folder").flatten();
        let journal = files
            .map(|file| file.path())
            .find(|path| {
                let stem = path.file_stem().unwrap_or_default().to_string_lossy();
                path.with_extension("saved").exists() && !stem.starts_with("4294967294")
            })
            .expect("a journal");
        let other = sessions.join("4294967294-1");
        for ending in ["journal", "origin", "saved"] {
            let copied =
                std::fs::copy(journal.with_extension(ending), other.with_extension(ending));
            copied.expect("a copy");
        }
    };
    let mut desk = Desk::new(begin());
    desk.step();
    desk.choose("File", "New");
    desk.click("Add Sphere");
    desk.click("Add Torus");
    let saved = folder.path().join("two.json");
    desk.answers.borrow_mut().push(saved.clone());
    desk.press(Modifiers::COMMAND, Key::S);
    assert!(!desk.studio().document().is_changed());
    crash();
    let left = argil::scene::Journal::recover(sessions.join("4294967294-1.journal"));
    assert_eq!(left.expect("a journal").edits, 2);
    let mut another = Desk::new(begin());
    another.step();
    assert!(!another.asks_to_bring_back(), "all of it is saved");
    drop(another);
    // Back beyond what was saved.
    desk.press(Modifiers::COMMAND, Key::Z);
    desk.press(Modifiers::COMMAND, Key::Z);
    desk.click("Add Link");
    let after = desk.scene().to_json();
    crash();
    drop(desk);
    let mut desk = Desk::new(begin());
    desk.step();
    desk.click("Restore");
    assert_eq!(desk.scene().to_json(), after);
    assert_eq!(desk.studio().document().path(), Some(saved.as_path()));
}
