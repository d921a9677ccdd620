use argil_field::Grid;
use argil_math::Aabb;
use glam::{IVec3, UVec3, Vec3};

/// Valid numbers of voxels along the longest side of a volume.
pub const RESOLUTION_RANGE: std::ops::RangeInclusive<u32> = 8..=4096;

/// Minimum voxels between the solid and the sides of its volume.
const MARGIN_VOXELS: f32 = 2.0;

/// The resolution is out of range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "resolution {0}: choose {least} to {most} voxels along the longest side",
    least = RESOLUTION_RANGE.start(),
    most = RESOLUTION_RANGE.end()
)]
pub struct ResolutionError(
    /// The requested resolution.
    pub u32,
);

/// The voxel size is out of range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "voxel size {voxel_size}: the box is {longest} long, which must be {least} to {max} voxels",
    least = RESOLUTION_RANGE.start()
)]
pub struct VoxelSizeError {
    /// Maximum voxels along the longest side.
    pub max: u32,
    /// The requested voxel size.
    pub voxel_size: f32,
    /// The longest side of the box, in the scene's unit.
    pub longest: f32,
}

/// Maximum distance of a voxel from the grid's corner, in voxels. `f32` counts no farther.
pub const MAX_VOXEL_INDEX: i32 = 1 << 23;

/// Maximum voxels along the longest side of sparse bricks with a given voxel size. The same number is left for
/// growth.
pub const MAX_SPARSE_RESOLUTION: u32 = MAX_VOXEL_INDEX as u32 / 2;

/// A grid cannot grow that far.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the scene reaches {voxels} voxels from the origin of its volume, and the limit is {MAX_VOXEL_INDEX}: choose larger voxels, or move the brush closer"
)]
pub struct TooFarError {
    /// The requested distance in voxels.
    pub voxels: f32,
}

/// Places a volume's voxels: cubes of one size that fill a box.
///
/// ```text
///   corner          corner + voxel
///     │ texel 0's center │        texel i is sampled at corner + voxel · (i + ½)
///     ├────────●─────────┼────────●─────────┤ …
/// ```
///
/// Voxels are counted from `corner`, in both directions. The box of a world that grew begins elsewhere: at `begin`.
///
/// ```
/// use argil_math::Aabb;
/// use argil_volume::VoxelGrid;
/// let grid = VoxelGrid::fitting(Aabb::centered([1.0, 0.5, 0.5].into()), None, 64)?;
/// assert_eq!(grid.size.max_element(), 64);
/// assert!(grid.aabb().contains([1.0, 0.5, 0.5].into()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelGrid {
    /// Minimum corner of voxel 0, in the scene's space.
    pub corner: Vec3,
    /// Edge of a voxel, in the scene's unit.
    pub voxel_size: f32,
    /// The first voxel along each axis.
    pub begin: IVec3,
    /// Number of voxels along each axis.
    pub size: UVec3,
    /// Whether the box clips the solid. An infinite solid is clipped by the bounds of the view, or by a box around the
    /// origin. A `World` passes a box around the finite brushes as bounds.
    pub is_clipped: bool,
}

impl VoxelGrid {
    /// Creates a grid of `resolution` voxels along the longest side of a finite box. The other sides may be up to
    /// one voxel longer than the box.
    ///
    /// # Errors
    /// If the resolution is outside [`RESOLUTION_RANGE`].
    pub fn covering(region: Aabb, resolution: u32) -> Result<Self, ResolutionError> {
        if !RESOLUTION_RANGE.contains(&resolution) {
            return Err(ResolutionError(resolution));
        }
        let sides = region.size().max(Vec3::splat(1e-6));
        let voxel = sides.max_element() / resolution as f32;
        // A side that is a multiple of the voxel, but for rounding, gets no extra voxel.
        let size = (sides / voxel - 1e-3)
            .ceil()
            .as_uvec3()
            .clamp(UVec3::ONE, UVec3::splat(resolution));
        Ok(Self {
            corner: region.center() - size.as_vec3() * (0.5 * voxel),
            voxel_size: voxel,
            begin: IVec3::ZERO,
            size,
            is_clipped: true,
        })
    }

