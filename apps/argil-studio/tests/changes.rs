//! Tests changes of brushes, meshes and materials, and work in the background.
//!
//! *Length.* A test for each kind of change.

use crate::common::{Begin, Desk};
use argil::scene::{Modifier, NodeDesc, NodeKind, Scene, Shape};
use eframe::egui::{Key, Modifiers, Pos2, Vec2};
use std::path::Path;
use std::time::{Duration, Instant};

fn desk() -> Desk {
    let mut desk = Desk::new(Begin::default());
    desk.step();
    desk.choose("File", "New");
    desk
}

fn entries(desk: &Desk) -> Vec<NodeDesc> {
    let scene = desk.scene();
    let nodes = scene.node(Scene::ROOT).children().iter();
    nodes.map(|&n| scene.node(n).desc().clone()).collect()
}

fn steps(desk: &Desk) -> Vec<String> {
    desk.studio().document().history().0.to_vec()
}

fn until(desk: &mut Desk, what: &str, is_so: impl Fn(&Desk) -> bool) {
    let start = Instant::now();
    while !is_so(desk) {
        desk.step();
        assert!(start.elapsed() < Duration::from_secs(120), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn middle(desk: &Desk) -> Pos2 {
    desk.place_of("Viewport")
}

#[test]
fn escape_takes_a_drag_and_a_stroke_back() {
    let mut desk = desk();
    desk.click("Add Sphere");
    let before = desk.scene().to_json();
    let at = middle(&desk);
    for tool in ["Move", "Sculpt"] {
        desk.click(tool);
        desk.hold(at);
        desk.move_to(at + Vec2::new(30.0, 0.0));
        desk.move_to(at + Vec2::new(60.0, 0.0));
        assert_ne!(desk.scene().to_json(), before, "{tool}");
        desk.press(Modifiers::NONE, Key::Escape);
        assert_eq!(desk.scene().to_json(), before, "{tool}");
        // What is held does nothing any more.
        desk.move_to(at + Vec2::new(40.0, 30.0));
        desk.let_go(at + Vec2::new(40.0, 30.0));
        assert_eq!(desk.scene().to_json(), before, "{tool}");
        assert_eq!(desk.studio().document().selection.len(), 1);
        assert_eq!(desk.studio().document().history().1, 1);
    }
    // Copies go, and what was selected is again.
    desk.click("Move");
    let selection = desk.studio().document().selection.clone();
    desk.hold_with(at, Modifiers::SHIFT);
    desk.move_to(at + Vec2::new(40.0, 0.0));
    assert_ne!(desk.studio().document().selection, selection);
    desk.press(Modifiers::NONE, Key::Escape);
    desk.let_go(at);
    assert_eq!(desk.scene().to_json(), before);
    assert_eq!(desk.studio().document().selection, selection);
    // The next does as ever.
    desk.drag(at, at + Vec2::new(40.0, 0.0), Modifiers::NONE);
    assert_ne!(desk.scene().to_json(), before);
}

#[test]
fn the_selection_is_nudged_along_axes() {
    let mut desk = desk();
    desk.click("Add Sphere");
    desk.choose("View", "Front or back");
    let place = |desk: &Desk| match entries(desk)[0].modifiers.last() {
        Some(&Modifier::Translate { by }) => by,
        _ => [0.0; 3],
    };
    let from = place(&desk);
    let shift = Modifiers::SHIFT;
    desk.press(shift, Key::ArrowRight);
    desk.press(shift, Key::ArrowUp);
    desk.press(shift, Key::ArrowUp);
    desk.press(shift, Key::PageUp);
    let to = place(&desk);
    for (axis, by) in [0.1, 0.2, -0.1].into_iter().enumerate() {
        let moved = to[axis] - from[axis];
        assert!((moved - by).abs() < 1e-5, "{axis}: {moved}");
    }
    assert_eq!(steps(&desk).len(), 5);
}

#[test]
fn a_change_applies_to_all_selected_nodes() {
    let mut desk = desk();
    desk.click("Add Sphere");
    desk.click("Add Sphere");
    desk.click("Add Box");
    desk.click("Lock or unlock Box");
    desk.press(Modifiers::COMMAND, Key::A);
    // The one that is inspected is the last; it is to be a ball.
    desk.window.state_mut().document_mut().selection.reverse();
    desk.step();
    let value = desk.place_of("Sphere radius");
    desk.drag(value, value + Vec2::new(40.0, 0.0), Modifiers::NONE);
    let value = desk.place_of("Blend radius");
    desk.drag(value, value + Vec2::new(40.0, 0.0), Modifiers::NONE);
    let all = entries(&desk);
    assert!(all[0].operator.blend > 0.0);
    assert_eq!(all[0], all[1]);
    assert!(matches!(all[0].kind, NodeKind::Shape(Shape::Sphere { radius }) if radius > 0.5));
    assert_eq!(all[2].operator.blend, 0.0, "it is locked");
    assert_eq!(
        steps(&desk)[3..],
        ["Lock", "Change sphere", "Change operator"]
    );
    desk.press(Modifiers::COMMAND, Key::Z);
    assert!(entries(&desk).iter().all(|e| e.operator.blend == 0.0));
}

#[test]
fn locked_nodes_do_not_change() {
    let mut desk = desk();
    desk.click("Add Sphere");
    desk.press(Modifiers::NONE, Key::L);
    let before = desk.scene().to_json();
    for (modifiers, key) in [
        (Modifiers::NONE, Key::Delete),
        (Modifiers::COMMAND, Key::G),
        (Modifiers::SHIFT, Key::ArrowLeft),
    ] {
        desk.press(modifiers, key);
        assert_eq!(desk.scene().to_json(), before, "{key:?}");
        assert_eq!(desk.studio().note(), Some("the selection is locked"));
    }
    let value = desk.place_of("Sphere radius");
    desk.drag(value, value + Vec2::new(40.0, 0.0), Modifiers::NONE);
    assert_eq!(desk.scene().to_json(), before);
    // A copy is not, and the lock itself is a step.
    desk.press(Modifiers::COMMAND, Key::D);
    assert_eq!(
        entries(&desk).iter().map(|e| e.locked).collect::<Vec<_>>(),
        [true, false]
    );
    desk.press(Modifiers::COMMAND, Key::Z);
    desk.press(Modifiers::COMMAND, Key::Z);
    assert!(!entries(&desk)[0].locked);
    assert_eq!(steps(&desk), ["Add shape", "Lock", "Duplicate"]);
}

#[test]
fn materials_are_named_given_and_taken_away() {
    let mut desk = desk();
    desk.click("Add Sphere");
    desk.click("New material");
    desk.click("material 1");
    desk.window.run_steps(20);
    desk.click("Assign to selection");
    assert_eq!(entries(&desk)[0].material.as_deref(), Some("material 1"));
    desk.click("Name");
    desk.press(Modifiers::COMMAND, Key::A);
    desk.type_text("clay");
    desk.press(Modifiers::NONE, Key::Enter);
    assert_eq!(entries(&desk)[0].material.as_deref(), Some("clay"));
    let names: Vec<&String> = desk.scene().materials().keys().collect();
    assert_eq!(names, ["clay"]);
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(entries(&desk)[0].material.as_deref(), Some("material 1"));
    desk.window.run_steps(20);
    desk.click("Remove");
    assert_eq!(entries(&desk)[0].material, None);
    assert!(desk.scene().materials().is_empty());
}

#[test]
fn keyframes_are_added_and_looked_at() {
    let mut desk = desk();
    desk.click("Add Sphere");
    desk.click("Add keyframe");
    desk.click("Add keyframe");
    let keyframes = entries(&desk).remove(0).keyframes;
    assert_eq!(
        keyframes.iter().map(|k| k.time).collect::<Vec<_>>(),
        [0.0, 1.0]
    );
    let value = desk.place_of("Keyframe translate x");
    desk.drag(value, value + Vec2::new(60.0, 0.0), Modifiers::NONE);
    let keyframes = entries(&desk).remove(0).keyframes;
    let far = keyframes[0].translate.expect("a place")[0];
    assert!(far > 0.05, "{far}");
    desk.settle();
    let (version, ..) = desk.studio().shown().expect("a picture");
    let time = desk.place_of("Time");
    desk.drag(time, time + Vec2::new(30.0, 0.0), Modifiers::NONE);
    assert!(desk.scene().time() > 0.0);
    desk.settle();
    assert!(desk.studio().shown().expect("a picture").0 > version);
    desk.click("Remove keyframe 2");
    assert_eq!(entries(&desk)[0].keyframes.len(), 1);
}

/// Returns a square pyramid.
fn pyramid(path: &Path) {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\n\
        f 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    std::fs::write(path, text).expect("a file");
}

fn mesh_of(desk: &Desk) -> (String, u32) {
    match &entries(desk)[0].kind {
        NodeKind::Shape(Shape::Mesh {
            path, resolution, ..
        }) => (path.clone(), *resolution),
        other => panic!("a mesh: {other:?}"),
    }
}

#[test]
fn a_scene_whose_mesh_is_gone_opens_and_is_mended() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("scene.json");
    let text = r#"{"argil": 1, "brushes": [
        {"name": "thing", "shape": {"type": "mesh", "path": "gone.obj"}},
        {"shape": {"type": "sphere", "radius": 0.5}}]}"#;
    std::fs::write(&scene, text).expect("a file");
    let mut desk = desk();
    // They are drawn sooner than levels of detail.
    desk.click("Bricks");
    desk.answers.borrow_mut().push(scene.clone());
    desk.press(Modifiers::COMMAND, Key::O);
    desk.until_told("gone.obj");
    assert_eq!(desk.scene().brush_count(), 2);
    assert_eq!(desk.studio().document().missing_meshes().len(), 1);
    // The ball is drawn and picked.
    desk.settle();
    desk.press(Modifiers::NONE, Key::Home);
    let at = middle(&desk);
    desk.click_at(at, Modifiers::NONE);
    assert_eq!(desk.studio().document().selection.len(), 1);
    // What would leave the mesh out is not done.
    desk.press(Modifiers::COMMAND, Key::E);
    desk.until_told("is missing");
    let mesh = folder.path().join("there.obj");
    pyramid(&mesh);
    desk.click("thing");
    desk.answers.borrow_mut().push(mesh);
    desk.click("Choose…");
    until(&mut desk, "the mesh", |desk| mesh_of(desk).0 == "there.obj");
    let exported = folder.path().join("all.glb");
    desk.answers.borrow_mut().push(exported.clone());
    desk.press(Modifiers::COMMAND, Key::E);
    desk.until_told("Exported");
    assert!(exported.exists());
    // A finer one, and back.
    desk.click("Mesh resolution");
    desk.window.run_steps(20);
    desk.click("32 samples");
    until(&mut desk, "the mesh", |desk| mesh_of(desk).1 == 32);
    desk.settle();
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(mesh_of(&desk).1, 128);
    desk.settle();
}

