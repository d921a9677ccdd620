//! Pictures of shapes: each example of `Shape`, rendered by the command and embedded in the documentation.

use anyhow::{Context, ensure};
use argil_scene::{Scene, Shape};
use base64::prelude::{BASE64_STANDARD, Engine};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use xtask::root;

/// Renders every shape and returns the Markdown files that embed the pictures, as paths and texts.
///
/// The pictures are data URIs, because rustdoc shows no files of a package.
pub(crate) fn pictures() -> anyhow::Result<Vec<(PathBuf, String)>> {
    let folder = tempfile::tempdir().context("a temporary folder")?;
    let mut scenes = vec![
        ("Heightmap".to_owned(), root().join("scenes/hills.json")),
        ("Mesh".to_owned(), root().join("scenes/suzanne.json")),
    ];
    for shape in Shape::examples() {
        let name = variant(&shape);
        let mut scene = Scene::new();
        if let Shape::Plane { .. } = shape {
            // A plane fills the picture unless it is cut.
            scene.push(shape & Shape::cuboid([0.5, 0.04, 0.5]))?;
        } else {
            scene.push(shape)?;
        }
        let path = folder.path().join(format!("{name}.json"));
        scene.save(&path)?;
        scenes.push((name, path));
    }
    scenes
        .into_iter()
        .map(|(name, scene)| {
            let picture = folder.path().join(format!("{name}.png"));
            render(&scene, &picture)?;
            let bytes = std::fs::read(&picture).context("a picture")?;
            let data = BASE64_STANDARD.encode(bytes);
            let path = format!("crates/argil-scene/src/pictures/{name}.md");
            let text = format!("\n![{name}](data:image/png;base64,{data})\n");
            Ok((root().join(path), text))
        })
        .collect()
}

/// Returns the name of a shape's variant.
fn variant(shape: &Shape) -> String {
    let debug = format!("{shape:?}");
    debug
        .split([' ', '{'])
        .next()
        .unwrap_or_default()
        .to_owned()
}

fn render(scene: &Path, picture: &Path) -> anyhow::Result<()> {
    let status = Command::new("cargo")
        .current_dir(root())
        .args([
            "run",
            "--release",
            "--quiet",
            "-p",
            "argil-cli",
            "--",
            "render",
        ])
        .arg(scene)
        .arg("-o")
        .arg(picture)
        .args([
            "--device",
            "cpu",
            "--size",
            "96x96",
            "--samples",
            "4",
            "--no-ground",
        ])
        .stdout(Stdio::null())
        .status()
        .context("cargo")?;
    ensure!(
        status.success(),
        "{}: it cannot be rendered",
        scene.display()
    );
    Ok(())
}
