//! Stereolithography: triangles as text or as records of 50 bytes. Normals are not read, because the order of the vertices
//! gives them.

use super::error::ReadFault;
use super::file::MeshFile;
use super::polygon::Polygons;
use super::text;
use crate::Mesh;
use glam::Vec3;

/// Bytes before the number of triangles.
const HEADER: usize = 80;
/// Bytes of a triangle: a normal, three vertices and a word.
const TRIANGLE: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, ReadFault> {
    if block(bytes).is_some_and(|block| block.rest.is_empty()) {
        return Ok(binary(bytes));
    }
    if is_text(bytes) {
        return ascii(bytes);
    }
    if let Some(block) = block(bytes) {
        // Some programs write the number of triangles last, and never do.
        let left = block.rest.len();
        let is_uncounted = block.records.is_empty() && left > 0 && left % TRIANGLE == 0;
        return match is_uncounted {
            true => Ok(uncounted(block.rest)),
            false => Ok(binary(bytes)),
        };
    }
    Err(match bytes.get(HEADER..HEADER + 4) {
        Some(count) => ReadFault::Damaged(format!(
            "it is truncated: it announces {} triangles, and has bytes for {}",
            u32::from_le_bytes(count.try_into().unwrap_or_default()),
            (bytes.len() - HEADER - 4) / TRIANGLE
        )),
        None => "neither text nor binary: it is truncated".into(),
    })
}

/// A header and its triangles, and the bytes after them.
struct Block<'a> {
    records: &'a [[u8; TRIANGLE]],
    rest: &'a [u8],
}

fn block(bytes: &[u8]) -> Option<Block<'_>> {
    let (_, bytes) = bytes.split_at_checked(HEADER)?;
    let (count, bytes) = bytes.split_first_chunk()?;
    let count = usize::try_from(u32::from_le_bytes(*count)).ok()?;
    let (records, rest) = bytes.split_at_checked(count.checked_mul(TRIANGLE)?)?;
    let (records, _) = records.as_chunks();
    Some(Block { records, rest })
}

/// Adds the triangles of binary records.
fn add(records: &[[u8; TRIANGLE]], mesh: &mut Mesh) {
    mesh.positions.reserve(3 * records.len());
    mesh.triangles.reserve(records.len());
    for record in records {
        let first = mesh.positions.len() as u32;
        let (numbers, _) = record[12..48].as_chunks::<4>();
        let numbers: [f32; 9] = std::array::from_fn(|i| f32::from_le_bytes(numbers[i]));
        let (corners, _) = numbers.as_chunks::<3>();
        mesh.positions
            .extend(corners.iter().map(|&p| Vec3::from(p)));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
}

/// Reads one or more binary files that follow each other.
fn binary(bytes: &[u8]) -> MeshFile {
    let mut file = MeshFile::default();
    let mut rest = bytes;
    while let Some(block) = block(rest) {
        add(block.records, &mut file.mesh);
        rest = block.rest;
    }
    if !rest.is_empty() {
        let count = rest.len();
        file.warnings.push(format!(
            "left out {count} bytes after the last triangle: they are not triangles"
        ));
    }
    file
}

fn uncounted(records: &[u8]) -> MeshFile {
    let mut file = MeshFile::default();
    add(records.as_chunks().0, &mut file.mesh);
    file.warnings.push(format!(
        "its header announces no triangle, and {} follow: they are read",
        file.mesh.triangles.len()
    ));
    file
}

fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    line.starts_with(b";") || line.starts_with(b"#") || line.starts_with(b"//")
}

/// Whether the first line that is neither empty nor a comment begins as text does. A binary file that begins so has zeros.
fn is_text(bytes: &[u8]) -> bool {
    if bytes.contains(&0) && block(bytes).is_some() {
        return false;
    }
    let mut lines = text::lines(text::without_mark(bytes)).map(|(_, line)| line);
    let first = lines.find(|line| !line.trim_ascii().is_empty() && !is_comment(line));
    let word = first.and_then(|line| text::words(line).next());
    bytes.starts_with(&[0xff, 0xfe])
        || bytes.starts_with(&[0xfe, 0xff])
        || word.is_some_and(|word| {
            word.eq_ignore_ascii_case(b"solid") || word.eq_ignore_ascii_case(b"facet")
        })
}

/// Returns what follows a solid's name in its line: some programs write all in one.
fn after_name(line: &[u8]) -> &[u8] {
    let mut facet = None;
    for word in text::words(line).skip(1) {
        if let Some(at) = facet.filter(|_| word.eq_ignore_ascii_case(b"normal")) {
            return &line[at..];
        }
        let at = word.as_ptr() as usize - line.as_ptr() as usize;
        facet = word.eq_ignore_ascii_case(b"facet").then_some(at);
    }
    &[]
}

fn ascii(bytes: &[u8]) -> Result<MeshFile, ReadFault> {
    let mut file = MeshFile::default();
    let mut polygons = Polygons::default();
    let mut corners: Vec<u32> = Vec::new();
    let mut is_open = false;
    let mut is_in_facet = false;
    for (number, line) in text::lines(text::checked(bytes)?) {
        if is_comment(line) {
            continue;
        }
        let mut rest = line;
        let first = text::words(line).next().unwrap_or_default();
        if first.eq_ignore_ascii_case(b"solid") || first.eq_ignore_ascii_case(b"endsolid") {
            is_open = first.eq_ignore_ascii_case(b"solid");
            rest = after_name(line.trim_ascii_start());
        }
        let mut words = text::words(rest);
        while let Some(word) = words.next() {
            if word.eq_ignore_ascii_case(b"vertex") {
                let place = text::point(&mut words).ok_or_else(|| text::bad_line(number, line))?;
                corners.push(file.mesh.positions.len() as u32);
                file.mesh.positions.push(place);
            } else if word.eq_ignore_ascii_case(b"endloop") {
                if corners.len() < 3 {
                    return Err(ReadFault::Damaged(format!(
                        "line {number}: the facet has {} vertices",
                        corners.len()
                    )));
                }
                polygons.add(&corners, &mut file.mesh, number)?;
                corners.clear();
            } else if word.eq_ignore_ascii_case(b"facet") {
                is_in_facet = true;
            } else if word.eq_ignore_ascii_case(b"endfacet") {
                is_in_facet = false;
            } else if word.eq_ignore_ascii_case(b"endsolid") {
                is_open = false;
                break;
            }
        }
    }
    if is_in_facet || !corners.is_empty() {
        return Err("unexpected end of file: it is truncated".into());
    }
    if is_open && !file.mesh.triangles.is_empty() {
        file.warnings
            .push("its last solid has no end: check that the file is whole".into());
    }
    file.warnings.extend(polygons.warnings("line"));
    Ok(file)
}
