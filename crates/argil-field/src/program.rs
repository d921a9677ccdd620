use crate::jumps::JumpRegion;
use crate::materials::MaterialTable;
use crate::spans::{GroupSpan, OperandSpan};
use argil_abi::{self as abi, GpuMaterial, Instruction};
use argil_math::Aabb;
use argil_scene::Scene;

/// A scene lowered to instructions.
///
/// See the [crate page](crate) for how it works.
///
/// ```
/// use argil_field::Program;
/// use argil_scene::{Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(1.0) - Shape::cuboid([0.5; 3]))?;
/// let program = Program::lower(&scene)?;
/// assert_eq!(program.brush_count(), 2);
/// assert_eq!(program.lipschitz(), 1.0);
/// assert!(program.distance([0.0, 0.0, 0.0].into()) > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias = "tape")]
pub struct Program {
    pub(crate) instructions: Vec<Instruction>,
    pub(crate) params: Vec<f32>,
    pub(crate) materials: MaterialTable,
    pub(crate) aabb: Aabb,
    /// A power of two that no finite side of an operand's box exceeds.
    pub(crate) magnitude: f32,
    pub(crate) lipschitz: f32,
    pub(crate) slack: f32,
    pub(crate) hidden_slack: f32,
    pub(crate) isolation: f32,
    /// See `Regularity::underestimate`.
    pub(crate) underestimate: f32,
    /// Operands that contribute to `slack` and `hidden_slack`.
    pub(crate) loose: Vec<JumpRegion>,
    /// The pieces, if there are many, and the open groups that contain them.
    pub(crate) operands: Vec<OperandSpan>,
    pub(crate) groups: Vec<GroupSpan>,
    /// Whether all joints are hard unions, so that a distance is the least of those of the brushes.
    pub(crate) is_hard_union: bool,
    pub(crate) value_slots: usize,
    pub(crate) point_slots: usize,
    pub(crate) brushes: usize,
}

impl Default for Program {
    /// Returns the program of an empty scene.
    fn default() -> Self {
        Self {
            // A scene without materials names no image.
            materials: MaterialTable::of(&Scene::new()).unwrap_or_default(),
            ..Self::blank()
        }
    }
}

impl Program {
    /// Returns a program without anything, not even materials.
    pub(crate) const fn blank() -> Self {
        Self {
            instructions: Vec::new(),
            params: Vec::new(),
            materials: MaterialTable::BLANK,
            aabb: Aabb::EMPTY,
            magnitude: 0.0,
            lipschitz: 1.0,
            slack: 0.0,
            hidden_slack: 0.0,
            isolation: f32::INFINITY,
            underestimate: 1.0,
            loose: Vec::new(),
            operands: Vec::new(),
            groups: Vec::new(),
            is_hard_union: false,
            value_slots: 0,
            point_slots: 0,
            brushes: 0,
        }
    }

    /// Returns the instructions.
    pub fn instructions(&self) -> &[Instruction] {
        &self.instructions
    }

    /// Returns the words that instructions refer to.
    pub fn params(&self) -> &[f32] {
        &self.params
    }

    /// Returns the materials that brushes refer to. Never empty.
    pub fn materials(&self) -> &[GpuMaterial] {
        &self.materials.entries[..self.materials.materials]
    }

    /// Returns the materials, followed by the words of their textures: what shaders read.
    pub fn material_table(&self) -> &[GpuMaterial] {
        &self.materials.entries
    }

    /// Returns what each material has besides an entry of [`Program::material_table`], as shaders read it: as a base color
    /// transmission, the index of refraction and 1 / attenuation distance, as a roughness a height of 0, and its metalness. Empty
    /// if no material has glass or heights.
    pub fn material_extras(&self) -> Vec<GpuMaterial> {
        self.materials.extras_as_entries()
    }

    /// Returns whether a material has textures.
    pub fn has_textures(&self) -> bool {
        self.materials.entries.len() > self.materials.materials
    }

    /// Returns whether a material lets light through.
    pub fn has_glass(&self) -> bool {
        self.materials.has_glass
    }

    /// Returns the length over which heights of surfaces differ, if a material has a bump texture.
    pub fn bump_step(&self) -> Option<f32> {
        let step = self.materials.bump_step;
        (step > 0.0).then_some(step)
    }

    /// Returns a box that contains the solid. It may be infinite, or empty for an empty scene.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// Returns the Lipschitz constant of the distance: 1, or more with chamfers or meshes.
    pub fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Returns the slots that the stacks of values and of points need.
    pub fn stack_slots(&self) -> (usize, usize) {
        (self.value_slots, self.point_slots)
    }

    /// Returns the number of visible brushes.
    pub fn brush_count(&self) -> usize {
        self.brushes
    }

    /// Returns whether all joints are hard unions. Then the list of a cell may begin with any distance that is not less
    /// than the cell's own.
    pub fn is_hard_union(&self) -> bool {
        self.is_hard_union
    }

    /// Returns the bytes of the program's tables.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.instructions[..])
            + size_of_val(&self.params[..])
            + size_of_val(self.material_table())
    }

    /// Returns the maximum copies of a brush that a point evaluates, over all loops around it. 1 without loops.
    pub fn max_copies(&self) -> u64 {
        let (mut most, mut open) = (1, vec![1u64]);
        for instr in &self.instructions {
            if let Some(copies) = self.copies_of(instr) {
                let around = open.last().copied().unwrap_or(1);
                open.push(around.saturating_mul(copies));
                most = most.max(around.saturating_mul(copies));
            } else if instr.op == abi::OP_NEXT {
                open.pop();
            }
        }
        most
    }

    /// Returns the copies that a loop evaluates, if an instruction begins one.
    pub(crate) fn copies_of(&self, instr: &Instruction) -> Option<u64> {
        let word = |i: u32| {
            let word = self.params.get((instr.params + i) as usize);
            word.copied().unwrap_or(0.0) as u64
        };
        match instr.op {
            abi::OP_REPEAT => Some(word(12) * word(13) * word(14)),
            abi::OP_RADIAL => Some(word(2)),
            _ => None,
        }
    }
}
