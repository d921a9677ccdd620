//! Axes and units of files.

use crate::Mesh;
use glam::Vec3;

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

pub(super) fn turned(mesh: &Mesh, options: &MeshWriteOptions) -> Mesh {
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
