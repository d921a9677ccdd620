//! READMEs of crates: their crate pages without the links that only rustdoc resolves.

use anyhow::Context;
use std::path::PathBuf;
use xtask::root;

/// Returns the README of every crate that has a page, as its path and its text.
pub(crate) fn readmes() -> anyhow::Result<Vec<(PathBuf, String)>> {
    let crates = std::fs::read_dir(root().join("crates")).context("crates")?;
    let mut all = Vec::new();
    for folder in crates {
        let folder = folder.context("crates")?.path();
        let page = folder.join("src/crate.md");
        let text = std::fs::read_to_string(&page).with_context(|| page.display().to_string())?;
        all.push((folder.join("README.md"), readme(&text)));
    }
    all.sort();
    Ok(all)
}

/// Removes links to items and hidden lines of examples: `` [`Aabb`] `` becomes `` `Aabb` ``.
fn readme(page: &str) -> String {
    let mut text =
        "<!-- Made from src/crate.md by `cargo xtask generate`. Do not edit. -->\n".to_owned();
    for line in page.lines() {
        if line.starts_with("# ") && line.contains(['(', ';', '}']) {
            continue;
        }
        let mut rest = line;
        while let Some((before, link)) = rest.split_once("[`") {
            let Some((name, after)) = link.split_once("`]") else {
                break;
            };
            text += before;
            match after
                .strip_prefix('(')
                .and_then(|target| target.split_once(')'))
            {
                Some((target, _)) if target.starts_with("http") => {
                    text += &format!("[`{name}`]");
                    rest = after;
                }
                Some((_, after)) => {
                    text += &format!("`{name}`");
                    rest = after;
                }
                None => {
                    text += &format!("`{name}`");
                    rest = after;
                }
            }
        }
        text += rest;
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_readmes_are_up_to_date() {
        for (path, text) in readmes().expect("pages") {
            let committed = std::fs::read_to_string(&path).unwrap_or_default();
            assert!(
                committed == text,
                "{}: run cargo xtask generate",
                path.display()
            );
        }
    }

    #[test]
    fn links_to_items_and_hidden_lines_go() {
        let page = "[`A`], [`b`](fn@b) and [`c`](https://c.d)\n# Ok::<(), E>(())\n# Title";
        let text = readme(page);
        assert!(
            text.ends_with("`A`, `b` and [`c`](https://c.d)\n# Title\n"),
            "{text}"
        );
    }
}
