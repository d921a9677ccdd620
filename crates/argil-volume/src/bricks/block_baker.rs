//! Bakes single bricks, for levels of detail.

use super::BrickLayout;
use super::bounds::CellBounds;
use super::brick_baker::BrickBaker;
use super::candidates::is_clear_in_parts;
use super::cell::empty_word;
use super::sample_offsets::SampleOffsets;
use crate::Texel;
use argil_abi::{FillUniform, Instruction};
use argil_field::{Program, Pruner};
use glam::{DVec3, IVec3, Vec3};

/// Voxels along the side of a region whose pages are evaluated relative to its corner, as a power of two: then `f32`
/// keeps a thousandth of a voxel.
pub(crate) const REGION_VOXELS_LOG2: u32 = 13;

/// What all cells of a layout share.
pub(crate) struct CellContext<'a> {
    pub layout: BrickLayout,
    /// The same for cells counted from a region's corner, in a wide world. Else it is the layout.
    local: BrickLayout,
    is_wide: bool,
    program: &'a Program,
    bounds: CellBounds<'a>,
    fill: FillUniform,
    places: &'static SampleOffsets,
    /// The largest deviation of distances from a plane in a flat cell.
    tolerance: f32,
}

/// Where the cells of a page are, and what bounds their distances.
pub(crate) struct PageSite<'a> {
    bounds: CellBounds<'a>,
    /// The page's first cell, and the first one of its region.
    first: IVec3,
    region: IVec3,
    /// The corner of the region, in a wide world.
    origin: Option<DVec3>,
}

/// Whether the surface can pass through a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CellNearness {
    Clear,
    Near,
    /// Only jumps keep it from being clear.
    Doubtful,
}

/// A sampled brick.
pub(crate) struct SampledBrick {
    pub material: u32,
    /// Whether its distances are those of a plane.
    pub is_flat: bool,
}

impl<'a> CellContext<'a> {
    pub(crate) fn new(
        program: &'a Program,
        (layout, is_wide): (BrickLayout, bool),
        tolerance: f32,
    ) -> Self {
        let mut local = layout;
        if is_wide {
            local.voxel_grid.corner = Vec3::ZERO;
        }
        Self {
            tolerance,
            program,
            bounds: CellBounds::new(program, &layout),
            fill: layout.encoding.fill_uniform(program, &layout.voxel_grid, 0),
            places: SampleOffsets::of_eight(),
            layout,
            local,
            is_wide,
        }
    }

    /// Returns the state of a thread.
    pub(crate) fn baker(&self) -> BrickBaker<'_> {
        BrickBaker::new(self.program, &self.local, &self.fill, self.places)
    }

    /// Returns the site of a page of 2³ cells, given its first cell and its program.
    pub(crate) fn site(&self, first: IVec3, list: &[Instruction]) -> PageSite<'a> {
        let side = self.layout.brick_size_voxels;
        let shift = REGION_VOXELS_LOG2 - side.ilog2();
        let (region, origin) = if self.is_wide {
            let region = first >> shift << shift;
            let grid = &self.layout.voxel_grid;
            let voxels = (region * side as i32).as_dvec3();
            let corner = grid.corner.as_dvec3() + voxels * f64::from(grid.voxel_size);
            (region, Some(corner))
        } else {
            (IVec3::ZERO, None)
        };
        let center = self.local.center(first - region, 2);
        let bounds = self
            .bounds
            .about_page(center, self.local.cell_length(), (list, origin));
        PageSite {
            bounds,
            first,
            region,
            origin,
        }
    }

    /// Whether a brick's samples at its corners and its center can be those of a plane. It saves most bricks the proof.
    fn may_be_plane<T: Texel>(&self, texels: &[T]) -> bool {
        let layout = &self.layout;
        let n = layout.brick_size_voxels as usize;
        let quantum = layout.encoding.band_width(&layout.voxel_grid, 0)
            / layout.encoding.format.max_code() as f32;
        let at = |x: usize, y: usize, z: usize| {
            let index = (z * (n + 1) + y) * (n + 1) + x;
            texels[index].code() * quantum
        };
        let first = at(0, 0, 0);
        let along = [at(n, 0, 0), at(0, n, 0), at(0, 0, n)].map(|d| d - first);
        // A plane through four samples is off by up to five times their error elsewhere.
        let limit = 6.0 * (self.tolerance + quantum);
        let corners = [[1, 1, 0], [1, 0, 1], [0, 1, 1], [1, 1, 1]].map(|corner| {
            let [x, y, z] = corner.map(|c| c * n);
            let expected: f32 = (0..3).map(|axis| corner[axis] as f32 * along[axis]).sum();
            at(x, y, z) - first - expected
        });
        let center = at(n / 2, n / 2, n / 2) - first - 0.5 * along.iter().sum::<f32>();
        corners
            .iter()
            .chain([&center])
            .all(|off| off.abs() <= limit)
    }
}

