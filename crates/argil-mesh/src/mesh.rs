use argil_abi::GpuMaterial;
use argil_math::Aabb;
use glam::Vec3;

/// A triangle mesh, counterclockwise as seen from outside.
///
/// ```
/// use argil_mesh::{Mesh, MeshReport};
/// use glam::Vec3;
/// let mesh = Mesh {
/// positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
/// triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
/// ..Mesh::default()
/// };
/// let report = MeshReport::of(&mesh);
/// assert!(report.is_watertight() && (report.volume - 1.0 / 6.0).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions of vertices.
    pub positions: Vec<Vec3>,
    /// A unit normal per vertex, or none.
    pub normals: Vec<Vec3>,
    /// A material per vertex, or none.
    pub materials: Vec<GpuMaterial>,
    /// The vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Returns the box of all vertices, empty without any.
    pub fn aabb(&self) -> Aabb {
        Aabb::around(self.positions.iter().copied())
    }

    /// Returns the positions of a triangle's vertices.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn triangle_vertices(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|i| self.positions[i as usize])
    }

    /// Returns the bytes of everything.
    pub fn memory_bytes(&self) -> u64 {
        (size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.materials[..])
            + size_of_val(&self.triangles[..])) as u64
    }

    /// Returns some triangles, with the vertices that they use.
    ///
    /// # Panics
    /// If a triangle has a vertex that does not exist.
    pub fn submesh(&self, triangles: &[[u32; 3]]) -> Self {
        let mut place = vec![u32::MAX; self.positions.len()];
        let mut part = Self::default();
        for triangle in triangles {
            part.triangles.push(triangle.map(|i| {
                let i = i as usize;
                if place[i] == u32::MAX {
                    place[i] = part.positions.len() as u32;
                    part.positions.push(self.positions[i]);
                    part.normals.extend(self.normals.get(i));
                    part.materials.extend(self.materials.get(i));
                }
                place[i]
            }));
        }
        part
    }

    /// Returns the triangles with three vertices of their own, and with the faces' own normals if requested: the
    /// 2023 study's true normals. Triangles without an area get a zero normal.
    pub fn unindexed(&self, face_normals: bool) -> Self {
        let of = |i: u32| self.positions[i as usize];
        let mut out = Self::default();
        for (index, triangle) in (0..).zip(&self.triangles) {
            let [a, b, c] = triangle.map(of);
            out.positions.extend([a, b, c]);
            if face_normals {
                out.normals
                    .extend([(b - a).cross(c - a).normalize_or_zero(); 3]);
            } else if !self.normals.is_empty() {
                out.normals
                    .extend(triangle.map(|i| self.normals[i as usize]));
            }
            if !self.materials.is_empty() {
                out.materials
                    .extend(triangle.map(|i| self.materials[i as usize]));
            }
            out.triangles
                .push([3 * index, 3 * index + 1, 3 * index + 2]);
        }
        out
    }
}
