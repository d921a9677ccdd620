use crate::Mesh;

/// A mesh of fewer triangles, and how far its surface may be from the whole one's, in the scene's unit: edges are collapsed in
/// the order of the squared distances to the planes around them (Garland and Heckbert 1997, by meshoptimizer). Corners that are
/// left keep their normals and materials. A closed mesh stays closed, but two sheets of it can come to lie on one edge. There
/// can be more triangles than asked for, where fewer would open the surface.
///
/// # Errors
/// If there are more corners than the simplifier counts; in a browser, for which its C++ is not compiled, always.
pub fn simplify(mesh: &Mesh, triangles: usize) -> Result<(Mesh, f32), String> {
    if mesh.triangles.len() <= triangles {
        return Ok((mesh.clone(), 0.0));
    }
    fewer(mesh, triangles)
}

#[cfg(any(target_arch = "wasm32", not(feature = "simplify")))]
fn fewer(_: &Mesh, _: usize) -> Result<(Mesh, f32), String> {
    Err("triangles are not left out in a browser, or without the feature `simplify`: take a smaller resolution".into())
}

#[cfg(all(not(target_arch = "wasm32"), feature = "simplify"))]
fn fewer(mesh: &Mesh, triangles: usize) -> Result<(Mesh, f32), String> {
    use meshopt::{SimplifyOptions, VertexDataAdapter};
    let indices: &[u32] = bytemuck::cast_slice(&mesh.triangles);
    let places: &[u8] = bytemuck::cast_slice(&mesh.positions);
    let vertices =
        VertexDataAdapter::new(places, size_of::<glam::Vec3>(), 0).map_err(|e| e.to_string())?;
    let mut error = 0.0;
    let left = meshopt::simplify(
        indices,
        &vertices,
        3 * triangles,
        1.0,
        SimplifyOptions::ErrorAbsolute,
        Some(&mut error),
    );
    let (left, _) = left.as_chunks::<3>();
    Ok((mesh.submesh(left), error))
}
