use super::srgb::srgb;
use crate::Mesh;
use std::io::{self, Write};

pub(super) fn write(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment Argil")?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    for axis in ["x", "y", "z"] {
        writeln!(out, "property float {axis}")?;
    }
    if !mesh.normals.is_empty() {
        for axis in ["nx", "ny", "nz"] {
            writeln!(out, "property float {axis}")?;
        }
    }
    if !mesh.materials.is_empty() {
        for color in ["red", "green", "blue"] {
            writeln!(out, "property uchar {color}")?;
        }
    }
    writeln!(out, "element face {}", mesh.triangles.len())?;
    writeln!(out, "property list uchar int vertex_indices\nend_header")?;
    for (i, p) in mesh.positions.iter().enumerate() {
        let numbers = p.to_array().into_iter();
        let normal = mesh.normals.get(i).map(|n| n.to_array());
        for number in numbers.chain(normal.into_iter().flatten()) {
            out.write_all(&number.to_le_bytes())?;
        }
        if let Some(material) = mesh.materials.get(i) {
            let [r, g, b, _] = material.base_roughness;
            out.write_all(&[r, g, b].map(srgb))?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        for i in triangle {
            out.write_all(&i.to_le_bytes())?;
        }
    }
    Ok(())
}
