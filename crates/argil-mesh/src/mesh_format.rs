//! The formats of mesh files.

use std::path::Path;

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshFormat {
    /// glTF 2.0 in one binary file: normals, metallic–roughness materials, vertex colors.
    Glb,
    /// glTF 2.0 as JSON. When it is read, buffers may lie beside it; when it is written, it holds them itself.
    Gltf,
    /// Wavefront text: normals, and vertex colors in sRGB after the positions, as many programs read them.
    Obj,
    /// Stanford triangles, binary little-endian: normals, vertex colors.
    Ply,
    /// Stereolithography, binary: triangles only.
    Stl,
    /// 3D Manufacturing Format, for slicers: vertex colors and a unit. z is up.
    ThreeMf,
}

/// A row of the table of formats.
struct Row {
    format: MeshFormat,
    extension: &'static str,
    name: &'static str,
}

const TABLE: [Row; 6] = [
    row(MeshFormat::Glb, "glb", "GLB"),
    row(MeshFormat::Gltf, "gltf", "glTF"),
    row(MeshFormat::Obj, "obj", "OBJ"),
    row(MeshFormat::Ply, "ply", "PLY"),
    row(MeshFormat::Stl, "stl", "STL"),
    row(MeshFormat::ThreeMf, "3mf", "3MF"),
];

const fn row(format: MeshFormat, extension: &'static str, name: &'static str) -> Row {
    Row {
        format,
        extension,
        name,
    }
}

impl MeshFormat {
    /// Iterates over all formats. Each can be read and written.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.format)
    }

    /// Returns the format that a file name's extension stands for, whatever its case.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        let mut rows = TABLE.iter();
        let row = rows.find(|row| row.extension.eq_ignore_ascii_case(extension));
        row.map(|row| row.format)
    }

    fn row(self) -> &'static Row {
        let entry = TABLE.iter().find(|row| row.format == self);
        entry.unwrap_or(&TABLE[0])
    }

    /// Returns the extension of its files, without a dot.
    pub fn extension(self) -> &'static str {
        self.row().extension
    }

    /// Returns its usual name.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Whether the format prescribes y up, right-handed, in meters.
    pub fn is_gltf(self) -> bool {
        matches!(self, Self::Glb | Self::Gltf)
    }

    /// Whether the format prescribes which axis points up, so that meshes are turned to y up when they are read, and from
    /// it when they are written.
    pub fn is_turned(self) -> bool {
        self.is_gltf() || self == Self::ThreeMf
    }

    /// Lists all extensions, for messages.
    ///
    /// ```
    /// use argil_mesh::MeshFormat;
    /// assert_eq!(MeshFormat::extensions("or"), ".glb, .gltf, .obj, .ply, .stl or .3mf");
    /// ```
    pub fn extensions(conjunction: &str) -> String {
        let [rest @ .., last] = TABLE.map(|row| format!(".{}", row.extension));
        format!("{} {conjunction} {last}", rest.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_format_has_a_row_and_an_extension() {
        for format in MeshFormat::all() {
            assert_eq!(format.row().format, format);
            let name = format!("a.{}", format.extension().to_uppercase());
            assert_eq!(MeshFormat::from_path(Path::new(&name)), Some(format));
        }
        assert_eq!(MeshFormat::from_path(Path::new("a.fbx")), None);
    }
}
