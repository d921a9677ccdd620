//! glTF 2.0, as one binary file or as JSON with buffers beside it.
//!
//! *Practice.* Only what describes triangles is parsed, and only where a scene uses it. A primitive's vertices are those
//! that its triangles use, once per node, so that shared accessors are not copied whole.

mod data;
mod extensions;
mod json;
mod meshopt;
mod scene;

use super::error::ReadFault;
use super::file::MeshFile;
use data::Data;
use json::{BufferJson, Head, Root, element};

/// The parts of a file.
struct Parts<'a> {
    json: &'a [u8],
    chunk: Option<&'a [u8]>,
}

/// Splits a binary file into its chunks. Text is JSON.
fn parts(bytes: &[u8]) -> Result<Parts<'_>, ReadFault> {
    if !bytes.starts_with(b"glTF") {
        let json = super::text::checked(bytes)?;
        if json.trim_ascii_start().first() != Some(&b'{') {
            return Err("it is neither binary glTF nor JSON".into());
        }
        return Ok(Parts { json, chunk: None });
    }
    let word = |at: usize| {
        let word = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
        word.map(u32::from_le_bytes)
            .ok_or_else(|| ReadFault::from("its header is truncated"))
    };
    let version = word(4)?;
    if version != 2 {
        return Err(other_version(&version.to_string()));
    }
    let mut json = None;
    let mut chunk = None;
    let mut at = 12;
    while at + 8 <= bytes.len() && (json.is_none() || chunk.is_none()) {
        let (length, kind) = (word(at)? as usize, word(at + 4)?);
        let content = bytes.get(at + 8..).and_then(|rest| rest.get(..length));
        let content = content.ok_or_else(|| {
            format!(
                "it is truncated: a chunk of {length} bytes begins at byte {at} of {}",
                bytes.len()
            )
        })?;
        match &kind.to_le_bytes() {
            b"JSON" => json = Some(content),
            b"BIN\0" => chunk = Some(content),
            _ => {}
        }
        at += 8 + length;
    }
    let json = json.ok_or("it has no JSON chunk")?;
    Ok(Parts { json, chunk })
}

fn root<'a>(parts: &Parts<'a>) -> Result<Root<'a>, ReadFault> {
    let json = super::text::without_mark(parts.json);
    // Some programs fill the chunk with zeros instead of spaces.
    let end = json
        .iter()
        .rposition(|&b| b != 0)
        .map_or(0, |last| last + 1);
    let fault = |error: serde_json::Error| ReadFault::Damaged(format!("its JSON: {error}"));
    // Version 1 has other lists.
    let head: Head<'_> = serde_json::from_slice(&json[..end]).map_err(fault)?;
    let version = head
        .asset
        .version
        .map_or("2.0", |quoted| quoted.get().trim_matches('"'));
    if !version.starts_with("2.") && version != "2" {
        return Err(other_version(version));
    }
    serde_json::from_slice(&json[..end]).map_err(fault)
}

fn other_version(version: &str) -> ReadFault {
    ReadFault::Unsupported(format!(
        "it is glTF {version}, and version 2 is read: convert it, for example by `gltf-pipeline`"
    ))
}

/// Returns the addresses of the files that have a file's numbers.
pub(super) fn files(bytes: &[u8]) -> Result<Vec<String>, ReadFault> {
    let parts = parts(bytes)?;
    let root = root(&parts)?;
    let mut names = Vec::new();
    for index in 0..root.buffers.len() {
        let buffer: BufferJson = element(&root.buffers, index, "buffer")?;
        names.extend(buffer.uri.filter(|uri| !uri.starts_with("data:")));
    }
    names.sort_unstable();
    names.dedup();
    Ok(names)
}

pub(super) fn read(bytes: &[u8], files: &[(String, Vec<u8>)]) -> Result<MeshFile, ReadFault> {
    let parts = parts(bytes)?;
    let root = root(&parts)?;
    extensions::check(&root.extensions_required)?;
    let size = files.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() + bytes.len();
    scene::read(&root, Data::new(&root, parts.chunk, files, size), size)
}
