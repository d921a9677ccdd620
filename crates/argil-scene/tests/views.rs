//! Tests edits of views.

use argil_scene::{Edit, Scene, Shape, View};

/// A view is an edit like others: checked, undone and redone. Only other bounds concern the solid.
#[test]
fn views_are_edits() {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(1.0)).unwrap();
    let before = scene.view.clone();
    let wrong = View {
        exposure: 99.0,
        ..before.clone()
    };
    let edit = |view| Edit::SetView {
        view: Box::new(view),
    };
    assert!(scene.apply(edit(wrong)).is_err());
    assert_eq!(scene.view, before);
    let brighter = View {
        exposure: 1.5,
        lights: Some(Vec::new()),
        ..before.clone()
    };
    let seen = scene.change_count();
    let done = scene.apply(edit(brighter.clone())).unwrap();
    assert!(done.dirty_box.is_empty() && scene.change_count() == seen);
    assert_eq!(scene.view, brighter);
    scene.undo().unwrap();
    assert_eq!(scene.view, before);
    scene.redo().unwrap();
    assert_eq!(scene.view, brighter);
    let bounded = View {
        bounds: Some([[-1.0; 3], [1.0; 3]]),
        ..before
    };
    scene.apply(edit(bounded)).unwrap();
    assert_eq!(scene.change_count(), seen + 1);
}
