//! Tests of the editor's page in Chromium.

use crate::web;
use anyhow::{Context, bail};
use xtask::apt::{install, quietly};
use xtask::{root, run};

/// Names of Chromium and related browsers.
const BROWSERS: [&str; 4] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
];

/// Clicks, drags and types on the built page. Screenshots go to `target/page-test`.
pub(crate) fn test() -> anyhow::Result<()> {
    let browser = ensure_browser()?;
    ensure_node()?;
    // Node looks for packages next to the script.
    let folder = root().join("target").join("page-test");
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    for name in ["package.json", "package-lock.json", "test.mjs"] {
        let from = root().join("apps/argil-studio/page").join(name);
        std::fs::copy(&from, folder.join(name)).with_context(|| from.display().to_string())?;
    }
    let place = folder.display().to_string();
    run(
        "npm",
        &["ci", "--prefix", &place, "--no-audit", "--no-fund"],
    )?;
    let server = web::server(0)?;
    let url = format!("http://{}/", server.server_addr());
    std::thread::spawn(move || web::answer(&server));
    let script = folder.join("test.mjs").display().to_string();
    run("node", &[&script, &url, &browser, &place])
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
        install(&["chromium"]);
    }
    find().context(
        "the page's tests need Chromium or Chrome: on Debian, apt-get install chromium; elsewhere, put it on the PATH",
    )
}

fn ensure_node() -> anyhow::Result<()> {
    let is_there = || quietly("node", &["--version"]) && quietly("npm", &["--version"]);
    if !is_there() {
        println!("\nNo Node.js found: installing it for the page's tests.");
        install(&["nodejs", "npm"]);
    }
    if !is_there() {
        bail!("the page's tests need Node.js 20 or later: https://nodejs.org");
    }
    Ok(())
}
