//! Writes mesh files.
//!
//! *Practice.* Meshes in memory are right-handed with y up, like glTF. Other files can have other axes and another
//! unit. GLB always follows its specification: y up, right-handed, in meters. 3MF is right-handed with z up.

#[cfg(feature = "files")]
mod glb;
mod obj;
mod options;
mod ply;
mod srgb;
mod stl;
#[cfg(feature = "files")]
mod three_mf;

use crate::{Mesh, MeshFormat};
use options::turned;
pub use options::{MeshWriteOptions, UpAxis};
use std::io::{self, Write};
#[cfg(feature = "files")]
pub use three_mf::{ThreeMfMetadata, write_3mf};

/// Writes a mesh.
///
/// # Errors
/// If `out` fails, or the format cannot hold the mesh.
pub fn write(
    mesh: &Mesh,
    format: MeshFormat,
    options: &MeshWriteOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    let turned = turned(mesh, options);
    let mut out = io::BufWriter::with_capacity(1 << 20, out);
    match format {
        #[cfg(feature = "files")]
        MeshFormat::Glb => glb::write(&turned, &mut out)?,
        #[cfg(feature = "files")]
        MeshFormat::Gltf => glb::write_text(&turned, &mut out)?,
        #[cfg(feature = "files")]
        MeshFormat::ThreeMf => three_mf::write(mesh, options, &mut out)?,
        #[cfg(not(feature = "files"))]
        MeshFormat::Glb | MeshFormat::Gltf | MeshFormat::ThreeMf => {
            return Err(std::io::Error::other(
                "this program was compiled without mesh files (the feature `mesh-files`)",
            ));
        }
        MeshFormat::Obj => obj::write(&turned, &mut out)?,
        MeshFormat::Ply => ply::write(&turned, &mut out)?,
        MeshFormat::Stl => stl::write(&turned, &mut out)?,
    }
    out.flush()
}