    /// Creates a grid that contains a solid with two voxels around it, and the bounds of its view. An infinite solid
    /// is clipped to the bounds, or to a box of size 2 around the origin.
    ///
    /// # Errors
    /// If the resolution is outside [`RESOLUTION_RANGE`].
    pub fn fitting(
        solid: Aabb,
        view_bounds: Option<Aabb>,
        resolution: u32,
    ) -> Result<Self, ResolutionError> {
        if !RESOLUTION_RANGE.contains(&resolution) {
            return Err(ResolutionError(resolution));
        }
        // The margin's voxels count among the resolution.
        let voxel_of =
            |whole: Aabb| whole.size().max_element() / (resolution as f32 - 2.0 * MARGIN_VOXELS);
        let (held, is_cut) = contained_box(solid, view_bounds, voxel_of);
        let voxel_grid = Self::covering(held, resolution)?;
        Ok(Self {
            is_clipped: is_cut,
            ..voxel_grid
        })
    }

    /// Creates a grid as [`VoxelGrid::fitting`] does, with voxels of a size in the scene's unit, and at most
    /// `max_voxels` along a side.
    ///
    /// # Errors
    /// If there would be too few or too many voxels along the longest side.
    pub fn with_voxel_size(
        solid: Aabb,
        view_bounds: Option<Aabb>,
        voxel: f32,
        max_voxels: u32,
    ) -> Result<Self, VoxelSizeError> {
        let (held, is_cut) = contained_box(solid, view_bounds, |_| voxel);
        let count = (held.size() / voxel - 1e-3).ceil();
        let longest = count.max_element() as u32;
        if !(voxel > 0.0 && (*RESOLUTION_RANGE.start()..=max_voxels).contains(&longest)) {
            let longest = contained_box(solid, view_bounds, |_| 0.0)
                .0
                .size()
                .max_element();
            return Err(VoxelSizeError {
                max: max_voxels,
                voxel_size: voxel,
                longest,
            });
        }
        let size = count.as_uvec3().max(UVec3::ONE);
        Ok(Self {
            corner: held.center() - size.as_vec3() * (0.5 * voxel),
            voxel_size: voxel,
            begin: IVec3::ZERO,
            size,
            is_clipped: is_cut,
        })
    }

    /// Returns a grid with the same voxels that also contains a solid, with two voxels around it, grown in steps of
    /// `step` voxels. A grid that clips its solid does not grow.
    ///
    /// # Errors
    /// If the solid is too far from the grid's corner.
    pub fn grown_to(&self, solid: Aabb, step: u32) -> Result<Self, TooFarError> {
        if self.is_clipped || !solid.is_finite() {
            return Ok(*self);
        }
        let step = step.max(1) as f32;
        let count = |p: Vec3| (p - self.corner) / self.voxel_size;
        let low = count(solid.min) - MARGIN_VOXELS;
        let high = count(solid.max) + MARGIN_VOXELS;
        let end = self.begin + self.size.as_ivec3();
        let farthest = low.abs().max(high.abs()).max_element();
        if farthest.is_nan() || farthest > (MAX_VOXEL_INDEX - 4096) as f32 {
            return Err(TooFarError { voxels: farthest });
        }
        let (low, high) = (low.floor().as_ivec3(), high.ceil().as_ivec3());
        // An axis where nothing is outside the box does not grow.
        let mut grown = *self;
        for axis in 0..3 {
            let (mut first, mut last) = (self.begin[axis], end[axis]);
            if low[axis] < first {
                first = ((low[axis] as f32 / step).floor() * step) as i32;
            }
            if high[axis] > last {
                last = ((high[axis] as f32 / step).ceil() * step) as i32;
            }
            grown.begin[axis] = first;
            grown.size[axis] = (last - first) as u32;
        }
        Ok(grown)
    }

