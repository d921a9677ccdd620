//! A node of a tree of triangles or points.

use argil_math::Aabb;
use glam::{DVec3, Vec3};

/// A node: the box of its triangles, and what stands for them from afar.
#[derive(Clone, Debug)]
pub(crate) struct BvhNode {
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
    /// The first of two children, or a leaf.
    pub(crate) first: u32,
    pub(crate) is_leaf: bool,
    /// The position and the area of its plate, and the radius of its triangles around it.
    pub(crate) middle: Vec3,
    pub(crate) plate: Vec3,
    pub(crate) radius: f32,
    /// The plate's direction, and between which values its triangles lie along it, from the position.
    pub(crate) normal: Vec3,
    pub(crate) along: [f32; 2],
}

impl BvhNode {
    /// A node that is not summed up yet.
    pub(crate) fn placeholder() -> Self {
        Self::of(&[])
    }

    /// Sums up triangles.
    pub(crate) fn of(triangles: &[[Vec3; 3]]) -> Self {
        let (mut area, mut middle, mut plate) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for corners in triangles {
            let [a, b, c] = corners.map(|p| p.as_dvec3());
            let normal = 0.5 * (b - a).cross(c - a);
            let double_area = normal.length();
            area += double_area;
            middle += double_area * (a + b + c) / 3.0;
            plate += normal;
        }
        let middle = (middle / area.max(f64::MIN_POSITIVE)).as_vec3();
        Self::around(triangles.iter().flatten().copied(), middle, plate.as_vec3())
    }

    /// Sums up points of a surface, each with a normal.
    pub(crate) fn of_points(points: &[[Vec3; 2]]) -> Self {
        let sum = |i: usize| points.iter().map(|point| point[i]).sum::<Vec3>();
        let middle = sum(0) / points.len().max(1) as f32;
        Self::around(points.iter().map(|point| point[0]), middle, sum(1))
    }

    fn around(points: impl Iterator<Item = Vec3> + Clone, middle: Vec3, plate: Vec3) -> Self {
        let bounds = Aabb::around(points.clone());
        let normal = plate.as_dvec3().normalize_or_zero().as_vec3();
        let (mut along, mut radius) = ([f32::INFINITY, f32::NEG_INFINITY], 0.0f32);
        for p in points {
            let at = (p - middle).dot(normal);
            along = [along[0].min(at), along[1].max(at)];
            radius = radius.max(p.distance(middle));
        }
        Self {
            low: bounds.min,
            high: bounds.max,
            first: 0,
            is_leaf: false,
            middle,
            plate,
            radius,
            normal,
            along,
        }
    }
}
