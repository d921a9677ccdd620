//! Writes mesh files.
//!
//! *Practice.* Meshes in memory are right-handed with y up, like glTF. Other files can have other axes and another
//! unit. GLB always follows its specification: y up, right-handed, in meters. 3MF is right-handed with z up.

#[cfg(feature = "files")]
mod glb;
mod obj;
mod ply;
mod srgb;
mod stl;
#[cfg(feature = "files")]
mod three_mf;

use crate::Mesh;
use glam::Vec3;
use std::io::{self, Write};
#[cfg(feature = "files")]
pub use three_mf::{ThreeMfMetadata, write_3mf};

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshFormat {
    /// glTF 2.0 in one binary file: normals, metallic–roughness materials, vertex colors.
    Glb,
    /// Wavefront text: normals, and vertex colors after the positions, as many programs read them.
    Obj,
    /// Stanford triangles, binary little-endian: normals, vertex colors.
    Ply,
    /// Stereolithography, binary: triangles only.
    Stl,
    /// 3D Manufacturing Format, for slicers: vertex colors and a unit. z is up.
    ThreeMf,
}

impl MeshFormat {
    /// Returns the format that a file name's extension stands for, whatever its case.
    pub fn from_path(path: &std::path::Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "glb" => Some(Self::Glb),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "3mf" => Some(Self::ThreeMf),
            _ => None,
        }
    }
}

/// The up axis and handedness of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum UpAxis {
    /// y up, right-handed: Argil, glTF, Maya, Godot.
    #[default]
    YUp,
    /// z up, right-handed: Blender, CAD, printers.
    ZUp,
    /// y up, left-handed: Unity, Direct3D.
    YUpLeftHanded,
    /// z up, left-handed: Unreal.
    ZUpLeftHanded,
}

impl UpAxis {
    /// Converts a point or direction to these axes.
    pub fn convert(self, v: Vec3) -> Vec3 {
        match self {
            Self::YUp => v,
            Self::ZUp => Vec3::new(v.x, -v.z, v.y),
            Self::YUpLeftHanded => Vec3::new(v.x, v.y, -v.z),
            Self::ZUpLeftHanded => Vec3::new(v.x, v.z, v.y),
        }
    }

    /// Whether triangles are reversed, so that they are clockwise in a left-handed program.
    pub fn is_left_handed(self) -> bool {
        matches!(self, Self::YUpLeftHanded | Self::ZUpLeftHanded)
    }
}

/// Options of mesh files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshWriteOptions {
    /// The up axis and handedness.
    pub axes: UpAxis,
    /// Factor for all lengths.
    pub scale: f32,
}

impl Default for MeshWriteOptions {
    fn default() -> Self {
        Self {
            axes: UpAxis::default(),
            scale: 1.0,
        }
    }
}

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
        MeshFormat::ThreeMf => three_mf::write(mesh, options, &mut out)?,
        #[cfg(not(feature = "files"))]
        MeshFormat::Glb | MeshFormat::ThreeMf => {
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

fn turned(mesh: &Mesh, options: &MeshWriteOptions) -> Mesh {
    let MeshWriteOptions { axes, scale } = *options;
    let mut out = mesh.clone();
    for p in &mut out.positions {
        *p = scale * axes.convert(*p);
    }
    for n in &mut out.normals {
        *n = axes.convert(*n);
    }
    if axes.is_left_handed() {
        for [_, b, c] in &mut out.triangles {
            std::mem::swap(b, c);
        }
    }
    out
}
