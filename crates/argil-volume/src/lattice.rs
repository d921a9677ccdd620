use argil_field::Grid;
use argil_math::Aabb;
use glam::{UVec3, Vec3};

/// Fewest voxels along the longest side of a volume, and most.
pub const RESOLUTIONS: std::ops::RangeInclusive<u32> = 8..=4096;

/// Voxels between the solid and the sides of its volume, at least.
const MARGIN_VOXELS: f32 = 2.0;

/// Why a volume of that size cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "resolution {0}: a volume has from {least} to {most} voxels along its longest side",
    least = RESOLUTIONS.start(),
    most = RESOLUTIONS.end()
)]
pub struct ResolutionError(
    /// Asked for.
    pub u32,
);

/// Where a volume's voxels lie: cubes of one size that fill a box.
///
/// ```text
///   corner          corner + voxel
///     │ texel 0's centre │        texel i is sampled at corner + voxel · (i + ½)
///     ├────────●─────────┼────────●─────────┤ …
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The box's least corner, in the world.
    pub corner: Vec3,
    /// The edge of a voxel.
    pub voxel: f32,
    /// Voxels along each axis.
    pub size: UVec3,
}

impl Lattice {
    /// `resolution` voxels along the longest side of a finite box, and as many as are needed along the others, where the
    /// volume may be up to a voxel longer than the box.
    pub fn over(region: Aabb, resolution: u32) -> Result<Self, ResolutionError> {
        if !RESOLUTIONS.contains(&resolution) {
            return Err(ResolutionError(resolution));
        }
        let sides = region.size().max(Vec3::splat(1e-6));
        let voxel = sides.max_element() / resolution as f32;
        // A side that is a multiple of the voxel but for rounding gets no voxel more.
        let size = (sides / voxel - 1e-3)
            .ceil()
            .as_uvec3()
            .clamp(UVec3::ONE, UVec3::splat(resolution));
        Ok(Self {
            corner: region.center() - size.as_vec3() * (0.5 * voxel),
            voxel,
            size,
        })
    }

    /// A lattice that holds a solid with two voxels around it, and the frame that it is looked at in. A solid without
    /// end is cut to the frame, or to a box of size 2 around the origin.
    pub fn holding(
        solid: Aabb,
        frame: Option<Aabb>,
        resolution: u32,
    ) -> Result<Self, ResolutionError> {
        if !RESOLUTIONS.contains(&resolution) {
            return Err(ResolutionError(resolution));
        }
        let frame = frame.filter(|f| f.is_finite()).unwrap_or(Aabb::EMPTY);
        let whole = if solid.is_finite() {
            frame.union(solid)
        } else {
            frame
        };
        if !whole.is_finite() {
            return Self::over(Aabb::centered(Vec3::ONE), resolution);
        }
        if !solid.is_finite() {
            return Self::over(whole, resolution);
        }
        // The margin's voxels count among the resolution.
        let voxel = whole.size().max_element() / (resolution as f32 - 2.0 * MARGIN_VOXELS);
        Self::over(frame.union(solid.grown(MARGIN_VOXELS * voxel)), resolution)
    }

    /// Lengths of the box's sides.
    pub fn extent(&self) -> Vec3 {
        self.size.as_vec3() * self.voxel
    }

    /// The box.
    pub fn aabb(&self) -> Aabb {
        Aabb::new(self.corner, self.corner + self.extent())
    }

    /// Texels along each axis of a level of detail: half of those of the level before, rounded down, as textures have it.
    pub fn level_size(&self, level: u32) -> UVec3 {
        UVec3::from_array(self.size.to_array().map(|n| (n >> level).max(1)))
    }

    /// Between the texels of a level.
    pub fn level_spacing(&self, level: u32) -> Vec3 {
        if level == 0 {
            Vec3::splat(self.voxel)
        } else {
            self.extent() / self.level_size(level).as_vec3()
        }
    }

    /// The centres of a level's texels.
    pub fn grid(&self, level: u32) -> Grid {
        let spacing = self.level_spacing(level);
        Grid {
            min: self.corner + spacing * 0.5,
            spacing,
            begin: UVec3::ZERO,
            size: self.level_size(level),
        }
    }

    /// Texels of a level.
    pub fn texel_count(&self, level: u32) -> u64 {
        let size = self.level_size(level);
        u64::from(size.x) * u64::from(size.y) * u64::from(size.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_side_has_what_was_asked_for() {
        for resolution in [8, 37, 256, 300, 1000] {
            for half in [[1.0, 1.0, 1.0], [2.0, 1.0, 0.3], [0.01, 5.0, 5.0]] {
                let solid = Aabb::centered(half.into());
                let lattice = Lattice::holding(solid, None, resolution).expect("a lattice");
                assert_eq!(lattice.size.max_element(), resolution);
                let inner = lattice.aabb().grown(-1.99 * lattice.voxel);
                assert!(inner.contains(solid.min) && inner.contains(solid.max));
            }
        }
    }

    #[test]
    fn a_frame_with_room_to_spare_is_the_box_itself() {
        let frame = Aabb::centered(Vec3::ONE);
        let solid = Aabb::centered(Vec3::splat(0.9));
        let lattice = Lattice::holding(solid, Some(frame), 256).expect("a lattice");
        assert_eq!(lattice.aabb(), frame);
        assert_eq!(lattice.size, UVec3::splat(256));
        let endless = Lattice::holding(Aabb::ALL, Some(frame), 64).expect("a lattice");
        assert_eq!(endless.aabb(), frame);
        let nothing = Lattice::holding(Aabb::EMPTY, None, 64).expect("a lattice");
        assert_eq!(nothing.aabb(), frame);
    }

    #[test]
    fn absurd_resolutions_are_refused() {
        for resolution in [0, 1, 7, 4097, u32::MAX] {
            let made = Lattice::holding(Aabb::ALL, None, resolution);
            assert_eq!(made, Err(ResolutionError(resolution)));
        }
    }
}
