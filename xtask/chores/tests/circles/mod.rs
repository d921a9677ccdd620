//! No two files of a crate import each other, directly or through other files.
//!
//! A file imports another if one of its paths leads to an item of the other. Paths are in `use` declarations, in
//! code and in macros, through re-exports and imported modules. Tests inside a file may import anything. Two things
//! are not found: calls of methods, because no path names their file, and `use crate::*`, which is therefore
//! refused.

mod modules;

use modules::{Module, Modules, read};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Returns the module that has the item of a path.
fn home<'a>(modules: &'a Modules, path: &[String], depth: usize) -> Option<&'a Module> {
    if depth > 20 {
        return None;
    }
    let known = (0..=path.len())
        .rev()
        .find(|&length| modules.contains_key(&path[..length]))?;
    let module = &modules[&path[..known]];
    let Some(name) = path.get(known) else {
        return Some(module);
    };
    if let Some(to) = module.reexports.get(name) {
        let mut to = to.clone();
        to.extend_from_slice(&path[known + 1..]);
        // One that leads out of the crate is nobody's here.
        return home(modules, &to, depth + 1)
            .filter(|home_of_item| home_of_item.file != module.file || to.len() > known);
    }
    for glob in &module.globs {
        let has = |other: &Module| other.reexports.contains_key(name) || other.items.contains(name);
        if modules.get(glob).is_some_and(has) {
            let mut to = glob.clone();
            to.extend_from_slice(&path[known..]);
            return home(modules, &to, depth + 1);
        }
    }
    Some(module)
}

/// Returns which files of a crate import which.
fn imports(root: &Path) -> BTreeMap<PathBuf, BTreeSet<PathBuf>> {
    let mut modules = Modules::new();
    let folder = root.parent().expect("a folder").to_owned();
    read(&mut modules, Vec::new(), root, folder);
    let mut all: BTreeMap<PathBuf, BTreeSet<PathBuf>> = BTreeMap::new();
    for (at, module) in &modules {
        let of_file = all.entry(module.file.clone()).or_default();
        // What is handed on and used besides is imported.
        let used = module.reexports.iter();
        let used = used.filter(|(name, _)| module.words.contains(*name));
        for (_, path) in used {
            of_file.extend(home(&modules, path, 0).map(|to| to.file.clone()));
        }
        for path in &module.paths {
            // Through a module that was imported.
            let first = path.get(at.len()).filter(|_| path.starts_with(at));
            if let Some(through) = first.and_then(|name| module.imports.get(name)) {
                let path = [through, &path[at.len() + 1..]].concat();
                of_file.extend(home(&modules, &path, 0).map(|to| to.file.clone()));
                continue;
            }
            // A word that is no module of this one leads elsewhere: to another crate, or to what is in scope already.
            let is_within = path.len() > at.len() && path[..at.len()] == at[..];
            if is_within && !modules.contains_key(&path[..=at.len()]) {
                let name = &path[at.len()];
                if !module.reexports.contains_key(name) {
                    continue;
                }
            }
            if let Some(to) = home(&modules, path, 0) {
                of_file.insert(to.file.clone());
            }
        }
    }
    for (file, to) in &mut all {
        to.remove(file);
    }
    all
}

/// Returns files that can reach themselves, in groups.
fn circles(all: &BTreeMap<PathBuf, BTreeSet<PathBuf>>) -> BTreeSet<Vec<PathBuf>> {
    let reached = |from: &Path| {
        let mut seen: BTreeSet<&PathBuf> = BTreeSet::new();
        let mut ahead: Vec<&PathBuf> = all.get(from).into_iter().flatten().collect();
        while let Some(file) = ahead.pop() {
            if seen.insert(file) {
                ahead.extend(all.get(file).into_iter().flatten());
            }
        }
        seen
    };
    let ways: BTreeMap<&PathBuf, BTreeSet<&PathBuf>> =
        all.keys().map(|file| (file, reached(file))).collect();
    let group = |file: &PathBuf| -> Vec<PathBuf> {
        let next = ways[file].iter().copied();
        next.filter(|other| ways.get(other).is_some_and(|back| back.contains(file)))
            .cloned()
            .collect()
    };
    all.keys()
        .map(group)
        .filter(|circle| !circle.is_empty())
        .collect()
}

fn roots() -> Vec<PathBuf> {
    let root = xtask::root();
    let mut found = Vec::new();
    for folder in ["crates", "apps", "."] {
        let entries = std::fs::read_dir(root.join(folder)).expect("a folder");
        for entry in entries.flatten() {
            for name in ["src/lib.rs", "src/main.rs"] {
                found.extend(Some(entry.path().join(name)).filter(|path| path.exists()));
            }
        }
    }
    found.push(root.join("xtask/chores/src/main.rs"));
    found.sort();
    found
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut found = Vec::new();
    let (mut files, mut arrows) = (0, 0);
    for root in roots() {
        let all = imports(&root);
        files += all.len();
        arrows += all.values().map(BTreeSet::len).sum::<usize>();
        found.extend(circles(&all));
    }
    println!("{files} files, {arrows} arrows");
    assert!(
        files > 300 && arrows > files,
        "{files} files, {arrows} arrows"
    );
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_circle_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let put = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    };
    // `one` takes from `two` by the crate's re-export, `two` from `three` by a path in code, `three` from `one`.
    put(
        "lib.rs",
        "mod one; mod two; mod three; pub use two::Two; mod alone;",
    );
    put("one.rs", "use crate::Two; pub struct One(Two);");
    put(
        "two.rs",
        "pub struct Two; fn three() { crate::three::three() }",
    );
    put("three.rs", "use super::one::One; pub fn three() {}");
    put(
        "alone.rs",
        "#[cfg(test)] mod tests { use crate::one::One; } use crate::Two;",
    );
    let found = circles(&imports(&folder.path().join("lib.rs")));
    let names: Vec<Vec<_>> = found
        .iter()
        .map(|circle| {
            circle
                .iter()
                .map(|p| p.file_stem().expect("a name").to_owned())
                .collect()
        })
        .collect();
    assert_eq!(names, [["one", "three", "two"]]);
    put("three.rs", "pub fn three() {}");
    assert!(circles(&imports(&folder.path().join("lib.rs"))).is_empty());
    // Other ways to the same: all that is handed on, a macro, a name that is handed on and used, an imported module.
    let root = "mod a; mod b; mod hub; pub use a::*;";
    for (a, b) in [
        (
            "use crate::b::B; pub struct A(B);",
            "use crate::A; pub struct B; fn f(_: A) {}",
        ),
        (
            "pub fn a() { println!(\"{}\", crate::b::b()) }",
            "use crate::a::a; pub fn b() -> u8 { a(); 1 }",
        ),
        (
            "pub(crate) use crate::b::B; pub struct A(B);",
            "use crate::a::A; pub struct B; fn f(_: A) {}",
        ),
        (
            "use crate::hub; pub struct A; fn f() { hub::b() }",
            "use crate::a::A; pub fn b() -> A { A }",
        ),
    ] {
        put("lib.rs", root);
        put("hub.rs", "pub use crate::b::b;");
        put("a.rs", a);
        put("b.rs", b);
        let found = circles(&imports(&folder.path().join("lib.rs")));
        assert_eq!(found.len(), 1, "{a} {b}: {found:?}");
    }
}
