//! Finds the instructions that can matter in a cell.

use crate::Program;
use crate::eval_brush::BrushParams;
use crate::evaluate::run_parallel;
use crate::interpreter::Carried;
use crate::interpreter_state::Loan;
use crate::marks::{CELLS_PER_BATCH, CellMarks, Marks};
use crate::pruned_writer::{PrunedWriter, RUN};
use crate::scalar::SIMD_BLOCK;
use argil_abi::{self as abi, Instruction};
use argil_math::Aabb;
use glam::{DVec3, Vec3};

const _: () =
    assert!(CELLS_PER_BATCH.is_multiple_of(SIMD_BLOCK) && CELLS_PER_BATCH == u64::BITS as usize);

/// A list of hard unions of more instructions is measured before it is classified.
const LONG: usize = 256;

/// Prunes a program for one thread. Create one per thread and keep it.
///
/// *Theory.* Distances change by at most the Lipschitz constant times the way. In a sphere of radius R around a
/// point, an operand that loses there by more than 2·L·R and the blend radius loses everywhere, and the joint
/// returns the winner, bit for bit (Barbier et al., "Lipschitz pruning: hierarchical simplification of
/// primitive-based SDFs", 2025). A cell's pruned program is the program of its children, and so on.
///
/// *Practice.* [`Pruner::classify_cells`] measures up to [`CELLS_PER_BATCH`] cells that share a program, one per
/// lane. [`Pruner::prune_into`] writes the pruned program of one of them. Unlike in the paper, the program is a
/// flat list with frames and groups. An empty frame is dropped too. Loops over copies stay whole, and report their
/// largest jump. A cut or an intersection never drops what it cuts, because its material may show. A union drops
/// either operand.
///
/// ```
/// use argil_field::{Program, Pruner};
/// use argil_scene::{Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(0.5))?;
/// scene.push(Shape::sphere(0.5).at([10.0, 0.0, 0.0]))?;
/// let program = Program::lower(&scene)?;
/// let mut pruner = Pruner::new(&program);
/// let mut distance = [0.0];
/// pruner.classify_cells(program.instructions(), &[[0.5, 0.0, 0.0].into()], 0.1, &mut distance);
/// let mut pruned = Vec::new();
/// pruner.prune_into(program.instructions(), 0, &mut pruned);
/// assert_eq!((program.instructions().len(), pruned.len()), (2, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Pruner<'a> {
    program: &'a Program,
    registers: Loan<f32>,
    writer: PrunedWriter,
    /// What centers are relative to.
    origin: Option<DVec3>,
    /// For each [`RUN`] of instructions, the cells in which all of them are dropped.
    skipped: Vec<u64>,
}

impl<'a> Pruner<'a> {
    /// Creates a pruner of a program.
    pub fn new(program: &'a Program) -> Self {
        Self {
            program,
            registers: Loan::new(),
            origin: None,
            writer: PrunedWriter::of(program),
            skipped: Vec::new(),
        }
    }

    /// Sets what the centers of cells are relative to from now on: see [`Evaluator::set_origin`](crate::Evaluator::set_origin).
    pub fn set_origin(&mut self, origin: Option<DVec3>) {
        self.origin = origin;
    }

    /// Classifies cells with one half diagonal that share a program. Computes the distances at their centers into
    /// `out`.
    ///
    /// # Panics
    /// If there are more than [`CELLS_PER_BATCH`] cells, or `out` has another length.
    pub fn classify_cells(
        &mut self,
        instructions: &[Instruction],
        centers: &[Vec3],
        half_diagonal: f32,
        out: &mut [f32],
    ) {
        assert!(centers.len() <= CELLS_PER_BATCH && centers.len() == out.len());
        let r = &mut *self.registers;
        let Some(&last) = centers.last() else { return };
        r.active = centers.len().next_multiple_of(SIMD_BLOCK);
        for (axis, lanes) in r.point.iter_mut().enumerate() {
            lanes.0.fill(last[axis]);
            for (lane, center) in lanes.0.iter_mut().zip(centers) {
                *lane = center[axis];
            }
        }
        let region = Aabb::around(centers.iter().copied()).grown(half_diagonal);
        let farthest = self
            .program
            .rounding_coordinate(instructions, region, self.origin);
        let change = self.program.lipschitz() * half_diagonal * 1.000_01;
        r.margin = 2.0 * (change + self.program.list_slack(instructions, farthest));
        r.origin = self.origin;
        r.marks.clear();
        r.marks.resize(instructions.len(), Marks::default());
        if self.program.is_hard_union && instructions.len() > LONG {
            // Without the final distances, what comes early in a list is compared with more than those.
            let points = r.point.clone();
            run_parallel(self.program, instructions, r, Carried::Nothing);
            (r.point, r.continues) = (points, true);
        }
        run_parallel(self.program, instructions, r, Carried::Marks);
        r.continues = false;
        out.copy_from_slice(&r.acc.0[..centers.len()]);
        self.skip_runs(instructions);
    }

