//! Checks that prose stays plain: sentences are short, and words that nobody in this field uses do not return.

use std::path::Path;

/// Pages, with the limits of their sentences.
const PAGES: &[&str] = &[
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
];
/// Returns the words per sentence: the median, and the 95th percentile.
const MAX_MEDIAN: usize = 18;
const MAX_LONG: usize = 35;

/// Words of this project's old dialect, with replacements.
const BANNED: &[(&str, &str)] = &[
    ("anew", "again"),
    ("alike", "the same way"),
    ("lonely", "block_empty"),
    ("goers", "active rays"),
    ("beside the window", "in the background"),
    ("is no ", "is not a"),
    ("those of ", "name the things"),
];

/// Returns the sentences of Markdown, without code, tables, headings and the targets of links.
fn sentences(text: &str) -> Vec<String> {
    let mut paragraphs = vec![String::new()];
    let mut is_code = false;
    for line in text.lines() {
        let line = line.trim();
        if line.starts_with("```") {
            is_code = !is_code;
        }
        let is_other =
            is_code || line.starts_with(['`', '|', '#', '!', '<']) && !line.starts_with("`--");
        let is_item = ["* ", "- "].iter().any(|mark| line.starts_with(mark))
            || line
                .split_once(". ")
                .is_some_and(|(n, _)| n.parse::<u32>().is_ok());
        if line.is_empty() || is_other || is_item {
            paragraphs.push(String::new());
        }
        if !is_other && let Some(last) = paragraphs.last_mut() {
            last.push(' ');
            last.push_str(line.trim_start_matches(['*', '-']));
        }
    }
    let mut all = Vec::new();
    for paragraph in paragraphs {
        let mut sentence = String::new();
        for word in paragraph.split_whitespace() {
            sentence.push_str(word);
            sentence.push(' ');
            let bare = word.trim_end_matches([')', '*', '`', '"', '_']);
            if bare.ends_with(['.', '!', '?']) && !["e.g.", "al.", "i.e."].contains(&bare) {
                all.push(std::mem::take(&mut sentence));
            }
        }
        all.push(sentence);
    }
    all.retain(|sentence| sentence.split_whitespace().count() > 1);
    all
}

fn words(sentence: &str) -> usize {
    sentence
        .split_whitespace()
        .filter(|word| word.contains(char::is_alphanumeric))
        .count()
}

#[test]
fn sentences_are_short() {
    for page in PAGES {
        let text = std::fs::read_to_string(xtask::root().join(page)).expect("a page");
        let mut all: Vec<(usize, String)> = sentences(&text)
            .into_iter()
            .map(|s| (words(&s), s))
            .collect();
        all.sort();
        assert!(all.len() > 5, "{page}: {} sentences", all.len());
        let (median, _) = all[all.len() / 2];
        let (long, sentence) = &all[all.len() * 95 / 100];
        println!(
            "{page}: {} sentences, median {median}, 95 % {long}",
            all.len()
        );
        assert!(
            median <= MAX_MEDIAN,
            "{page}: the median sentence has {median} words"
        );
        assert!(*long <= MAX_LONG, "{page}: {long} words: {sentence}");
    }
}

#[test]
fn long_sentences_are_found() {
    let text = "One two three. `code` four!\n\n| a | table |\n* An item of five words";
    let counts: Vec<usize> = sentences(text).iter().map(|s| words(s)).collect();
    assert_eq!(counts, [3, 2, 5]);
}

fn check(path: &Path, found: &mut Vec<String>) {
    let Ok(text) = std::fs::read_to_string(path) else {
        return;
    };
    for (number, line) in text.lines().enumerate() {
        let lower = format!("{} ", line.to_lowercase());
        for (word, instead) in BANNED {
            let is_there = lower.match_indices(word).any(|(at, _)| {
                let before = lower[..at].chars().next_back();
                let after = lower[at + word.len()..].chars().next();
                !before.is_some_and(char::is_alphanumeric)
                    && (word.ends_with(' ') || !after.is_some_and(char::is_alphanumeric))
            });
            if is_there {
                found.push(format!(
                    "{}:{}: \"{word}\": write {instead}",
                    path.display(),
                    number + 1
                ));
            }
        }
    }
}

#[test]
fn private_words_do_not_come_back() {
    let mut found = Vec::new();
    for page in PAGES {
        check(&xtask::root().join(page), &mut found);
    }
    for folder in std::fs::read_dir(xtask::root().join("crates"))
        .expect("crates")
        .flatten()
    {
        check(&folder.path().join("src/crate.md"), &mut found);
    }
    assert!(found.is_empty(), "{found:#?}");
}
