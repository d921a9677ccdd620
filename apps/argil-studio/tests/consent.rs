//! Scenes read meshes from outside of their folder only if the user chose the files.

use crate::common::{Begin, Desk};
use eframe::egui::{Key, Modifiers};
use std::path::Path;
use std::time::{Duration, Instant};

/// Writes a square pyramid.
fn pyramid(path: &Path) {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\n\
        f 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    std::fs::write(path, text).expect("a file");
}

fn missing(desk: &Desk) -> usize {
    desk.studio().document().missing_meshes().len()
}

fn open(desk: &mut Desk, scene: &Path) {
    desk.answers.borrow_mut().push(scene.into());
    desk.press(Modifiers::COMMAND, Key::O);
}

fn until_missing(desk: &mut Desk, count: usize) {
    let start = Instant::now();
    while missing(desk) != count {
        desk.step();
        let waited = start.elapsed();
        let note = desk.studio().note();
        assert!(
            waited < Duration::from_secs(60),
            "{} missing: {note:?}",
            missing(desk)
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn meshes_that_were_refused_stay_refused_until_they_are_chosen() {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).expect("a folder");
    for name in ["one.obj", "two.obj"] {
        pyramid(&folder.path().join(name));
    }
    let scene = inner.join("scene.json");
    let text = r#"{"argil": 1, "brushes": [
        {"name": "first", "shape": {"type": "mesh", "path": "../one.obj"}},
        {"name": "second", "shape": {"type": "mesh", "path": "../two.obj"}}]}"#;
    std::fs::write(&scene, text).expect("a file");
    let [sessions, others] = ["sessions", "others"].map(|name| folder.path().join(name));
    let begin = |sessions: &Path| Begin {
        recovery: Some(sessions.into()),
        ..Begin::default()
    };
    let mut desk = Desk::new(begin(&sessions));
    desk.step();
    // The second time, it is among the recent ones. Saving changes nothing either.
    for _ in 0..2 {
        open(&mut desk, &scene);
        desk.until_told("outside");
        assert_eq!(missing(&desk), 2);
        desk.press(Modifiers::COMMAND, Key::S);
    }
    desk.click("Add Sphere");
    desk.settle();
    desk.crash(&sessions);
    let mut desk = Desk::new(begin(&sessions));
    desk.step();
    desk.click("Restore");
    desk.until_told("outside");
    assert_eq!(missing(&desk), 2);
    drop(desk);
    // One is chosen, and the other stays refused, whenever the scene is opened.
    let mut desk = Desk::new(Begin {
        scene: Some(scene.clone()),
        ..begin(&others)
    });
    desk.until_told("outside");
    desk.settle();
    desk.click("first");
    desk.step();
    assert!(desk.has("Choose…"));
    desk.answers
        .borrow_mut()
        .push(folder.path().join("one.obj"));
    desk.click("Choose…");
    until_missing(&mut desk, 1);
    desk.answers.borrow_mut().push(scene.clone());
    desk.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    open(&mut desk, &scene);
    desk.until_told("two.obj");
    until_missing(&mut desk, 1);
    // So it is after another crash.
    desk.click("Add Sphere");
    desk.settle();
    desk.crash(&others);
    let mut desk = Desk::new(begin(&others));
    desk.step();
    desk.click("Restore");
    until_missing(&mut desk, 1);
}
