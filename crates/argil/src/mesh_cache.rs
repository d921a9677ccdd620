//! Caches the samples of meshes in files.

use crate::cache_folder;
use crate::mesh_facts::MeshFacts;
use argil_math::Aabb;
use argil_mesh::{MeshSource, RepairReport};
use argil_scene::{SAMPLED_HEADER, SampledGrid};
use std::path::{Path, PathBuf};

/// First bytes of a cache file. The number changes with the way of reading and of sampling.
const MAGIC: [u8; 8] = *b"argilm06";

/// Words before the samples in a cache file: the box.
const HEAD: usize = 6;

/// Extension of cache files.
const MAGIC_TEXT: &str = "grid06";

/// Returns the path of a mesh's cache file, named by the hash of the bytes of the mesh file and of those that it names.
pub(crate) fn place(source: &MeshSource<'_>, resolution: u32) -> Option<PathBuf> {
    let mut hasher = blake3::Hasher::new();
    for bytes in source.parts() {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    }
    let hash = hasher.finalize().to_hex();
    let format = source.format();
    let name = format!("{hash}-{format:?}-{resolution}.{MAGIC_TEXT}");
    Some(cache_folder()?.join("meshes").join(name))
}

/// Writes samples, with what is known of their mesh file.
pub(crate) fn write(path: &Path, grid: &SampledGrid, facts: &MeshFacts) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let mut words: Vec<f32> = Vec::with_capacity(HEAD + grid.words().len());
    let solid = grid.solid();
    words.extend(solid.min.to_array());
    words.extend(solid.max.to_array());
    words.extend_from_slice(grid.words());
    let bytes: &[u8] = bytemuck::cast_slice(&words);
    let warnings = facts.file_warnings.join("\n");
    let head = [
        &facts.triangles.to_le_bytes(),
        bytemuck::bytes_of(&facts.repairs),
        &(warnings.len() as u64).to_le_bytes(),
        warnings.as_bytes(),
    ]
    .concat();
    argil_scene::write_atomically(path, |out| {
        use std::io::Write;
        out.write_all(&MAGIC)?;
        out.write_all(hash_of(&head, bytes).as_bytes())?;
        out.write_all(&head)?;
        out.write_all(bytes)
    })
}

/// Hashes a cache file's head and samples.
fn hash_of(head: &[u8], bytes: &[u8]) -> blake3::Hash {
    blake3::Hasher::new().update(head).update(bytes).finalize()
}

/// Reads a cache file. Returns `None` if it is missing or damaged.
pub(crate) fn read(path: &Path) -> Option<(SampledGrid, MeshFacts)> {
    let all = std::fs::read(path).ok()?;
    let (magic, rest) = all.split_at_checked(MAGIC.len())?;
    let (hash, rest) = rest.split_at_checked(32)?;
    if magic != MAGIC || blake3::hash(rest).as_bytes() != hash {
        return None;
    }
    let (triangles, rest) = rest.split_first_chunk()?;
    let (repairs, rest) = rest.split_at_checked(size_of::<RepairReport>())?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    let (warnings, bytes) = rest.split_at_checked(length)?;
    let warnings = std::str::from_utf8(warnings).ok()?;
    let words: Vec<f32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .map(|&b| f32::from_le_bytes(b))
        .collect();
    if words.len() < HEAD + SAMPLED_HEADER {
        return None;
    }
    let corner = |at: usize| glam::Vec3::from_slice(&words[at..]);
    let solid = Aabb::new(corner(0), corner(3));
    let facts = MeshFacts {
        triangles: u64::from_le_bytes(*triangles),
        repairs: bytemuck::pod_read_unaligned(repairs),
        file_warnings: warnings.lines().map(str::to_owned).collect(),
    };
    let grid = SampledGrid::from_words(words[HEAD..].to_vec(), solid)?;
    Some((grid, facts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_comes_back_whole_or_not_at_all() {
        let here = tempfile::tempdir().expect("a folder");
        let path = here.path().join("sub").join("kept");
        let ball = |points: &[glam::Vec3], out: &mut [f32]| {
            for (p, out) in points.iter().zip(out) {
                *out = p.length() - 0.5;
            }
        };
        let solid = Aabb::centered(glam::Vec3::splat(0.5));
        let corner = glam::Vec3::splat(-0.75);
        let grid = SampledGrid::sample(corner, 0.5, glam::UVec3::splat(3), solid, &ball);
        let repairs = RepairReport {
            holes: 3,
            parts: 1,
            ..RepairReport::default()
        };
        let facts = MeshFacts {
            triangles: 77,
            repairs,
            file_warnings: vec!["left out 2 lines".into(), "and a point".into()],
        };
        write(&path, &grid, &facts).expect("a file");
        assert_eq!(read(&path), Some((grid, facts)));
        let whole = std::fs::read(&path).expect("a file");
        for at in (0..whole.len()).step_by(whole.len() / 50) {
            let mut damaged = whole.clone();
            damaged[at] ^= 1;
            std::fs::write(&path, &damaged).expect("a file");
            assert_eq!(read(&path), None, "{at}");
            std::fs::write(&path, &whole[..at]).expect("a file");
            assert_eq!(read(&path), None, "cut at {at}");
        }
    }

    /// A file of samples must not outlive a buffer that lies beside its mesh file.
    #[test]
    fn names_follow_all_files_of_a_mesh() {
        use argil_mesh::MeshFormat;
        let json = br#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "a.bin"}]}"#;
        let name = |buffer: &[u8]| {
            let source = MeshSource::new(&json[..], MeshFormat::Gltf, Path::new("a.gltf"));
            let source = source.with_files(|_| Ok(buffer.to_vec())).expect("files");
            place(&source, 64)
        };
        assert_eq!(name(b"abc"), name(b"abc"));
        assert_ne!(name(b"abc"), name(b"abc2"));
    }
}