    /// Finds what cells skip.
    fn skip_runs(&mut self, instructions: &[Instruction]) {
        let marks = &self.registers.marks;
        self.skipped.clear();
        // The cells that drop the groups around an instruction, innermost last.
        let mut groups = vec![0u64];
        let runs = instructions.chunks(RUN).zip(marks.chunks(RUN));
        for (instructions, marks) in runs {
            let mut skipped = u64::MAX;
            for (instr, marks) in instructions.iter().zip(marks) {
                let around = groups.last().copied().unwrap_or(0);
                skipped &= match instr.op {
                    op if op < abi::OP_SHAPES_END => marks.drop_b | around,
                    abi::OP_PUSH_VALUE => {
                        groups.push(around | marks.drop_b);
                        around | marks.drop_b
                    }
                    abi::OP_COMBINE => groups.pop().unwrap_or(0),
                    _ => around,
                };
            }
            // What follows must not be in a dropped group.
            let open = groups.last().copied().unwrap_or(0);
            self.skipped.push(skipped & !open);
        }
    }

    /// Returns what the last [`Pruner::classify_cells`] found for the first eight cells, for
    /// [`Pruner::prune_marked_into`].
    pub fn cell_marks(&self) -> CellMarks {
        let marks = self.registers.marks.iter();
        CellMarks {
            marks: marks
                .map(|mark| [mark.drop_a as u8, mark.drop_b as u8])
                .collect(),
            skipped: self.skipped.iter().map(|&skipped| skipped as u8).collect(),
        }
    }

    /// Returns a bit mask of the cells, from the last [`Pruner::classify_cells`], whose distance may depend on one
    /// of the selected instructions.
    ///
    /// If two programs differ only in those instructions, and a cell's bit is clear for both, their distances in
    /// that cell are bit-equal. Then each selected instruction either does not matter, or it adds and a later brush
    /// covers it. Joints are monotone in what comes before them, so that brush also covers it in the other program.
    /// Subtractive brushes always count, because removing one brings the surface nearer.
    ///
    /// # Panics
    /// If `instructions` is not the classified program.
    pub fn affected_cells(
        &self,
        instructions: &[Instruction],
        is_one: impl Fn(&Instruction) -> bool,
    ) -> u64 {
        let mut needed = 0;
        self.for_each_affected(instructions, is_one, |cells| needed |= cells);
        needed
    }

    /// Returns how many of the selected instructions may matter in a cell.
    ///
    /// # Panics
    /// If `instructions` is not the classified program.
    pub fn affected_count(
        &self,
        instructions: &[Instruction],
        cell: usize,
        is_one: impl Fn(&Instruction) -> bool,
    ) -> usize {
        let mut count = 0;
        self.for_each_affected(instructions, is_one, |cells| {
            count += (cells >> cell & 1) as usize
        });
        count
    }

    /// Calls `visit` with each selected instruction, and the cells in which it may matter.
    fn for_each_affected(
        &self,
        instructions: &[Instruction],
        is_one: impl Fn(&Instruction) -> bool,
        mut tell: impl FnMut(u64),
    ) {
        let marks = &self.registers.marks;
        assert_eq!(marks.len(), instructions.len(), "the list that was marked");
        // Cells in which a later brush covers everything before it in the same group.
        let mut wiped = 0;
        for (instr, marks) in instructions.iter().zip(marks).rev() {
            if instr.op >= abi::OP_SHAPES_END {
                wiped = 0;
                if is_one(instr) {
                    tell(u64::MAX);
                }
                continue;
            }
            if is_one(instr) {
                let joint = BrushParams::read(&self.program.params, instr.params as usize).joint;
                let adds = joint.sa > 0.0 && joint.sb > 0.0;
                tell(!(marks.drop_b | if adds { wiped } else { 0 }));
            }
            wiped |= marks.drop_a & !marks.drop_b;
        }
    }

    /// Appends the pruned program of cell `cell` to `out`. In the cell, its distances are bit-equal to those of the
    /// classified program.
    ///
    /// # Panics
    /// If `instructions` is not the classified program.
    #[doc(alias = "simplify")]
    pub fn prune_into(
        &mut self,
        instructions: &[Instruction],
        cell: usize,
        out: &mut Vec<Instruction>,
    ) {
        let marks = &self.registers.marks;
        assert_eq!(marks.len(), instructions.len(), "the list that was marked");
        let bit = |mask: u64| mask >> cell & 1 != 0;
        let drops = |at: usize| (bit(marks[at].drop_a), bit(marks[at].drop_b));
        let skips = |run: usize| bit(self.skipped[run]);
        self.writer.prune(instructions, drops, skips, out);
    }

    /// Does the same as [`Pruner::prune_into`] with what [`Pruner::cell_marks`] returned for a program, one of the first
    /// eight cells, and no new classification.
    ///
    /// # Panics
    /// If the marks are not those of as many instructions.
    pub fn prune_marked_into(
        &mut self,
        instructions: &[Instruction],
        CellMarks { marks, skipped }: &CellMarks,
        cell: usize,
        out: &mut Vec<Instruction>,
    ) {
        assert_eq!(marks.len(), instructions.len(), "the list that was marked");
        let bit = |mask: u8| mask >> cell & 1 != 0;
        let drops = |at: usize| {
            let [drop_a, drop_b] = marks[at];
            (bit(drop_a), bit(drop_b))
        };
        let skips = |run: usize| bit(skipped[run]);
        self.writer.prune(instructions, drops, skips, out);
    }
}
