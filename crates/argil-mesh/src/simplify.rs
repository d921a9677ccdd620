use crate::Mesh;
#[cfg(all(not(target_arch = "wasm32"), feature = "simplify"))]
use crate::separate_sheets::separate_sheets;

/// Simplifies a mesh to a number of triangles. Returns it with the largest distance between both surfaces, in the
/// scene's unit.
///
/// Edges are collapsed in the order of quadric error (Garland and Heckbert 1997, by meshoptimizer). Remaining
/// vertices keep their normals and materials. A closed mesh stays closed and manifold: where two sheets come to share
/// an edge or a vertex, each gets one of its own, at the same place. There can be more triangles than requested if
/// fewer would open the surface.
///
/// # Errors
/// If there are more vertices than the simplifier can count. In a browser always, because its C++ code is not
/// compiled.
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
    let mut target = triangles;
    loop {
        let mut error = 0.0;
        let left = meshopt::simplify(
            indices,
            &vertices,
            3 * target,
            1.0,
            SimplifyOptions::ErrorAbsolute,
            Some(&mut error),
        );
        let (left, _) = left.as_chunks::<3>();
        let out = separate_sheets(mesh.submesh(left));
        // Sheets that were separated can have more triangles.
        let added = out.triangles.len() - left.len();
        if added == 0 || out.triangles.len() <= triangles || left.len() > target {
            return Ok((out, error));
        }
        target = target.saturating_sub(added);
    }
}
