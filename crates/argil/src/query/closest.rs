//! Finds the closest point of the surface.

use super::{ClosestPoint, MAX_BOXES, Query};
use argil_math::Aabb;
use glam::Vec3;

impl Query<'_> {
    /// Returns the closest point of the surface within `max_distance`, or the best one found in [`MAX_BOXES`]
    /// boxes: [`ClosestPoint::is_nearest`] tells which. Returns `None` if there is none.
    #[doc(alias = "project_point")]
    #[doc(alias = "nearest")]
    pub fn closest_point(&self, point: [f32; 3], max_distance: f32) -> Option<ClosestPoint> {
        self.closest_point_among(point, max_distance, MAX_BOXES)
    }

    /// Finds the closest point within a budget of boxes. A box costs up to 10 µs where brushes are twisted or
    /// blended. A few hundred boxes find a point that is good enough to push a character out of a wall.
    ///
    /// ```
    /// use argil::prelude::*;
    /// let mut scene = Scene::new();
    /// scene.push(Brush::new(Shape::sphere(0.5)))?;
    /// let world = Engine::cpu().build(&scene)?.field();
    /// let found = world.query().closest_point_among([0.0, 0.8, 0.0], 1.0, 256);
    /// assert!(found.is_some_and(|found| (found.distance - 0.3).abs() < 1e-3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn closest_point_among(
        &self,
        point: [f32; 3],
        max_distance: f32,
        boxes: usize,
    ) -> Option<ClosestPoint> {
        let p = Vec3::from(point);
        if !p.is_finite() || max_distance.is_nan() {
            return None;
        }
        let mut probe = self.probe();
        let d = self.sample(&mut probe, p).0;
        let lipschitz = self.tables().lipschitz();
        // The surface lies outside the free sphere. A projection finds an upper bound, or the search extends to
        // the maximum.
        let free = d.abs() / lipschitz;
        let mut best = self
            .project_to_surface(&mut probe, p)
            .filter(|q| q.distance(p) <= max_distance);
        let mut reach = best.map_or(max_distance, |q| q.distance(p));
        let bounds = self.tables().aabb().grown(self.epsilon);
        if best.is_none() {
            // No farther than the scene extends.
            let farthest = bounds.corners().map(|c| c.distance(p));
            reach = reach.min(farthest.into_iter().fold(0.0, f32::max));
        }
        let found = |best: Option<Vec3>, is_nearest: bool| {
            best.map(|q| ClosestPoint {
                point: q.to_array(),
                distance: q.distance(p),
                is_nearest,
            })
        };
        if !reach.is_finite() || reach <= free || bounds.is_empty() {
            return found(best, reach.is_finite());
        }
        // Nearest boxes first.
        let whole = Aabb::new(p - reach, p + reach);
        let mut open = std::collections::BinaryHeap::new();
        open.push(OpenBox(0.0, whole));
        let mut looked_at = 0;
        let mut is_nearest = true;
        while let Some(OpenBox(nearest, held)) = open.pop() {
            if nearest >= 0.99 * reach {
                break;
            }
            if looked_at >= boxes {
                is_nearest = false;
                break;
            }
            looked_at += 1;
            let center = held.center();
            let half = held.half_diagonal();
            let d = self.sample(&mut probe, center).0;
            if d.abs() > lipschitz * half + self.slack(held) {
                continue;
            }
            let is_least = |reach: f32| half < 0.005 * reach.max(self.epsilon);
            if (half < 0.25 * free.max(self.epsilon) || is_least(reach))
                && let Some(q) = self.project_to_surface(&mut probe, center)
                && q.distance(p) < reach
            {
                reach = q.distance(p);
                best = Some(q);
            }
            if is_least(reach) {
                continue;
            }
            for corner in held.corners() {
                let part = Aabb::new(corner.min(center), corner.max(center));
                let nearest = p.distance(p.clamp(part.min, part.max)).max(free);
                if nearest < 0.99 * reach {
                    open.push(OpenBox(nearest, part));
                }
            }
        }
        found(best, is_nearest)
    }

    /// Finds the closest points of many points, on rayon's threads: see [`Query::closest_point`].
    pub fn closest_points(
        &self,
        points: &[[f32; 3]],
        max_distance: f32,
    ) -> Vec<Option<ClosestPoint>> {
        use rayon::prelude::*;
        points
            .par_iter()
            .map(|&point| self.closest_point(point, max_distance))
            .collect()
    }
}

/// A box to examine, ordered by its distance.
struct OpenBox(f32, Aabb);

impl PartialEq for OpenBox {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for OpenBox {}

impl PartialOrd for OpenBox {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for OpenBox {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        // The heap returns the greatest first, which must be the nearest.
        other.0.total_cmp(&self.0)
    }
}