#[test]
fn a_scene_saved_elsewhere_names_its_meshes_from_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let (here, there) = (folder.path().join("here"), folder.path().join("there"));
    for folder in [&here, &there] {
        std::fs::create_dir(folder).expect("a folder");
    }
    pyramid(&here.join("own.obj"));
    let sessions = folder.path().join("sessions");
    let begin = || Begin {
        recovery: Some(sessions.clone()),
        ..Begin::default()
    };
    let mut desk = Desk::new(begin());
    desk.step();
    desk.choose("File", "New");
    desk.answers.borrow_mut().push(here.join("scene.json"));
    desk.press(Modifiers::COMMAND, Key::S);
    desk.answers.borrow_mut().push(here.join("own.obj"));
    desk.press(Modifiers::COMMAND, Key::I);
    desk.until_told("Imported");
    assert_eq!(mesh_of(&desk).0, "own.obj");
    desk.answers.borrow_mut().push(there.join("scene.json"));
    desk.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    assert!(!desk.studio().document().is_changed());
    let named = here.join("own.obj").to_string_lossy().replace('\\', "/");
    assert_eq!(mesh_of(&desk).0, named);
    // What is done after finds the mesh, and what is undone too.
    desk.press(Modifiers::SHIFT, Key::ArrowRight);
    desk.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(mesh_of(&desk).0, named);
    desk.press(Modifiers::SHIFT, Key::ArrowRight);
    desk.settle();
    assert_eq!(desk.fault(), None);
    assert!(desk.studio().document().missing_meshes().is_empty());
    // The journal has gone on.
    let after = desk.scene().to_json();
    desk.crash(&sessions);
    let mut again = Desk::new(begin());
    again.step();
    again.click("Restore");
    assert_eq!(again.scene().to_json(), after);
    until(&mut again, "the mesh", |desk| {
        desk.studio().document().missing_meshes().is_empty()
    });
    // It is nobody else's now.
    let mut third = Desk::new(begin());
    third.step();
    assert!(!third.asks_to_bring_back());
    drop(again);
    let mut other = Desk::new(Begin {
        scene: Some(there.join("scene.json")),
        outside: true,
        ..Begin::default()
    });
    until(&mut other, "the mesh", |desk| {
        desk.studio().document().missing_meshes().is_empty()
    });
}

