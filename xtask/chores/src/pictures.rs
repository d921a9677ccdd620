//! Pictures in the documentation: each example of `Shape`, and one for each crate page, rendered by the command.

use anyhow::{Context, ensure};
use argil_scene::{Scene, Shape};
use base64::prelude::{BASE64_STANDARD, Engine};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use xtask::root;

/// A picture at the end of a crate page: the crate, the scene, what `argil render` gets, and the caption.
struct CratePicture {
    name: &'static str,
    scene: &'static str,
    arguments: &'static [&'static str],
    caption: &'static str,
}

const CRATE_PICTURES: [CratePicture; 6] = [
    CratePicture {
        name: "argil",
        scene: "props",
        arguments: &["--via", "bricks"],
        caption: "121 brushes with materials, rendered through sparse bricks",
    },
    CratePicture {
        name: "argil-scene",
        scene: "trees",
        arguments: &[],
        caption: "Trunks and crowns joined by smooth unions",
    },
    CratePicture {
        name: "argil-field",
        scene: "csg20",
        arguments: &["--show", "heat"],
        caption: "The steps of each ray through the exact field, from blue to red",
    },
    CratePicture {
        name: "argil-volume",
        scene: "csg20",
        arguments: &["--via", "bricks", "--show", "bricks", "--resolution", "128"],
        caption: "The bricks of a volume, one color each",
    },
    CratePicture {
        name: "argil-render",
        scene: "temple",
        arguments: &["--show", "normal"],
        caption: "Normals as colors",
    },
    CratePicture {
        name: "argil-mesh",
        scene: "csg20",
        arguments: &["--via", "mesh", "--flat", "--resolution", "32"],
        caption: "The triangles of a coarse mesh",
    },
];

/// Renders the pictures of crate pages, as [`pictures`] does.
pub(crate) fn crate_pictures() -> anyhow::Result<Vec<(PathBuf, String)>> {
    let folder = tempfile::tempdir().context("a temporary folder")?;
    let render = |crate_picture: &CratePicture| {
        let picture = folder.path().join(format!("{}.png", crate_picture.name));
        let scene = root().join(format!("scenes/{}.json", crate_picture.scene));
        render(&scene, &picture, "320x180", crate_picture.arguments)?;
        let caption = crate_picture.caption;
        let path = format!("crates/{}/src/pictures/page.md", crate_picture.name);
        let image = embedded(caption, &picture)?;
        Ok((root().join(path), format!("{image}\n{caption}.\n")))
    };
    CRATE_PICTURES.iter().map(render).collect()
}

/// Returns Markdown that embeds a picture.
fn embedded(caption: &str, picture: &Path) -> anyhow::Result<String> {
    let bytes = std::fs::read(picture).context("a picture")?;
    let data = BASE64_STANDARD.encode(bytes);
    Ok(format!("\n![{caption}](data:image/png;base64,{data})\n"))
}

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
            render(&scene, &picture, "96x96", &[])?;
            let path = format!("crates/argil-scene/src/pictures/{name}.md");
            Ok((root().join(path), embedded(&name, &picture)?))
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

fn render(scene: &Path, picture: &Path, size: &str, others: &[&str]) -> anyhow::Result<()> {
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
            "--samples",
            "4",
            "--no-ground",
            "--size",
            size,
        ])
        .args(others)
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
