//! No two files of a crate import each other, neither at once nor around several corners.
//!
//! A file imports another where a path of its own leads to an item of the other: `use` declarations, paths in code and in macros alike,
//! through re-exports and imported modules to the file that has the item. Tests inside a file may import what they like. What is not
//! seen: calls of methods, whose file no path names, so that a type's methods may stand in several files; and `use crate::*`, which
//! is refused for that.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

/// A module of its own file, or one written inside another's.
#[derive(Default)]
struct Module {
    file: PathBuf,
    /// Names that it only hands on, with the path that leads to what they mean.
    reexports: BTreeMap<String, Vec<String>>,
    /// Modules whose names are all handed on.
    globs: Vec<Vec<String>>,
    /// Names that it imports for itself, with the path that leads to what they mean.
    imports: BTreeMap<String, Vec<String>>,
    /// Names of what it has itself.
    items: BTreeSet<String>,
    /// Words of its code.
    words: BTreeSet<String>,
    /// Paths that stand in it, from the crate's root.
    paths: BTreeSet<Vec<String>>,
}

type Modules = BTreeMap<Vec<String>, Module>;

fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|own| {
        let mut is_test = false;
        if own.path().is_ident("cfg") {
            // What else stands in it makes no difference.
            let _ = own.parse_nested_meta(|meta| {
                is_test |= meta.path.is_ident("test");
                Ok(())
            });
        }
        is_test
    })
}

/// Reads a file's modules and what each of them names.
struct Reader<'a> {
    modules: &'a mut Modules,
    at: Vec<String>,
    file: PathBuf,
    /// The folder in which modules of this one lie.
    folder: PathBuf,
}

fn read(modules: &mut Modules, at: Vec<String>, file: &Path, folder: PathBuf) {
    let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let own = modules.entry(at.clone()).or_default();
    own.file = file.to_owned();
    let file = file.to_owned();
    let mut reader = Reader {
        modules,
        at,
        file,
        folder,
    };
    reader.visit_file(&parsed);
}