#[test]
fn names_that_no_file_can_have_are_refused_before_the_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut desk = desk();
    desk.click("Add Sphere");
    desk.answers
        .borrow_mut()
        .push(folder.path().join("ball.fbx"));
    desk.press(Modifiers::COMMAND, Key::E);
    let told = desk.studio().note().map(str::to_owned).unwrap_or_default();
    assert!(told.contains("ball.fbx") && told.contains(".glb"), "{told}");
}

#[test]
fn closing_waits_for_jobs_and_canceled_jobs_leave_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut desk = desk();
    desk.answers.borrow_mut().push(folder.path().into());
    desk.choose("File", "Export turntable…");
    desk.press(Modifiers::COMMAND, Key::Q);
    desk.window.run_steps(20);
    desk.click("Do not close");
    let count = || std::fs::read_dir(folder.path()).expect("a folder").count();
    until(&mut desk, "a picture", |_| count() > 0);
    desk.click("Cancel");
    // The word on it is there for a while only, which a busy machine can take to look.
    until(&mut desk, "an empty folder", |_| count() == 0);
    let note = desk.studio().note();
    assert!(note.is_none_or(|note| note == "Canceled"), "{note:?}");
}

#[test]
fn edits_without_effect_keep_the_redo_steps() {
    let mut desk = desk();
    for shape in ["Add Sphere", "Add Box", "Add Torus"] {
        desk.click(shape);
    }
    let all = desk.scene().to_json();
    desk.press(Modifiers::COMMAND, Key::Z);
    desk.press(Modifiers::COMMAND, Key::Z);
    desk.click("Sphere");
    let document = desk.window.state_mut().document_mut();
    document.begin_stroke("Nothing");
    document.end_stroke();
    desk.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::G);
    assert_eq!(desk.studio().document().selection.len(), 1);
    assert_eq!(steps(&desk).len(), 3);
    desk.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    desk.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(desk.scene().to_json(), all);
}

