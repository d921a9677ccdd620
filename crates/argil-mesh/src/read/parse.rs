//! Parses the bytes of a mesh file.

use super::error::{MAX_TRIANGLES, ReadFault};
use super::file::MeshFile;
#[cfg(feature = "files")]
use super::{gltf, obj, ply, stl, three_mf};
use crate::MeshFormat;

/// Reads the triangles of a file in memory, and checks what no format promises.
pub(super) fn parse(
    bytes: &[u8],
    format: MeshFormat,
    files: &[(String, Vec<u8>)],
) -> Result<MeshFile, ReadFault> {
    let mut file = parsed(bytes, format, files)?;
    let mesh = &mut file.mesh;
    let count = mesh.triangles.len();
    if count > MAX_TRIANGLES {
        let what = format!("{count} triangles, and {MAX_TRIANGLES} can be read");
        return Err(ReadFault::TooLarge(what));
    }
    let vertices = mesh.positions.len() as u32;
    if mesh.triangles.iter().flatten().any(|&i| i >= vertices) {
        return Err("a triangle refers to a missing vertex".into());
    }
    if count == 0 && !file.warnings.is_empty() {
        let what = format!("no triangle is left: {}", file.warnings.join("; "));
        return Err(ReadFault::Unsupported(what));
    }
    // Points, lines and lattices have vertices, too.
    let mut is_used = vec![false; mesh.positions.len()];
    for &i in mesh.triangles.iter().flatten() {
        is_used[i as usize] = true;
    }
    if is_used.contains(&false) {
        *mesh = mesh.submesh(&mesh.triangles);
    }
    Ok(file)
}

#[cfg(feature = "files")]
fn parsed(
    bytes: &[u8],
    format: MeshFormat,
    files: &[(String, Vec<u8>)],
) -> Result<MeshFile, ReadFault> {
    match format {
        MeshFormat::Obj => obj::read(bytes),
        MeshFormat::Glb | MeshFormat::Gltf => gltf::read(bytes, files),
        MeshFormat::Ply => ply::read(bytes),
        MeshFormat::Stl => stl::read(bytes),
        MeshFormat::ThreeMf => three_mf::read(bytes),
    }
}

#[cfg(not(feature = "files"))]
fn parsed(_: &[u8], _: MeshFormat, _: &[(String, Vec<u8>)]) -> Result<MeshFile, ReadFault> {
    let reason = "this program was compiled without mesh files (the feature `mesh-files`)";
    Err(ReadFault::Unsupported(reason.into()))
}
