//! Tests of the editor's page in Chromium.

use crate::web;
use anyhow::{Context, bail};
use argil::gpu::hardware_modules;
use argil::math::Control;
use argil::scene::Scene;
use argil_field::Program;
use argil_world::{PlanOptions, Shard, Store, StoredWorld, TileCacheOptions, WorldPlan};
use std::path::{Path, PathBuf};
use xtask::apt::{CHROMIUM, NODE, install, quietly};
use xtask::{root, run};

/// Names of Chromium and related browsers.
const BROWSERS: [&str; 4] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
];

/// Compiles all shaders in Chromium, whose compiler refuses some WGSL that naga accepts.
pub(crate) fn check_shaders() -> anyhow::Result<()> {
    let browser = ensure_browser()?;
    ensure_node()?;
    let folder = page_folder()?;
    let program = Program::lower(&argil_conformance::universal())?;
    let modules: Vec<_> = hardware_modules(&program)
        .into_iter()
        .map(|module| serde_json::json!({ "name": module.name, "source": module.source }))
        .collect();
    let path = folder.join("shaders.json");
    std::fs::write(&path, serde_json::to_vec(&modules)?)
        .with_context(|| path.display().to_string())?;
    let script = folder.join("shaders.mjs").display().to_string();
    run("node", &[&script, &browser, &path.display().to_string()])
}

/// Clicks, drags and types on the built page. Screenshots go to `target/page-test`.
pub(crate) fn test() -> anyhow::Result<()> {
    let browser = ensure_browser()?;
    ensure_node()?;
    let folder = page_folder()?;
    let place = folder.display().to_string();
    let server = web::server(0)?;
    let url = format!("http://{}/", server.server_addr());
    std::thread::spawn(move || web::answer(&web::TESTED, &server));
    let script = folder.join("test.mjs").display().to_string();
    let world = bake_world(&folder.join("world"))?.display().to_string();
    check_3d_tiles(&world)?;
    run("node", &[&script, &url, &browser, &place, &world])
}

fn page_folder() -> anyhow::Result<PathBuf> {
    let scripts = ["browser.mjs", "shaders.mjs", "test.mjs"];
    node_folder("page-test", "apps/argil-studio/page", &scripts)
}

/// Copies scripts and installs their packages next to them, where Node looks for them. Returns the folder.
fn node_folder(name: &str, from: &str, scripts: &[&str]) -> anyhow::Result<PathBuf> {
    let folder = root().join("target").join(name);
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    for name in ["package.json", "package-lock.json"].iter().chain(scripts) {
        let from = root().join(from).join(name);
        std::fs::copy(&from, folder.join(name)).with_context(|| from.display().to_string())?;
    }
    let place = folder.display().to_string();
    run(
        "npm",
        &["ci", "--prefix", &place, "--no-audit", "--no-fund"],
    )?;
    Ok(folder)
}

/// Exports a world as 3D Tiles, and reads them by the specification and with Khronos' validator of glTF.
fn check_3d_tiles(world: &str) -> anyhow::Result<()> {
    let folder = node_folder(
        "3d-tiles-test",
        "crates/argil-world/tests/tiles3d",
        &["check.mjs"],
    )?;
    let out = folder.join("tiles");
    StoredWorld::open(world, &TileCacheOptions::default())?.export_3d_tiles(
        &out,
        None,
        &Control::default(),
    )?;
    let script = folder.join("check.mjs").display().to_string();
    run("node", &[&script, &out.display().to_string()])
}

/// Bakes a world for the page to read, and returns its folder.
fn bake_world(folder: &Path) -> anyhow::Result<PathBuf> {
    let path = root().join("scenes/csg20.json");
    let scene = Scene::open(&path)?;
    let options = PlanOptions {
        voxel_size: 0.004,
        ..PlanOptions::default()
    };
    let plan = WorldPlan::new(&scene, &options)?;
    // Without edits from the last time.
    if folder.exists() {
        std::fs::remove_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let store = Store::create(&folder.display().to_string())?;
    let control = Control::default();
    argil_world::bake(&plan, &scene, &store, Shard::WHOLE, &control)?;
    argil_world::finish(&plan, &scene, &store, false, &control)?;
    Ok(folder.join(plan.hash()))
}

fn ensure_browser() -> anyhow::Result<String> {
    let find = || {
        let found = BROWSERS.iter().find(|b| quietly(b, &["--version"]))?;
        let path = std::env::split_paths(&std::env::var_os("PATH")?)
            .map(|folder| folder.join(found))
            .find(|path| path.is_file())?;
        Some(path.display().to_string())
    };
    if find().is_none() {
        println!("\nNo Chromium found: installing it for the page's tests.");
        install(CHROMIUM.packages);
    }
    find().context(
        "the page's tests need Chromium or Chrome: on Debian, apt-get install chromium; elsewhere, put it on the PATH",
    )
}

fn ensure_node() -> anyhow::Result<()> {
    if !NODE.is_there() {
        println!("\nNo Node.js found: installing it for the page's tests.");
        install(NODE.packages);
    }
    if !NODE.is_there() {
        bail!("the page's tests need Node.js 20 or later: https://nodejs.org");
    }
    Ok(())
}