    /// Returns a grid with the same voxels over the box that [`VoxelGrid::fitting`] computes.
    ///
    /// # Errors
    /// If the box is too far from the grid's corner.
    pub fn recomputed(&self, solid: Aabb, view_bounds: Option<Aabb>) -> Result<Self, TooFarError> {
        let view_bounds = view_bounds.filter(|f| f.is_finite()).unwrap_or(Aabb::EMPTY);
        let held = if solid.is_finite() {
            view_bounds.union(solid.grown(MARGIN_VOXELS * self.voxel_size))
        } else if view_bounds.is_finite() {
            view_bounds
        } else {
            Aabb::centered(Vec3::ONE)
        };
        // A side that is a multiple of the voxel, but for rounding, gets no extra voxel.
        let low = ((held.min - self.corner) / self.voxel_size + 1e-3).floor();
        let high = ((held.max - self.corner) / self.voxel_size - 1e-3).ceil();
        let farthest = low.abs().max(high.abs()).max_element();
        if farthest.is_nan() || farthest > MAX_VOXEL_INDEX as f32 {
            return Err(TooFarError { voxels: farthest });
        }
        let begin = low.as_ivec3();
        Ok(Self {
            begin,
            size: (high.as_ivec3() - begin).max(IVec3::ONE).as_uvec3(),
            is_clipped: !solid.is_finite() && !solid.is_empty(),
            ..*self
        })
    }

    /// Returns the same voxels in a box that reaches at least some voxels from the corner, along the sides on which a
    /// solid is infinite.
    ///
    /// ```
    /// # use argil_volume::VoxelGrid;
    /// # use argil_math::Aabb;
    /// let grid = VoxelGrid::covering(Aabb::new([-1.0; 3].into(), [1.0; 3].into()), 64)?;
    /// let floor = Aabb::new([f32::NEG_INFINITY; 3].into(), [f32::INFINITY, 0.0, 4.0].into());
    /// let wide = grid.extended(floor, 4096);
    /// assert_eq!(wide.begin, [-4096, -4096, -4096].into());
    /// assert_eq!(wide.size, [8192, 4096 + 64, 4096 + 64].into());
    /// # Ok::<(), argil_volume::ResolutionError>(())
    /// ```
    pub fn extended(&self, solid: Aabb, voxels: i32) -> Self {
        let (mut begin, mut end) = (self.begin, self.begin + self.size.as_ivec3());
        for axis in 0..3 {
            if solid.min[axis] == f32::NEG_INFINITY {
                begin[axis] = begin[axis].min(-voxels);
            }
            if solid.max[axis] == f32::INFINITY {
                end[axis] = end[axis].max(voxels);
            }
        }
        Self {
            begin,
            size: (end - begin).as_uvec3(),
            ..*self
        }
    }

    /// Returns the same voxels, counted from the box's own corner.
    pub fn with_origin_at_box(&self) -> Self {
        Self {
            corner: self.aabb().min,
            begin: IVec3::ZERO,
            ..*self
        }
    }

    /// Whether there are voxels, of a finite size, and `f32` counts all of them from the corner.
    pub(crate) fn is_countable(&self) -> bool {
        let begin = self.begin.as_dvec3();
        let end = begin + self.size.as_dvec3();
        let farthest = begin.abs().max(end.abs()).max_element();
        self.corner.is_finite()
            && self.voxel_size.is_finite()
            && self.voxel_size > 0.0
            && self.size.min_element() > 0
            && farthest <= f64::from(MAX_VOXEL_INDEX)
    }

    /// Returns the lengths of the box's sides.
    pub fn extent(&self) -> Vec3 {
        self.size.as_vec3() * self.voxel_size
    }

    /// Returns the box.
    pub fn aabb(&self) -> Aabb {
        let place = |voxel: IVec3| self.corner + self.voxel_size * voxel.as_vec3();
        Aabb::new(place(self.begin), place(self.begin + self.size.as_ivec3()))
    }

    /// Returns the number of samples along each axis of a level: half of the level before, rounded down, as in
    /// textures.
    pub fn level_size(&self, level: u32) -> UVec3 {
        UVec3::from_array(self.size.to_array().map(|n| (n >> level).max(1)))
    }

    /// Returns the distances between samples of a level.
    pub fn level_spacing(&self, level: u32) -> Vec3 {
        if level == 0 {
            Vec3::splat(self.voxel_size)
        } else {
            self.extent() / self.level_size(level).as_vec3()
        }
    }

    /// Returns the centers of a level's samples.
    pub fn grid(&self, level: u32) -> Grid {
        let spacing = self.level_spacing(level);
        Grid {
            min: self.aabb().min + spacing * 0.5,
            spacing,
            begin: UVec3::ZERO,
            size: self.level_size(level),
        }
    }