#[test]
fn canceled_strokes_keep_the_selection() {
    let mut desk = desk();
    desk.click("Add Sphere");
    desk.press(Modifiers::NONE, Key::F2);
    desk.type_text("head");
    desk.press(Modifiers::NONE, Key::Escape);
    assert_eq!(desk.studio().document().selection.len(), 1);
    assert_eq!(entries(&desk)[0].name, "");
    desk.press(Modifiers::NONE, Key::Escape);
    assert!(desk.studio().document().selection.is_empty());
}

/// Returns a wavy sheet of many triangles, with a bottom.
fn landscape(path: &Path) {
    let (n, mut text) = (120, String::new());
    for i in 0..=n {
        for k in 0..=n {
            let y = (0.3 * i as f32).sin() * (0.2 * k as f32).cos();
            text += &format!("v {} {} {}\n", 0.1 * i as f32, y, 0.1 * k as f32);
        }
    }
    for i in 0..n {
        for k in 0..n {
            let at = i * (n + 1) + k + 1;
            text += &format!("f {} {} {} {}\n", at, at + 1, at + n + 2, at + n + 1);
        }
    }
    std::fs::write(path, text).expect("a file");
}

#[test]
fn an_import_while_closing_asks_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("hills.obj");
    landscape(&mesh);
    let mut desk = desk();
    desk.answers.borrow_mut().push(mesh);
    desk.press(Modifiers::COMMAND, Key::I);
    desk.press(Modifiers::COMMAND, Key::Q);
    until(&mut desk, "the question", |desk| desk.has("Do not save"));
    assert_eq!(entries(&desk).len(), 1);
}

#[test]
fn meshes_that_are_pasted_are_read_where_that_is_allowed() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("own.obj");
    pyramid(&mesh);
    let named = mesh.to_string_lossy().replace('\\', "/");
    let text = serde_json::json!([{"shape": {"type": "mesh", "path": named}}]).to_string();
    let mut desk = desk();
    let paste = |desk: &mut Desk| {
        let event = eframe::egui::Event::Paste(text.clone());
        desk.window.event(event);
        desk.step();
    };
    paste(&mut desk);
    desk.until_told("allow external meshes");
    desk.settle();
    assert_eq!(desk.fault(), None);
    assert_eq!(desk.studio().document().missing_meshes().len(), 1);
    // What the person has chosen is read again.
    desk.answers.borrow_mut().push(mesh);
    desk.press(Modifiers::COMMAND, Key::I);
    desk.until_told("Imported");
    desk.choose("File", "New");
    desk.window.run_steps(20);
    desk.click("Do not save");
    paste(&mut desk);
    until(&mut desk, "the mesh", |desk| {
        desk.studio().document().missing_meshes().is_empty() && entries(desk).len() == 1
    });
    desk.settle();
    assert_eq!(desk.fault(), None);
}
