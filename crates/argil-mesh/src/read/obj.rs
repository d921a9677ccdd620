//! Wavefront OBJ: the polygons of all objects and groups.

use super::error::ReadFault;
use super::file::MeshFile;
use super::polygon::Polygons;
use super::text::{self, bad_line};
use std::borrow::Cow;

/// Statements that describe no surface, or only its look.
const OTHER: &[&str] = &[
    "vn",
    "vt",
    "vp",
    "o",
    "g",
    "s",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "cstype",
    "deg",
    "bmat",
    "step",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "stech",
    "ctech",
    "res",
    "off",
    "version",
];

/// Statements that are geometry and not read, with their names.
const LEFT_OUT: &[(&str, &[&str])] = &[
    ("line", &["l"]),
    ("point element", &["p"]),
    ("free-form curve", &["curv", "curv2"]),
    ("free-form surface", &["surf", "bzp", "bsp", "cdc", "cdp"]),
    ("reference to another file", &["call", "csh"]),
];

/// Counts statements that are left out.
#[derive(Default)]
struct LeftOut {
    counts: [u64; LEFT_OUT.len()],
    unknown: u64,
    first_unknown: Option<String>,
}

impl LeftOut {
    fn add(&mut self, number: usize, word: &[u8], line: &[u8]) {
        let is = |name: &&str| word.eq_ignore_ascii_case(name.as_bytes());
        if OTHER.iter().any(is) {
            return;
        }
        match LEFT_OUT.iter().position(|(_, names)| names.iter().any(is)) {
            Some(kind) => self.counts[kind] += 1,
            None => {
                self.unknown += 1;
                let first = || format!("line {number}: \"{}\"", text::quoted(line));
                self.first_unknown.get_or_insert_with(first);
            }
        }
    }

    fn warnings(self) -> Vec<String> {
        let plural = |count: u64| if count == 1 { "" } else { "s" };
        let counts = LEFT_OUT
            .iter()
            .zip(self.counts)
            .filter(|(_, count)| *count > 0);
        let mut warnings: Vec<String> = counts
            .map(|(&(name, _), count)| {
                format!(
                    "left out {count} {name}{}: only polygons are read",
                    plural(count)
                )
            })
            .collect();
        if let Some(first) = self.first_unknown {
            let count = self.unknown;
            warnings.push(format!(
                "left out {count} unknown statement{}, first at {first}",
                plural(count)
            ));
        }
        warnings
    }
}

/// Statements whose words are names and places of files. A folder of Windows ends in a backslash, too.
const NAMES: &[&[u8]] = &[
    b"o", b"g", b"usemtl", b"mtllib", b"usemap", b"maplib", b"call", b"csh",
];

/// Returns a line without the backslash at its end, if the next line continues it. Comments and names end with their line.
fn continued(line: &[u8]) -> Option<&[u8]> {
    let rest = line.trim_ascii_end().strip_suffix(b"\\")?;
    let is_name = || {
        text::words(line)
            .next()
            .is_some_and(|word| NAMES.contains(&word))
    };
    (!line.contains(&b'#') && !is_name()).then_some(rest)
}

/// Joins lines that end in a backslash with the next. Their number of lines stays, as empty ones.
fn joined(bytes: &[u8]) -> Cow<'_, [u8]> {
    if !bytes.contains(&b'\\') {
        return Cow::Borrowed(bytes);
    }
    let mut out = Vec::with_capacity(bytes.len());
    let mut owed = 0;
    for (_, line) in text::lines(bytes) {
        match continued(line) {
            Some(line) => {
                out.extend_from_slice(line);
                out.push(b' ');
                owed += 1;
            }
            None => {
                out.extend_from_slice(line);
                out.resize(out.len() + 1 + std::mem::take(&mut owed), b'\n');
            }
        }
    }
    Cow::Owned(out)
}

/// Iterates over statements: their line's number, its text, and its words before a comment.
fn statements(bytes: &[u8]) -> impl Iterator<Item = (usize, &[u8], &[u8])> {
    text::lines(bytes).map(|(number, line)| {
        let statement = line.split(|&b| b == b'#').next().unwrap_or_default();
        (number, line, statement)
    })
}

/// Returns the index of a vertex in a corner such as `3`, `3/1`, `3//2` or `-1`. `before` vertices precede it, of `count`.
fn corner(word: &[u8], before: usize, count: usize) -> Option<u32> {
    let index = word.split(|&b| b == b'/').next()?;
    let index: i64 = std::str::from_utf8(index).ok()?.parse().ok()?;
    let index = match index {
        1.. => index - 1,
        0 => return None,
        _ => i64::try_from(before).ok()? + index,
    };
    let index = u32::try_from(index).ok()?;
    ((index as usize) < count).then_some(index)
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, ReadFault> {
    let bytes = joined(text::checked(bytes)?);
    let mut file = MeshFile::default();
    for (number, line, statement) in statements(&bytes) {
        let mut words = text::words(statement);
        if words.next() == Some(b"v") {
            let place = text::point(&mut words).ok_or_else(|| bad_line(number, line))?;
            file.mesh.positions.push(place);
        }
    }
    // A face may name vertices that follow it.
    let count = file.mesh.positions.len();
    let mut before = 0;
    let mut left_out = LeftOut::default();
    let mut polygons = Polygons::default();
    let mut corners = Vec::new();
    for (number, line, statement) in statements(&bytes) {
        let mut words = text::words(statement);
        match words.next() {
            None => {}
            Some(b"v") => before += 1,
            Some(b"f" | b"fo") => {
                corners.clear();
                for word in words {
                    let corner = corner(word, before, count);
                    corners.push(corner.ok_or_else(|| bad_line(number, line))?);
                }
                polygons.add(&corners, &mut file.mesh, number)?;
            }
            Some(word) => left_out.add(number, word, line),
        }
    }
    file.warnings = left_out.warnings();
    file.warnings.extend(polygons.warnings("line"));
    Ok(file)
}
