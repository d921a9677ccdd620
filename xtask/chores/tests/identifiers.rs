//! Checks that words of this project's old dialect leave its identifiers. Their counts may only fall.

use crate::length::files;
use proc_macro2::{TokenStream, TokenTree};
use std::collections::BTreeMap;

/// Words, what to write instead, and how many identifiers are still that word.
const WORDS: &[(&str, &str, usize)] = &[
    ("asked", "requested, or the noun", 104),
    ("found", "the noun: a hit, a cell, an index", 1206),
    ("held", "bounds, or the noun", 344),
    ("kept", "the noun, or `retained`", 202),
    ("least", "min", 254),
    ("made", "the noun: a mesh, a block", 190),
    ("most", "max", 323),
    ("nth", "index", 0),
    ("own", "the noun: a cell, an edit, a box", 587),
    ("told", "the noun", 47),
    ("why", "reason", 4),
];

/// Counts the identifiers in a stream of tokens. What follows a single dot is declared elsewhere.
fn count(tokens: TokenStream, counts: &mut BTreeMap<String, usize>) {
    let mut dots = 0;
    for token in tokens {
        match &token {
            TokenTree::Ident(name) if dots != 1 => {
                *counts.entry(name.to_string()).or_default() += 1;
            }
            TokenTree::Group(group) => count(group.stream(), counts),
            _ => {}
        }
        let is_dot = matches!(&token, TokenTree::Punct(mark) if mark.as_char() == '.');
        dots = if is_dot { dots + 1 } else { 0 };
    }
}

/// Counts the identifiers of a shader, without comments.
fn count_in_shader(text: &str, counts: &mut BTreeMap<String, usize>) {
    let code = text.lines().filter_map(|line| line.split("//").next());
    let names = code.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_'));
    for name in names {
        *counts.entry(name.to_string()).or_default() += 1;
    }
}

#[test]
fn old_words_leave_identifiers() {
    let mut all = Vec::new();
    files(&xtask::root(), &mut all);
    let mut counts = BTreeMap::new();
    for path in all {
        let text = || std::fs::read_to_string(&path).expect("text");
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("rs") => {
                let tokens = text().parse::<TokenStream>();
                let tokens = tokens.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
                count(tokens, &mut counts);
            }
            Some("wgsl") => count_in_shader(&text(), &mut counts),
            _ => {}
        }
    }
    let mut faults = Vec::new();
    for &(word, instead, limit) in WORDS {
        let count = counts.get(word).copied().unwrap_or(0);
        if count > limit {
            faults.push(format!(
                "`{word}` names {count} things, and {limit} at most: write {instead}"
            ));
        } else if count < limit {
            faults.push(format!(
                "`{word}` names {count} things: lower its limit of {limit}"
            ));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn identifiers_are_counted() {
    let mut counts = BTreeMap::new();
    let code = "/// own\nfn own(a: u8) { let s = \"own\"; x.own = own!(own_box, 0..own); }";
    count(code.parse().expect("tokens"), &mut counts);
    assert_eq!(counts["own"], 3);
    count_in_shader("let own = own_box; // own", &mut counts);
    assert_eq!(counts["own"], 4);
}
