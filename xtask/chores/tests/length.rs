//! Checks that files stay short. The head of a longer file gives the reason, after `*Length.*`.

use std::path::{Path, PathBuf};

/// Maximum lines of a file of each kind.
const MOST: [(&str, usize); 2] = [("rs", 450), ("wgsl", 150)];

pub(crate) fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        let name = entry.file_name();
        if path.is_dir() && name != "target" && !name.to_string_lossy().starts_with('.') {
            files(&path, out);
        } else if path.is_file() {
            out.push(path);
        }
    }
}

/// Returns the comment at the start of a file.
fn head(text: &str) -> impl Iterator<Item = &str> {
    text.lines().take_while(|line| line.starts_with("//"))
}

#[test]
fn long_files_say_why() {
    let mut all = Vec::new();
    files(&xtask::root(), &mut all);
    let mut seen = 0;
    let mut found = Vec::new();
    for path in all {
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        let Some((_, most)) = MOST.iter().find(|(kind, _)| *kind == ending) else {
            continue;
        };
        seen += 1;
        let text = std::fs::read_to_string(&path).expect("text");
        let lines = text.lines().count();
        let is_made = head(&text).any(|line| line.contains("Do not edit"));
        let has_reason = head(&text).any(|line| line.contains("*Length.*"));
        if lines > *most && !is_made && !has_reason {
            found.push(format!(
                "{} has {lines} lines, and {most} are the most",
                path.display()
            ));
        }
    }
    assert!(seen > 300, "{seen} files");
    assert!(
        found.is_empty(),
        "{found:#?}: cut them by what they do, or say why not after *Length.*"
    );
}
