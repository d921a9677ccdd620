use crate::Mesh;
use argil_math::Aabb;
use rayon::prelude::*;

/// Counts and checks of a mesh.
///
/// ```
/// use argil_mesh::{Mesh, MeshReport};
/// let mut mesh = Mesh::default();
/// mesh.positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Into::into).to_vec();
/// mesh.triangles = vec![[0, 1, 2]];
/// let report = MeshReport::of(&mesh);
/// assert_eq!(report.triangles, 1);
/// assert!(!report.is_watertight());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshReport {
    /// Vertices that triangles use.
    pub vertices: u64,
    /// Number of triangles.
    pub triangles: u64,
    /// Edges between vertices.
    pub edges: u64,
    /// Edges of one triangle.
    pub open_edges: u64,
    /// Edges of three or more triangles.
    pub non_manifold_edges: u64,
    /// Edges that two triangles traverse in the same direction, so that one of them faces the wrong way.
    pub flipped_edges: u64,
    /// Triangles without an area.
    pub degenerate_triangles: u64,
    /// Vertices minus edges plus triangles: 2 for each closed part, minus 2 for each handle.
    pub euler_characteristic: i64,
    /// Area, in the square of the scene's unit.
    pub area: f64,
    /// Enclosed volume, in the cube of the scene's unit. For open meshes, it is the volume of cones from the center
    /// of the box.
    pub volume: f64,
    /// The box.
    pub aabb: Aabb,
}

impl MeshReport {
    /// Checks a mesh.
    ///
    /// # Panics
    /// If a triangle has a vertex that does not exist.
    pub fn of(mesh: &Mesh) -> Self {
        // Each edge as its two vertices, the lower first, and whether it is traversed backward.
        let mut edges: Vec<(u32, u32, bool)> = mesh
            .triangles
            .par_iter()
            .flat_map_iter(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (a.min(b), a.max(b), a > b))
            .collect();
        edges.par_sort_unstable();
        let mut report = Self {
            vertices: used(mesh),
            triangles: mesh.triangles.len() as u64,
            edges: 0,
            open_edges: 0,
            non_manifold_edges: 0,
            flipped_edges: 0,
            degenerate_triangles: 0,
            euler_characteristic: 0,
            area: 0.0,
            volume: 0.0,
            aabb: mesh.aabb(),
        };
        for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            report.edges += 1;
            match edge {
                [_] => report.open_edges += 1,
                [a, b] => report.flipped_edges += u64::from(a == b),
                _ => report.non_manifold_edges += 1,
            }
        }
        report.euler_characteristic =
            report.vertices as i64 - report.edges as i64 + report.triangles as i64;
        let middle = report.aabb.center().as_dvec3();
        let sums = |triangle: usize| {
            let [a, b, c] = mesh
                .triangle_vertices(triangle)
                .map(|p| p.as_dvec3() - middle);
            let normal = (b - a).cross(c - a);
            (0.5 * normal.length(), a.dot(b.cross(c)) / 6.0)
        };
        // In ranges of one length, so that sums do not depend on threads.
        let count = mesh.triangles.len();
        let parts: Vec<(f64, f64, u64)> = (0..count.div_ceil(4096))
            .into_par_iter()
            .map(|part| {
                let mut sum = (0.0, 0.0, 0);
                for triangle in part * 4096..((part + 1) * 4096).min(count) {
                    let (area, volume) = sums(triangle);
                    sum.0 += area;
                    sum.1 += volume;
                    sum.2 += u64::from(area == 0.0);
                }
                sum
            })
            .collect();
        for (area, volume, degenerate) in parts {
            report.area += area;
            report.volume += volume;
            report.degenerate_triangles += degenerate;
        }
        report
    }

    /// Whether every edge is between two triangles that agree which side is outside.
    pub fn is_watertight(&self) -> bool {
        self.triangles > 0
            && self.open_edges == 0
            && self.non_manifold_edges == 0
            && self.flipped_edges == 0
    }
}

fn used(mesh: &Mesh) -> u64 {
    let mut used = vec![false; mesh.positions.len()];
    for &i in mesh.triangles.iter().flatten() {
        used[i as usize] = true;
    }
    used.iter().filter(|&&used| used).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn tetrahedron() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_tetrahedron_is_closed() {
        let report = MeshReport::of(&tetrahedron());
        assert!(report.is_watertight());
        assert_eq!((report.edges, report.euler_characteristic), (6, 2));
        assert!(
            (report.volume - 1.0 / 6.0).abs() < 1e-12,
            "{}",
            report.volume
        );
        assert!((report.area - 1.5 - 0.75f64.sqrt()).abs() < 1e-7);
    }

    #[test]
    fn what_is_wrong_is_told() {
        let mut open = tetrahedron();
        open.triangles.pop();
        let report = MeshReport::of(&open);
        assert_eq!((report.open_edges, report.is_watertight()), (3, false));

        let mut flipped = tetrahedron();
        flipped.triangles[3] = [1, 3, 2];
        assert_eq!(MeshReport::of(&flipped).flipped_edges, 3);

        let mut fin = tetrahedron();
        fin.positions.push(Vec3::ONE);
        fin.triangles.push([0, 1, 4]);
        let report = MeshReport::of(&fin);
        assert_eq!((report.non_manifold_edges, report.open_edges), (1, 2));

        let mut flat = tetrahedron();
        flat.triangles.push([1, 1, 1]);
        assert_eq!(MeshReport::of(&flat).degenerate_triangles, 1);
        assert!(!MeshReport::of(&Mesh::default()).is_watertight());
    }
}