impl PageSite<'_> {
    /// Returns a cell of the page, counted from the region's corner.
    fn cell(&self, index: u32) -> IVec3 {
        let place = IVec3::new(
            (index & 1) as i32,
            (index >> 1 & 1) as i32,
            (index >> 2) as i32,
        );
        self.first + place - self.region
    }

    /// Measures the page's cells with a program that is valid in all of them: the distances at their centers. The
    /// pruner then knows their programs.
    pub(crate) fn classify(
        &self,
        context: &CellContext<'_>,
        list: &[Instruction],
        pruner: &mut Pruner<'_>,
    ) -> [f32; 8] {
        let local = &context.local;
        let centers: [Vec3; 8] =
            std::array::from_fn(|index| local.center(self.cell(index as u32), 1));
        let mut distances = [0.0; 8];
        pruner.set_origin(self.origin);
        pruner.classify_cells(list, &centers, local.half_diagonal(1), &mut distances);
        distances
    }

    /// Returns a measured cell's word, if it gets no brick.
    pub(crate) fn empty_word(&self, distance: f32) -> u32 {
        empty_word(self.bounds.center(distance))
    }

    /// Whether the surface can pass through a measured cell.
    pub(crate) fn nearness(
        &self,
        context: &CellContext<'_>,
        index: u32,
        distance: f32,
    ) -> CellNearness {
        let radius = context.layout.half_diagonal(1);
        let cell = self.cell(index) + self.region;
        if self.bounds.is_clear(distance, radius) || !context.layout.can_have_brick(cell) {
            CellNearness::Clear
        } else if self.bounds.is_doubtful(distance, radius) {
            CellNearness::Doubtful
        } else {
            CellNearness::Near
        }
    }

    /// Whether no surface passes through a doubtful cell, given its program.
    pub(crate) fn is_clear_in_parts(
        &self,
        context: &CellContext<'_>,
        index: u32,
        list: &[Instruction],
    ) -> bool {
        let mut pruner = Pruner::new(context.program);
        pruner.set_origin(self.origin);
        is_clear_in_parts(
            &context.local,
            &self.bounds,
            self.cell(index),
            list,
            &mut pruner,
        )
    }

    /// Samples a cell's brick behind `texels`. Returns `None` if no surface passes through it.
    pub(crate) fn sample<T: Texel>(
        &self,
        context: &CellContext<'_>,
        index: u32,
        list: &[Instruction],
        baker: &mut BrickBaker<'_>,
        (texels, mixed): (&mut Vec<T>, &mut Vec<[u32; 2]>),
    ) -> Option<SampledBrick> {
        let layout = &context.layout;
        let cell = self.cell(index);
        baker.set_origin(self.origin);
        // At most half of a voxel's diagonal from a sample.
        let reach = 0.5 * 3f32.sqrt() * layout.voxel_grid.voxel_size;
        let begin = texels.len();
        texels.resize(begin + layout.brick_samples() as usize, T::default());
        let least = baker.brick(list, cell, &mut texels[begin..]);
        if self.bounds.is_clear(least, reach) {
            texels.truncate(begin);
            return None;
        }
        let lipschitz = self.bounds.lipschitz();
        let is_plane = context.may_be_plane(&texels[begin..]);
        let flat = is_plane.then(|| baker.flat_program(list, cell, (lipschitz, context.tolerance)));
        let flat = flat.flatten();
        let is_flat = flat.is_some();
        // Other materials are not near the surface.
        let list = flat.as_deref().unwrap_or(list);
        let material = baker.material(list, (cell, lipschitz), mixed);
        Some(SampledBrick { material, is_flat })
    }
}
