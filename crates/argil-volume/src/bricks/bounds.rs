//! How much distances can be off, and change, in cells and blocks.

use super::layout::BrickLayout;
use argil_abi::Instruction;
use argil_field::{ClearanceModel, NearJumps, Program};
use argil_math::Aabb;
use glam::{IVec3, Vec3};

/// What of distances can be relied on.
#[derive(Clone, Copy)]
pub(super) struct CellBounds<'a> {
    pub program: &'a Program,
    terms: ClearanceModel,
    jumps: NearJumps,
    base: f32,
    lipschitz: f32,
    /// The greatest distance that a cell keeps.
    far: f32,
}

impl<'a> CellBounds<'a> {
    /// Near the origin, where nothing jumps.
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

    /// In a cube with a middle: of what those tell that are for the origin.
    pub(super) fn about(&self, center: Vec3, half: f32) -> Self {
        let farthest = center.abs().max_element() + 3f32.sqrt() * half;
        let cube = Aabb::new(center - half, center + half);
        Self {
            terms: self.terms.at(self.base, farthest),
            jumps: self.program.jumps_near(cube, self.far),
            ..*self
        }
    }

    /// Of a block with a first cell.
    pub(super) fn of_block(&self, layout: &BrickLayout, first: IVec3) -> Self {
        let center = layout.center(first, super::BLOCK_SIDE);
        self.about(
            center,
            0.5 * layout.cell_length() * super::BLOCK_SIDE as f32,
        )
    }

    /// For shaders, where a list gives the distances: what rounding adds to them, how far away what jumps is, and how it does;
    /// then by how much the list can jump.
    fn words(&self, instrs: &[Instruction]) -> [f32; BLOCK_WORDS] {
        let jumps = &self.jumps;
        [
            self.terms.slack,
            jumps.gap,
            jumps.slack,
            jumps.hidden,
            jumps.isolation,
            self.program.jump_of(instrs),
        ]
    }

    /// Whether there is no surface within `radius`, as far as that is within the cube.
    pub(super) fn is_clear(&self, d: f32, radius: f32) -> bool {
        let terms = if self.jumps.gap > 0.0 {
            self.terms
        } else {
            self.terms.with(&self.jumps)
        };
        // Lists of edits do not tell what is farther.
        terms.radius(d.abs().min(self.far)) > radius
    }

    /// Whether it is only for what jumps that it is not [clear](Self::is_clear).
    pub(super) fn is_doubtful(&self, d: f32, radius: f32) -> bool {
        self.jumps.gap <= 0.0 && self.terms.radius(d.abs().min(self.far)) > radius
    }

    /// Whether all of the cube, which is within `radius`, is farther from the surface than cells tell.
    pub(super) fn is_far(&self, d: f32, radius: f32) -> bool {
        self.is_steady() && (self.terms.radius(d) - 1.000_01 * radius) * self.lipschitz >= self.far
    }

    /// The greatest length of a distance that is not [clear](Self::is_clear), where nothing jumps.
    pub(super) fn unclear_length(&self, radius: f32) -> f32 {
        1.000_01 * (radius * self.terms.steepness + self.terms.slack)
    }

    /// The length up to which distances at cells' centers decide what their bricks hold, where nothing jumps: those of the others
    /// are clear of the surface, or stored as the end of the range. Materials count nearer to the surface only.
    pub(super) fn near_length(&self, layout: &BrickLayout) -> f32 {
        let range = layout.encoding.band_width(&layout.voxel_grid, 0);
        self.unclear_length(layout.half_diagonal(1)).max(range)
    }

    /// Whether nothing jumps as far away as cells tell.
    pub(super) fn is_steady(&self) -> bool {
        self.jumps.gap == f32::MAX
    }

    /// The lengths that a distance can have of which a cell [keeps](Self::center) so much, where nothing jumps.
    pub(super) fn lengths(&self, center: f32) -> [f32; 2] {
        let least = center.abs().min(self.far);
        if least > 0.999 * self.far {
            return [least, f32::MAX];
        }
        let steepness = self.terms.steepness / self.lipschitz;
        [least, 1.000_01 * (least * steepness + self.terms.slack)]
    }

    /// What a cell keeps whose center is so far.
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

/// Words that shaders need of a block besides its list.
pub const BLOCK_WORDS: usize = 6;

impl BrickLayout {
    /// What shaders need of a block with a first cell, besides its list.
    pub fn block_words(
        &self,
        program: &Program,
        first: IVec3,
        instrs: &[Instruction],
    ) -> [f32; BLOCK_WORDS] {
        CellBounds::new(program, self)
            .of_block(self, first)
            .words(instrs)
    }
}

/// Bytes that a slot takes: its words, its mask, and which block it has.
pub(super) const SLOT_BYTES: u64 = 64 * 4 + 8 + 12;
