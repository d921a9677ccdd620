//! Bounds on the error and the change of distances in cells and blocks.

use super::layout::BrickLayout;
use argil_abi::Instruction;
use argil_field::{ClearanceModel, NearJumps, Program};
use argil_math::Aabb;
use glam::{DVec3, IVec3, Vec3};

/// Bounds on the distances of a cell or block.
#[derive(Clone, Copy)]
pub(crate) struct CellBounds<'a> {
    pub program: &'a Program,
    terms: ClearanceModel,
    jumps: NearJumps,
    base: f32,
    /// The Lipschitz constant near the cell or block.
    lipschitz: f32,
    /// The largest distance that a cell stores.
    far: f32,
}

impl<'a> CellBounds<'a> {
    /// Creates bounds near the origin, without jumps, and as steep as the steepest place.
    pub(super) fn new(program: &'a Program, layout: &BrickLayout) -> Self {
        Self {
            program,
            terms: program.clearance_model_in(layout.base_length()),
            jumps: NearJumps::NONE,
            base: layout.base_length(),
            lipschitz: program.lipschitz(),
            far: layout.far_length(),
        }
    }

    /// Returns the bounds in a cube with a center, derived from those at the origin.
    pub(super) fn about(&self, center: Vec3, half: f32) -> Self {
        let farthest = center.abs().max_element() + 3f32.sqrt() * half;
        let cube = Aabb::new(center - half, center + half);
        self.in_cube(cube, farthest)
    }

    /// Returns the bounds in a cube, whose arithmetic has coordinates up to `farthest`.
    fn in_cube(&self, cube: Aabb, farthest: f32) -> Self {
        let jumps = self.program.jumps_near(cube, self.far);
        let terms = ClearanceModel {
            steepness: 1.000_01 * jumps.lipschitz,
            ..self.terms.at(self.base, farthest)
        };
        Self {
            terms,
            jumps,
            lipschitz: jumps.lipschitz,
            ..*self
        }
    }

    /// Returns the bounds in a page with a program, given its center, relative to an origin, and half its side.
    pub(super) fn about_page(
        &self,
        center: Vec3,
        half: f32,
        (list, origin): (&[Instruction], Option<DVec3>),
    ) -> Self {
        let cube = Aabb::new(center - half, center + half);
        let farthest = self.program.rounding_coordinate(list, cube, origin);
        let offset = origin.map_or(Vec3::ZERO, |origin| origin.as_vec3());
        let rounding = 1e-6 * offset.abs().max_element();
        let cube = Aabb::new(cube.min + offset, cube.max + offset).grown(rounding);
        self.in_cube(cube, farthest)
    }

    /// Returns the bounds in a block with a first cell.
    pub(super) fn of_block(&self, layout: &BrickLayout, first: IVec3) -> Self {
        let center = layout.center(first, super::BLOCK_SIDE);
        self.about(
            center,
            0.5 * layout.cell_length() * super::BLOCK_SIDE as f32,
        )
    }

    /// Returns values for shaders that use a pruned program: its rounding error, the distance and size of jumps,
    /// the largest jump of the program, and the Lipschitz constant.
    fn words(&self, instructions: &[Instruction]) -> [f32; BLOCK_WORDS] {
        let jumps = &self.jumps;
        [
            self.terms.slack,
            jumps.gap,
            jumps.slack,
            jumps.hidden,
            jumps.isolation,
            self.program.jump_of(instructions),
            self.lipschitz,
        ]
    }

    /// Whether no surface lies within `radius`, inside the cube.
    pub(super) fn is_clear(&self, d: f32, radius: f32) -> bool {
        let terms = if self.jumps.gap > 0.0 {
            self.terms
        } else {
            self.terms.with(&self.jumps)
        };
        // Programs of edits give no distances beyond it.
        terms.radius(d.abs().min(self.far)) > radius
    }

    /// Whether only jumps keep the cell from being [clear](Self::is_clear).
    pub(super) fn is_doubtful(&self, d: f32, radius: f32) -> bool {
        self.jumps.gap <= 0.0 && self.terms.radius(d.abs().min(self.far)) > radius
    }

    /// Whether the whole cube, which lies within `radius`, is farther from the surface than cells store.
    pub(super) fn is_far(&self, d: f32, radius: f32) -> bool {
        self.is_steady() && (self.terms.radius(d) - 1.000_01 * radius) * self.lipschitz >= self.far
    }

    /// Returns the largest distance that is not [clear](Self::is_clear), where nothing jumps.
    pub(super) fn unclear_length(&self, radius: f32) -> f32 {
        1.000_01 * (radius * self.terms.steepness + self.terms.slack)
    }

    /// Returns a bound on how fast distances change per unit of length, near the cell or block.
    pub(super) fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Returns the distance up to which cell centers determine their bricks, where nothing jumps. Instructions
    /// farther away leave the brick clear or saturated. Materials matter only nearer to the surface.
    pub(super) fn near_length(&self, layout: &BrickLayout) -> f32 {
        let range = layout.encoding.band_width(&layout.voxel_grid, 0);
        self.unclear_length(layout.half_diagonal(1)).max(range)
    }

    /// Whether nothing jumps within the distances that cells store.
    pub(super) fn is_steady(&self) -> bool {
        self.jumps.gap == f32::MAX
    }

    /// Returns the range of distances that a cell's stored [value](Self::center) can come from, where nothing
    /// jumps.
    pub(super) fn lengths(&self, center: f32) -> [f32; 2] {
        let least = center.abs().min(self.far);
        if least > 0.999 * self.far {
            return [least, f32::MAX];
        }
        let steepness = self.terms.steepness / self.lipschitz;
        [least, 1.000_01 * (least * steepness + self.terms.slack)]
    }

    /// Returns the value that a cell stores for a distance at its center.
    pub(super) fn center(&self, d: f32) -> f32 {
        let plain = self.terms.radius(d);
        let clear = if self.is_steady() {
            plain
        } else {
            let jumping = self.terms.with(&self.jumps);
            plain.min(jumping.radius(d.abs().min(self.far)).max(self.jumps.gap))
        };
        let left = (clear * self.lipschitz).clamp(0.0, self.far);
        if d < 0.0 { -left } else { left }
    }
}

/// Words that shaders need of a block besides its program.
pub const BLOCK_WORDS: usize = 7;

impl BrickLayout {
    /// Returns the words that shaders need of a block besides its program.
    pub fn block_words(
        &self,
        program: &Program,
        first: IVec3,
        instructions: &[Instruction],
    ) -> [f32; BLOCK_WORDS] {
        CellBounds::new(program, self)
            .of_block(self, first)
            .words(instructions)
    }
}

/// Bytes of a slot: its words, its mask, and its block's position.
pub(super) const SLOT_BYTES: u64 = 64 * 4 + 8 + 12;
