//! Checks that every test runs. What Cargo does not look for by itself is named, and what it skips has no tests.

use std::path::{Path, PathBuf};

fn entries(folder: &Path) -> Vec<PathBuf> {
    let found = std::fs::read_dir(folder).into_iter().flatten().flatten();
    found.map(|entry| entry.path()).collect()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).expect("text")
}

/// Returns the folders of crates.
fn crates() -> Vec<PathBuf> {
    let root = xtask::root();
    let folders = ["crates", "apps", "xtask", "."].map(|name| root.join(name));
    let all = folders.iter().flat_map(|folder| entries(folder));
    all.filter(|path| path.join("src").is_dir() && path.join("Cargo.toml").is_file())
        .collect()
}

/// Returns files and folders of a crate's tests that its test program does not have.
fn left_out(package: &Path) -> Vec<PathBuf> {
    let folder = package.join("tests");
    let all = entries(&folder);
    let is_module = |path: &&PathBuf| {
        path.extension().is_some_and(|ending| ending == "rs") || path.join("mod.rs").is_file()
    };
    let parts = all
        .iter()
        .filter(is_module)
        .filter(|path| !path.ends_with("main.rs"));
    let main = folder.join("main.rs");
    if !main.is_file() {
        // One file is a program by itself.
        return parts.skip(1).cloned().collect();
    }
    let main = text(&main);
    let is_named = |path: &Path| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        main.lines().any(|line| line == format!("mod {name};"))
    };
    parts.filter(|path| !is_named(path)).cloned().collect()
}

/// Returns true if a file, or one in a folder, has a test.
fn has_tests(path: &Path) -> bool {
    if path.is_dir() {
        return entries(path).iter().any(|path| has_tests(path));
    }
    path.extension().is_some_and(|ending| ending == "rs") && text(path).contains("#[test]")
}

/// Returns the sources of a crate that Cargo does not test: of the library, or of the program alone.
fn skipped(package: &Path) -> Vec<PathBuf> {
    let manifest = text(&package.join("Cargo.toml"));
    let parts = manifest
        .split("\n[")
        .filter(|part| part.contains("\ntest = false"));
    let has_library = package.join("src/lib.rs").is_file();
    parts
        .map(|part| {
            let is_alone = part.starts_with("[bin]]") && has_library;
            package.join(if is_alone { "src/main.rs" } else { "src" })
        })
        .collect()
}

#[test]
fn every_test_runs() {
    let (mut parts, mut seen) = (0, 0);
    for package in crates() {
        assert_eq!(
            left_out(&package),
            Vec::<PathBuf>::new(),
            "tests/main.rs names each part"
        );
        parts += entries(&package.join("tests")).len();
        for path in skipped(&package) {
            assert!(
                !has_tests(&path),
                "{} has tests, and is not tested",
                path.display()
            );
            seen += 1;
        }
    }
    assert!(parts > 60 && seen > 3, "{parts} parts, {seen} skipped");
}

#[test]
fn a_test_that_does_not_run_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let put = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    };
    put("tests/one.rs", "");
    assert!(left_out(folder.path()).is_empty());
    put("tests/two/mod.rs", "");
    assert_eq!(left_out(folder.path()).len(), 1);
    put("tests/main.rs", "mod one;\nmod twofold;\n");
    assert!(left_out(folder.path())[0].ends_with("two"));
    put("tests/main.rs", "mod one;\nmod two;\n");
    assert!(left_out(folder.path()).is_empty());

    put("src/lib.rs", "#[test]\nfn works() {}\n");
    put("src/main.rs", "");
    put("Cargo.toml", "[package]\n\n[[bin]]\ntest = false\n");
    assert!(skipped(folder.path()).iter().all(|path| !has_tests(path)));
    put("Cargo.toml", "[package]\n\n[lib]\ntest = false\n");
    assert!(skipped(folder.path()).iter().any(|path| has_tests(path)));
}