    /// Returns the number of samples of a level.
    pub fn texel_count(&self, level: u32) -> u64 {
        let size = self.level_size(level);
        u64::from(size.x) * u64::from(size.y) * u64::from(size.z)
    }
}

/// Returns the box of a grid and whether it clips the solid. The solid's box and the bounds determine the voxel
/// size.
fn contained_box(
    solid: Aabb,
    view_bounds: Option<Aabb>,
    voxel_of: impl Fn(Aabb) -> f32,
) -> (Aabb, bool) {
    let view_bounds = view_bounds.filter(|f| f.is_finite()).unwrap_or(Aabb::EMPTY);
    if solid.is_finite() {
        let voxel = voxel_of(view_bounds.union(solid));
        return (view_bounds.union(solid.grown(MARGIN_VOXELS * voxel)), false);
    }
    let held = if view_bounds.is_finite() {
        view_bounds
    } else {
        Aabb::centered(Vec3::ONE)
    };
    (held, !solid.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_side_has_what_was_asked_for() {
        for resolution in [8, 37, 256, 300, 1000] {
            for half in [[1.0, 1.0, 1.0], [2.0, 1.0, 0.3], [0.01, 5.0, 5.0]] {
                let solid = Aabb::centered(half.into());
                let voxel_grid = VoxelGrid::fitting(solid, None, resolution).expect("a voxel grid");
                assert_eq!(voxel_grid.size.max_element(), resolution);
                let inner = voxel_grid.aabb().grown(-1.99 * voxel_grid.voxel_size);
                assert!(inner.contains(solid.min) && inner.contains(solid.max));
            }
        }
    }

    #[test]
    fn a_frame_with_room_to_spare_is_the_box_itself() {
        let view_bounds = Aabb::centered(Vec3::ONE);
        let solid = Aabb::centered(Vec3::splat(0.9));
        let voxel_grid = VoxelGrid::fitting(solid, Some(view_bounds), 256).expect("a voxel grid");
        assert_eq!(voxel_grid.aabb(), view_bounds);
        assert_eq!(voxel_grid.size, UVec3::splat(256));
        let infinite = VoxelGrid::fitting(Aabb::ALL, Some(view_bounds), 64).expect("a voxel grid");
        assert_eq!(infinite.aabb(), view_bounds);
        let nothing = VoxelGrid::fitting(Aabb::EMPTY, None, 64).expect("a voxel grid");
        assert_eq!(nothing.aabb(), view_bounds);
    }

    #[test]
    fn a_grid_grows_by_whole_steps_and_keeps_its_voxels() {
        let first = VoxelGrid::fitting(Aabb::centered(Vec3::ONE), None, 64).expect("a voxel grid");
        let far = Aabb::new(Vec3::new(-9.0, 0.0, 0.0), Vec3::new(-8.0, 1.0, 3.0));
        let grown = first.grown_to(far, 32).expect("a voxel grid");
        assert_eq!(
            (grown.corner, grown.voxel_size),
            (first.corner, first.voxel_size)
        );
        assert!(grown.begin.x < 0 && grown.begin.x % 32 == 0);
        assert_eq!([grown.begin.y, grown.begin.z], [0; 2]);
        assert_eq!(grown.size.y, first.size.y);
        let inner = grown.aabb().grown(-1.99 * grown.voxel_size);
        assert!(inner.contains(far.min) && inner.contains(far.max));
        assert_eq!(grown.grown_to(far, 32), Ok(grown));
        assert_eq!(grown.with_origin_at_box().aabb().min, grown.aabb().min);
        let infinite = VoxelGrid::fitting(Aabb::ALL, None, 64).expect("a voxel grid");
        assert_eq!(infinite.grown_to(far, 32), Ok(infinite));
        let lost = Aabb::new(far.min, Vec3::splat(1e30));
        assert!(first.grown_to(lost, 32).is_err());
    }

    #[test]
    fn absurd_resolutions_are_refused() {
        for resolution in [0, 1, 7, 4097, u32::MAX] {
            let made = VoxelGrid::fitting(Aabb::ALL, None, resolution);
            assert_eq!(made, Err(ResolutionError(resolution)));
        }
    }
}
