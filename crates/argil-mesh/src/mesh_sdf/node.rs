//! A node of a tree of triangles.

use argil_math::Aabb;
use glam::{DVec3, Vec3};

/// A node: the box of its triangles, and what stands for them from afar.
#[derive(Clone, Debug)]
pub(super) struct BvhNode {
    pub(super) low: Vec3,
    pub(super) high: Vec3,
    /// The first of two children, or a leaf.
    pub(super) first: u32,
    pub(super) is_leaf: bool,
    /// The position and the area of its plate, and the radius of its triangles around it.
    pub(super) middle: Vec3,
    pub(super) plate: Vec3,
    pub(super) radius: f32,
    /// The plate's direction, and between which values its triangles lie along it, from the position.
    pub(super) normal: Vec3,
    pub(super) along: [f32; 2],
}

impl BvhNode {
    /// A node that is not summed up yet.
    pub(super) fn placeholder() -> Self {
        Self::of(&[])
    }

    /// Sums up triangles.
    pub(super) fn of(triangles: &[[Vec3; 3]]) -> Self {
        let bounds = Aabb::around(triangles.iter().flatten().copied());
        let (mut area, mut middle, mut plate) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for corners in triangles {
            let [a, b, c] = corners.map(|p| p.as_dvec3());
            let normal = 0.5 * (b - a).cross(c - a);
            let own = normal.length();
            area += own;
            middle += own * (a + b + c) / 3.0;
            plate += normal;
        }
        let middle = (middle / area.max(f64::MIN_POSITIVE)).as_vec3();
        let reach = |p: &Vec3| p.distance(middle);
        let normal = plate.normalize_or_zero().as_vec3();
        let mut along = [f32::INFINITY, f32::NEG_INFINITY];
        for p in triangles.iter().flatten() {
            let at = (*p - middle).dot(normal);
            along = [along[0].min(at), along[1].max(at)];
        }
        Self {
            low: bounds.min,
            high: bounds.max,
            first: 0,
            is_leaf: false,
            middle,
            plate: plate.as_vec3(),
            radius: triangles.iter().flatten().map(reach).fold(0.0, f32::max),
            normal,
            along,
        }
    }
}
