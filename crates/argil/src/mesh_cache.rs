//! Caches the samples of meshes in files.

use crate::cache_folder;
use argil_math::Aabb;
use argil_mesh::{MeshFormat, RepairReport};
use argil_scene::{SAMPLED_HEADER, SampledGrid};
use std::path::{Path, PathBuf};

/// First bytes of a cache file. The number changes with the way of sampling.
const MAGIC: [u8; 8] = *b"argilm04";

/// Words before the samples in a cache file: the box.
const HEAD: usize = 6;

/// Extension of cache files.
const MAGIC_TEXT: &str = "grid04";

/// Returns the path of a mesh's cache file, named by the hash of the mesh file's bytes.
pub(crate) fn place(bytes: &[u8], format: MeshFormat, resolution: u32) -> Option<PathBuf> {
    let hash = blake3::hash(bytes).to_hex();
    let name = format!("{hash}-{format:?}-{resolution}.{MAGIC_TEXT}");
    Some(cache_folder()?.join("meshes").join(name))
}

/// Writes samples, with the number of triangles and the repairs.
pub(crate) fn write(
    path: &Path,
    grid: &SampledGrid,
    (triangles, repairs): (u64, RepairReport),
) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let mut words: Vec<f32> = Vec::with_capacity(HEAD + grid.words().len());
    let solid = grid.solid();
    words.extend(solid.min.to_array());
    words.extend(solid.max.to_array());
    words.extend_from_slice(grid.words());
    let bytes: &[u8] = bytemuck::cast_slice(&words);
    let head = [&triangles.to_le_bytes(), bytemuck::bytes_of(&repairs)].concat();
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
pub(crate) fn read(path: &Path) -> Option<(SampledGrid, (u64, RepairReport))> {
    let all = std::fs::read(path).ok()?;
    let (magic, rest) = all.split_at_checked(MAGIC.len())?;
    let (hash, rest) = rest.split_at_checked(32)?;
    let (head, bytes) = rest.split_at_checked(8 + size_of::<RepairReport>())?;
    if magic != MAGIC || hash_of(head, bytes).as_bytes() != hash {
        return None;
    }
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
    let (triangles, repairs) = head.split_first_chunk()?;
    let counts = (
        u64::from_le_bytes(*triangles),
        bytemuck::pod_read_unaligned(repairs),
    );
    Some((
        SampledGrid::from_words(words[HEAD..].to_vec(), solid)?,
        counts,
    ))
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
        write(&path, &grid, (77, repairs)).expect("a file");
        assert_eq!(read(&path), Some((grid, (77, repairs))));
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
}
