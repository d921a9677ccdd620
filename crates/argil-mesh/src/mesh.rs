use argil_abi::GpuMaterial;
use argil_math::Aabb;
use glam::Vec3;

/// Triangles, counterclockwise as seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners.
    pub positions: Vec<Vec3>,
    /// A unit normal for each corner, or none.
    pub normals: Vec<Vec3>,
    /// A material for each corner, or none.
    pub materials: Vec<GpuMaterial>,
    /// The corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The box of all corners; empty without any.
    pub fn aabb(&self) -> Aabb {
        Aabb::around(self.positions.iter().copied())
    }

    /// A triangle's corners.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn triangle_vertices(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|i| self.positions[i as usize])
    }

    /// Bytes of everything.
    pub fn memory_bytes(&self) -> u64 {
        (size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.materials[..])
            + size_of_val(&self.triangles[..])) as u64
    }

    /// Some triangles, with the corners that they use.
    ///
    /// # Panics
    /// If one has a corner that there is not.
    pub fn submesh(&self, triangles: &[[u32; 3]]) -> Self {
        let mut place = vec![u32::MAX; self.positions.len()];
        let mut own = Self::default();
        for triangle in triangles {
            own.triangles.push(triangle.map(|i| {
                let i = i as usize;
                if place[i] == u32::MAX {
                    place[i] = own.positions.len() as u32;
                    own.positions.push(self.positions[i]);
                    own.normals.extend(self.normals.get(i));
                    own.materials.extend(self.materials.get(i));
                }
                place[i]
            }));
        }
        own
    }

    /// The same triangles with three corners each that are theirs alone; with the faces' own normals, the 2023 study's true
    /// ones, if asked for. Triangles without an area get a zero normal.
    pub fn unindexed(&self, face_normals: bool) -> Self {
        let of = |i: u32| self.positions[i as usize];
        let mut out = Self::default();
        for (nth, triangle) in (0..).zip(&self.triangles) {
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
            out.triangles.push([3 * nth, 3 * nth + 1, 3 * nth + 2]);
        }
        out
    }
}
