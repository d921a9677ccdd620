//! Scenes, journals, and the images that scenes name.

use argil_scene::{Edit, Journal, Scene};
use std::path::Path;
use std::sync::LazyLock;

pub(crate) fn scene(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = Scene::from_json(text, "a.json");
    }
}

/// Returns scenes that have many parts.
pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let all = [
        r#"{"argil":1,"name":"a","materials":{"r":{"base_color":[1,0.5,0],"texture":"checker"}},"brushes":[{"shape":{"type":"box","half_size":[2,1,0.5]},"material":"r"},{"shape":{"type":"sphere","radius":0.7},"operator":{"type":"subtract","blend":0.1},"modifiers":[{"type":"translate","by":[0,1.5,0]},{"type":"round","radius":0.1}]}]}"#,
        r#"{"argil":1,"brushes":[{"group":[{"shape":{"type":"torus","radius":1,"thickness":0.2}},{"shape":{"type":"mesh","path":"a.obj"}}]}],"view":{"camera":[30,20,3]}}"#,
    ];
    all.iter().map(|text| text.as_bytes().to_vec()).collect()
}

/// The folder of the file that a journal's bytes are read from.
static FOLDER: LazyLock<tempfile::TempDir> =
    LazyLock::new(|| tempfile::tempdir().expect("a folder"));

pub(crate) fn journal(bytes: &[u8]) {
    let place = FOLDER
        .path()
        .join(format!("{:?}.journal", std::thread::current().id()));
    if std::fs::write(&place, bytes).is_ok() {
        let _ = Journal::recover(&place);
    }
}

/// Returns a journal of two edits.
pub(crate) fn journals() -> Vec<Vec<u8>> {
    let place = FOLDER.path().join("seed.journal");
    let text = r#"{"argil":1,"brushes":[{"shape":{"type":"sphere","radius":0.5}}]}"#;
    let mut scene = Scene::from_json(text, "a.json").expect("a scene");
    let mut journal = Journal::create(&place, &scene).expect("a journal");
    let brush = scene.iter().last().expect("a brush");
    for edit in [
        Edit::SetVisible {
            node: brush,
            visible: false,
        },
        Edit::Remove { node: brush },
    ] {
        journal.apply(&mut scene, edit).expect("an edit");
    }
    vec![std::fs::read(&place).expect("a journal")]
}

fn with_image(name: &str, text: &str, bytes: &[u8]) {
    let Ok(mut scene) = Scene::from_json(text, Path::new("a.json")) else {
        panic!("the scene is valid");
    };
    let _ = argil::load_meshes_from_bytes(&mut scene, &[(name.to_owned(), bytes.to_vec())]);
}

/// Reads an image as a texture or an environment.
pub(crate) fn image(bytes: &[u8]) {
    with_image(
        "a.png",
        r#"{"argil":1,"brushes":[],"view":{"environment":{"type":"image","path":"a.png"}}}"#,
        bytes,
    );
}

/// Reads an image as heights.
pub(crate) fn heightmap(bytes: &[u8]) {
    with_image(
        "a.png",
        r#"{"argil":1,"brushes":[{"shape":{"type":"heightmap","path":"a.png","half_size":[1,1],"height":1}}]}"#,
        bytes,
    );
}
