use crate::Mesh;
use std::io::{self, Write};

pub(super) fn write(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    let mut head = [0; 80];
    head[..5].copy_from_slice(b"Argil");
    out.write_all(&head)?;
    out.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for i in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.triangle_vertices(i);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for number in [normal, a, b, c].iter().flat_map(|v| v.to_array()) {
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(&[0; 2])?;
    }
    Ok(())
}
