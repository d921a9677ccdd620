use glam::{DAffine3, Vec3};

/// An axis-aligned box, in the unit of its points.
///
/// Bounds may be infinite: [`Aabb::ALL`] contains every point, and [`Aabb::EMPTY`] none.
///
/// ```
/// use argil_math::Aabb;
/// use glam::Vec3;
/// let unit = Aabb::new(Vec3::ZERO, Vec3::ONE);
/// assert_eq!(unit.grown(1.0).size(), Vec3::splat(3.0));
/// assert_eq!(unit.distance(Vec3::new(3.0, 0.5, 0.5)), 2.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "bounding box")]
pub struct Aabb {
    /// The minimum corner.
    pub min: Vec3,
    /// The maximum corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box without points.
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };
    /// The box of all points.
    pub const ALL: Self = Self {
        min: Vec3::NEG_INFINITY,
        max: Vec3::INFINITY,
    };

    /// Creates the box between two corners. It is empty if a coordinate of `min` exceeds that of `max`.
    pub const fn new(min: Vec3, max: Vec3) -> Self {
        Self { min, max }
    }

    /// Creates the box of half size `half` around the origin.
    pub fn centered(half: Vec3) -> Self {
        Self::new(-half, half)
    }

    /// Creates the smallest box around points.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points
            .into_iter()
            .fold(Self::EMPTY, |b, p| Self::new(b.min.min(p), b.max.max(p)))
    }

    /// Whether no point lies in the box.
    pub fn is_empty(self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Whether the box is neither empty nor infinite.
    pub fn is_finite(self) -> bool {
        !self.is_empty() && self.min.is_finite() && self.max.is_finite()
    }

    /// Returns the center. Meaningful only for a finite box.
    pub fn center(self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Returns the lengths of the sides.
    pub fn size(self) -> Vec3 {
        self.max - self.min
    }

    /// Returns half of the diagonal: the radius of the bounding sphere.
    pub fn half_diagonal(self) -> f32 {
        0.5 * self.size().length()
    }

    /// Returns the box with all sides moved outward by `by`. An empty box stays empty.
    pub fn grown(self, by: f32) -> Self {
        if self.is_empty() {
            self
        } else {
            Self::new(self.min - by, self.max + by)
        }
    }

    /// Returns the smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self::new(self.min.min(other.min), self.max.max(other.max))
    }

    /// Returns the points in both.
    pub fn intersection(self, other: Self) -> Self {
        let both = Self::new(self.min.max(other.min), self.max.min(other.max));
        if both.is_empty() { Self::EMPTY } else { both }
    }

    /// Whether a point lies in the box or on its border.
    pub fn contains(self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Returns the distance from a point to the box, 0 inside.
    pub fn distance(self, point: Vec3) -> f32 {
        (point - point.clamp(self.min, self.max)).length()
    }

    /// Returns the eight corners.
    pub fn corners(self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            Vec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// Returns a box around this one after an affine map. A side that is infinite stays so along every axis that it gets
    /// a share of.
    pub fn mapped(self, to_from_self: &DAffine3) -> Self {
        if self.is_empty() {
            return self;
        }
        if !self.is_finite() {
            return self.mapped_infinite(to_from_self);
        }
        // Corners in f64, and then one step outward for the rounding to f32.
        let hull = Self::around(
            self.corners()
                .map(|c| to_from_self.transform_point3(c.as_dvec3()).as_vec3()),
        );
        let slack = hull.min.abs().max(hull.max.abs()).max_element() * f32::EPSILON;
        hull.grown(slack)
    }

    /// Adds up, for each axis, the shares of all sides, with room for the rounding to f32.
    fn mapped_infinite(self, to_from_self: &DAffine3) -> Self {
        let mut mapped = Self::ALL;
        for axis in 0..3 {
            let start = to_from_self.translation[axis];
            let (mut low, mut high) = (start, start);
            for from in 0..3 {
                let share = to_from_self.matrix3.col(from)[axis];
                // A quarter turn leaves a share of 1e-16, and not 0.
                if share.abs() < 1e-12 {
                    continue;
                }
                let ends = [self.min[from], self.max[from]].map(|end| f64::from(end) * share);
                low += ends[0].min(ends[1]);
                high += ends[0].max(ends[1]);
            }
            let slack = |end: f64| end.abs() * f64::from(f32::EPSILON);
            if low.is_finite() {
                mapped.min[axis] = (low - slack(low)) as f32;
            }
            if high.is_finite() {
                mapped.max[axis] = (high + slack(high)) as f32;
            }
        }
        mapped
    }
}
