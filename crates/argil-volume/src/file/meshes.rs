//! The meshes of a volume's scene. Their samples are stored, so that a volume file is complete by itself.
//!
//! ```text
//!   of each mesh: bytes of its path  resolution  the box around it, 6 numbers  words, 8 bytes  path  words
//! ```
//!
//! A path is padded with zeros to a multiple of 4 bytes.

use argil_math::Aabb;
use glam::Vec3;
use std::borrow::Cow;

/// A sampled mesh of a volume's scene.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredMesh<'a> {
    /// Path in the scene.
    pub path: Cow<'a, str>,
    /// Samples along its longest side.
    pub resolution: u32,
    /// The box of the solid.
    pub solid: Aabb,
    /// Its samples, as the words of `SampledGrid` in `argil-scene`.
    pub words: Cow<'a, [f32]>,
}

/// Bytes before a path.
const HEAD_BYTES: usize = 40;

pub(super) fn bytes_of(meshes: &[StoredMesh<'_>]) -> Vec<u8> {
    let mut out = Vec::new();
    for mesh in meshes {
        out.extend((mesh.path.len() as u32).to_le_bytes());
        out.extend(mesh.resolution.to_le_bytes());
        let corners = [mesh.solid.min, mesh.solid.max].map(|corner| corner.to_array());
        let corners = corners.as_flattened().iter();
        out.extend(corners.flat_map(|v| v.to_le_bytes()));
        out.extend((mesh.words.len() as u64).to_le_bytes());
        out.extend(mesh.path.as_bytes());
        out.resize(out.len().next_multiple_of(4), 0);
        out.extend_from_slice(bytemuck::cast_slice(&mesh.words));
    }
    out
}

/// Reads meshes. Returns `None` if the bytes are not valid.
pub(super) fn meshes_of(mut bytes: &[u8]) -> Option<Vec<StoredMesh<'static>>> {
    let number = |four: &[u8]| Some(u32::from_le_bytes(four.try_into().ok()?));
    let mut meshes = Vec::new();
    while !bytes.is_empty() {
        let (head, rest) = bytes.split_at_checked(HEAD_BYTES)?;
        let mut box_words = head[8..32].chunks_exact(4);
        let mut next = || Some(f32::from_bits(number(box_words.next()?)?));
        let mut corner = || Some(Vec3::new(next()?, next()?, next()?));
        let solid = Aabb::new(corner()?, corner()?);
        let count = u64::from_le_bytes(head[32..].try_into().ok()?);
        let path_bytes = number(&head[..4])? as usize;
        let (path, rest) = rest.split_at_checked(path_bytes.checked_next_multiple_of(4)?)?;
        let words = usize::try_from(count).ok()?.checked_mul(4)?;
        let (words, rest) = rest.split_at_checked(words)?;
        let words = words.as_chunks::<4>().0.iter();
        meshes.push(StoredMesh {
            path: String::from_utf8(path[..path_bytes].to_vec()).ok()?.into(),
            resolution: number(&head[4..8])?,
            solid,
            words: words.map(|&word| f32::from_le_bytes(word)).collect(),
        });
        bytes = rest;
    }
    Some(meshes)
}
