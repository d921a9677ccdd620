use super::srgb::srgb_fraction;
use crate::Mesh;
use std::io::{self, Write};

pub(super) fn write(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    writeln!(
        out,
        "# Argil: {} vertices, {} triangles",
        mesh.positions.len(),
        mesh.triangles.len()
    )?;
    for (i, p) in mesh.positions.iter().enumerate() {
        write!(out, "v {} {} {}", p.x, p.y, p.z)?;
        if let Some(material) = mesh.materials.get(i) {
            let [r, g, b, _] = material.base_roughness.map(srgb_fraction);
            write!(out, " {r:.4} {g:.4} {b:.4}")?;
        }
        writeln!(out)?;
    }
    for n in &mesh.normals {
        writeln!(out, "vn {:.5} {:.5} {:.5}", n.x, n.y, n.z)?;
    }
    let has_normals = !mesh.normals.is_empty();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| i + 1);
        if has_normals {
            writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
        } else {
            writeln!(out, "f {a} {b} {c}")?;
        }
    }
    Ok(())
}