impl Reader<'_> {
    fn own(&mut self) -> &mut Module {
        self.modules.entry(self.at.clone()).or_default()
    }

    /// A path from the crate's root, if it leads into the crate.
    fn absolute(&self, path: &[String]) -> Option<Vec<String>> {
        let mut at = self.at.clone();
        let mut rest = path;
        match path.first()?.as_str() {
            "crate" => (at, rest) = (Vec::new(), &path[1..]),
            "self" => rest = &path[1..],
            "super" => {
                while rest.first().is_some_and(|word| word == "super") {
                    at.pop();
                    rest = &rest[1..];
                }
            }
            // A child, if it is one: that is known when all files are read.
            _ => {}
        }
        at.extend(rest.iter().cloned());
        Some(at)
    }

    fn tree(&mut self, tree: &syn::UseTree, before: &[String], is_public: bool) {
        let mut path = before.to_vec();
        match tree {
            syn::UseTree::Path(own) => {
                path.push(own.ident.to_string());
                self.tree(&own.tree, &path, is_public);
            }
            syn::UseTree::Group(own) => {
                for tree in &own.items {
                    self.tree(tree, before, is_public);
                }
            }
            syn::UseTree::Name(own) => {
                let name = own.ident.to_string();
                if name != "self" {
                    path.push(name.clone());
                }
                self.used(path, Some(name), is_public);
            }
            syn::UseTree::Rename(own) => {
                path.push(own.ident.to_string());
                self.used(path, Some(own.rename.to_string()), is_public);
            }
            syn::UseTree::Glob(_) => self.used(path, None, is_public),
        }
    }

    /// Take note of a path in code.
    fn named(&mut self, path: Vec<String>) {
        if let [word] = &path[..] {
            let word = word.clone();
            self.own().words.insert(word);
        } else if let Some(path) = self.absolute(&path) {
            self.own().paths.insert(path);
        }
    }

    /// Take note of the paths among a macro's tokens.
    fn tokens(&mut self, tokens: proc_macro2::TokenStream) {
        let mut path = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                proc_macro2::TokenTree::Ident(word) => {
                    if colons != 2 {
                        self.named(std::mem::take(&mut path));
                    }
                    path.push(word.to_string());
                    colons = 0;
                }
                proc_macro2::TokenTree::Punct(own) if own.as_char() == ':' => colons += 1,
                other => {
                    self.named(std::mem::take(&mut path));
                    colons = 0;
                    if let proc_macro2::TokenTree::Group(group) = other {
                        self.tokens(group.stream());
                    }
                }
            }
        }
        self.named(path);
    }

    fn used(&mut self, path: Vec<String>, name: Option<String>, is_public: bool) {
        let Some(path) = self.absolute(&path) else {
            return;
        };
        // What is only handed on is used by those that take it.
        match name {
            Some(name) if is_public => drop(self.own().reexports.insert(name, path)),
            None if is_public => self.own().globs.push(path),
            Some(name) => {
                self.own().imports.insert(name, path.clone());
                self.own().paths.insert(path);
            }
            None => {
                assert!(!path.is_empty(), "{}: `use crate::*`", self.file.display());
                self.own().paths.insert(path);
            }
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if is_for_tests(&item.attrs) {
            return;
        }
        let name = item.ident.to_string();
        let mut at = self.at.clone();
        at.push(name.clone());
        if item.content.is_some() {
            let before = std::mem::replace(&mut self.at, at);
            let file = self.file.clone();
            self.own().file = file;
            visit::visit_item_mod(self, item);
            self.at = before;
            return;
        }
        let path = item.attrs.iter().find_map(|own| match &own.meta {
            syn::Meta::NameValue(pair) if own.path().is_ident("path") => match &pair.value {
                syn::Expr::Lit(syn::ExprLit {
                    lit: syn::Lit::Str(text),
                    ..
                }) => Some(text.value()),
                _ => None,
            },
            _ => None,
        });
        let beside = self.folder.join(format!("{name}.rs"));
        let file = match path {
            Some(path) => self.file.with_file_name(path),
            None if beside.exists() => beside,
            None => self.folder.join(&name).join("mod.rs"),
        };
        read(self.modules, at, &file, self.folder.join(name));
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if !is_for_tests(&item.attrs) {
            let is_public = !matches!(item.vis, syn::Visibility::Inherited);
            self.tree(&item.tree, &[], is_public);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let words: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        self.named(words);
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, own: &'ast syn::Macro) {
        self.named(
            own.path
                .segments
                .iter()
                .map(|s| s.ident.to_string())
                .collect(),
        );
        self.tokens(own.tokens.clone());
    }

    fn visit_item(&mut self, item: &'ast syn::Item) {
        let name = match item {
            syn::Item::Fn(own) => Some(&own.sig.ident),
            syn::Item::Struct(own) => Some(&own.ident),
            syn::Item::Enum(own) => Some(&own.ident),
            syn::Item::Trait(own) => Some(&own.ident),
            syn::Item::Type(own) => Some(&own.ident),
            syn::Item::Const(own) => Some(&own.ident),
            syn::Item::Static(own) => Some(&own.ident),
            _ => None,
        };
        if let Some(name) = name {
            let name = name.to_string();
            self.own().items.insert(name);
        }
        visit::visit_item(self, item);
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !is_for_tests(&item.attrs) {
            visit::visit_item_fn(self, item);
        }
    }
}

/// The module that has what a path leads to.
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
            .filter(|own| own.file != module.file || to.len() > known);
    }
    for glob in &module.globs {
        let has = |own: &Module| own.reexports.contains_key(name) || own.items.contains(name);
        if modules.get(glob).is_some_and(has) {
            let mut to = glob.clone();
            to.extend_from_slice(&path[known..]);
            return home(modules, &to, depth + 1);
        }
    }
    Some(module)
}

/// Which files of a crate import which.
fn imports(root: &Path) -> BTreeMap<PathBuf, BTreeSet<PathBuf>> {
    let mut modules = Modules::new();
    let folder = root.parent().expect("a folder").to_owned();
    read(&mut modules, Vec::new(), root, folder);
    let mut all: BTreeMap<PathBuf, BTreeSet<PathBuf>> = BTreeMap::new();
    for (at, module) in &modules {
        let own = all.entry(module.file.clone()).or_default();
        // What is handed on and used besides is imported.
        let used = module.reexports.iter();
        let used = used.filter(|(name, _)| module.words.contains(*name));
        for (_, path) in used {
            own.extend(home(&modules, path, 0).map(|to| to.file.clone()));
        }
        for path in &module.paths {
            // Through a module that was imported.
            let first = path.get(at.len()).filter(|_| path.starts_with(at));
            if let Some(through) = first.and_then(|name| module.imports.get(name)) {
                let path = [through, &path[at.len() + 1..]].concat();
                own.extend(home(&modules, &path, 0).map(|to| to.file.clone()));
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
                own.insert(to.file.clone());
            }
        }
    }
    for (file, to) in &mut all {
        to.remove(file);
    }
    all
}

/// Files from which a way leads back to themselves, in groups.
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
        let own = ways[file].iter().copied();
        own.filter(|other| ways.get(other).is_some_and(|back| back.contains(file)))
            .cloned()
            .collect()
    };
    all.keys()
        .map(group)
        .filter(|own| !own.is_empty())
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
        .map(|own| {
            own.iter()
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
