//! Lists the modules of a crate, and the items that each of them names.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

/// A module with its own file, or an inline module.
#[derive(Default)]
pub(crate) struct Module {
    pub file: PathBuf,
    /// Re-exported names, with the paths of their items.
    pub reexports: BTreeMap<String, Vec<String>>,
    /// Modules that are re-exported with a glob.
    pub globs: Vec<Vec<String>>,
    /// Imported names, with the paths of their items.
    pub imports: BTreeMap<String, Vec<String>>,
    /// Names of the module's own items.
    pub items: BTreeSet<String>,
    /// Identifiers in the module's code.
    pub words: BTreeSet<String>,
    /// Paths in the module's code, from the crate's root.
    pub paths: BTreeSet<Vec<String>>,
}

pub(crate) type Modules = BTreeMap<Vec<String>, Module>;

fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let mut is_test = false;
        if attribute.path().is_ident("cfg") {
            // What else stands in it makes no difference.
            let _ = attribute.parse_nested_meta(|meta| {
                is_test |= meta.path.is_ident("test");
                Ok(())
            });
        }
        is_test
    })
}

/// Reads a file's modules and the names in each.
struct Reader<'a> {
    modules: &'a mut Modules,
    at: Vec<String>,
    file: PathBuf,
    /// Returns the folder of a module's submodules.
    folder: PathBuf,
}

pub(crate) fn read(modules: &mut Modules, at: Vec<String>, file: &Path, folder: PathBuf) {
    let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let module = modules.entry(at.clone()).or_default();
    module.file = file.to_owned();
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
    fn module(&mut self) -> &mut Module {
        self.modules.entry(self.at.clone()).or_default()
    }

    /// Returns a path from the crate's root, if it leads into the crate.
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
            syn::UseTree::Path(use_path) => {
                path.push(use_path.ident.to_string());
                self.tree(&use_path.tree, &path, is_public);
            }
            syn::UseTree::Group(group) => {
                for tree in &group.items {
                    self.tree(tree, before, is_public);
                }
            }
            syn::UseTree::Name(single) => {
                let name = single.ident.to_string();
                if name != "self" {
                    path.push(name.clone());
                }
                self.used(path, Some(name), is_public);
            }
            syn::UseTree::Rename(renamed) => {
                path.push(renamed.ident.to_string());
                self.used(path, Some(renamed.rename.to_string()), is_public);
            }
            syn::UseTree::Glob(_) => self.used(path, None, is_public),
        }
    }

    /// Records a path in code.
    fn named(&mut self, path: Vec<String>) {
        if let [word] = &path[..] {
            let word = word.clone();
            self.module().words.insert(word);
        } else if let Some(path) = self.absolute(&path) {
            self.module().paths.insert(path);
        }
    }

    /// Records the paths among a macro's tokens.
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
                proc_macro2::TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
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
            Some(name) if is_public => drop(self.module().reexports.insert(name, path)),
            None if is_public => self.module().globs.push(path),
            Some(name) => {
                self.module().imports.insert(name, path.clone());
                self.module().paths.insert(path);
            }
            None => {
                assert!(!path.is_empty(), "{}: `use crate::*`", self.file.display());
                self.module().paths.insert(path);
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
            self.module().file = file;
            visit::visit_item_mod(self, item);
            self.at = before;
            return;
        }
        let path = item
            .attrs
            .iter()
            .find_map(|attribute| match &attribute.meta {
                syn::Meta::NameValue(pair) if attribute.path().is_ident("path") => {
                    match &pair.value {
                        syn::Expr::Lit(syn::ExprLit {
                            lit: syn::Lit::Str(text),
                            ..
                        }) => Some(text.value()),
                        _ => None,
                    }
                }
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

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.named(
            call.path
                .segments
                .iter()
                .map(|s| s.ident.to_string())
                .collect(),
        );
        self.tokens(call.tokens.clone());
    }

    fn visit_item(&mut self, item: &'ast syn::Item) {
        let name = match item {
            syn::Item::Fn(declared) => Some(&declared.sig.ident),
            syn::Item::Struct(declared) => Some(&declared.ident),
            syn::Item::Enum(declared) => Some(&declared.ident),
            syn::Item::Trait(declared) => Some(&declared.ident),
            syn::Item::Type(declared) => Some(&declared.ident),
            syn::Item::Const(declared) => Some(&declared.ident),
            syn::Item::Static(declared) => Some(&declared.ident),
            _ => None,
        };
        if let Some(name) = name {
            let name = name.to_string();
            self.module().items.insert(name);
        }
        visit::visit_item(self, item);
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !is_for_tests(&item.attrs) {
            visit::visit_item_fn(self, item);
        }
    }
}
