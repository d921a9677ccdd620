//! Finds the instructions that can matter in a cell.

use crate::Program;
use crate::bounded_group::end_of_group;
use crate::curves::SIMD_BLOCK;
use crate::eval_brush::BrushParams;
use crate::evaluate::run_parallel;
use crate::interpreter::Carried;
use crate::interpreter_state::Loan;
use crate::marks::{CELLS_PER_BATCH, CellMarks, Marks};
use argil_abi::{self as abi, Instruction};
use argil_math::Aabb;
use glam::Vec3;

const _: () =
    assert!(CELLS_PER_BATCH.is_multiple_of(SIMD_BLOCK) && CELLS_PER_BATCH == u64::BITS as usize);

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
    /// For each [`RUN`] of instructions, the cells in which all of them are dropped.
    skipped: Vec<u64>,
}

/// Instructions that a cell skips at once, because most of a long program is dropped.
const RUN: usize = 8;

impl<'a> Pruner<'a> {
    /// Creates a pruner of a program.
    pub fn new(program: &'a Program) -> Self {
        Self {
            program,
            registers: Loan::new(),
            writer: PrunedWriter::default(),
            skipped: Vec::new(),
        }
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
        let change = self.program.lipschitz() * half_diagonal * 1.000_01;
        r.margin = 2.0 * (change + self.program.list_slack(instructions, region));
        r.marks.clear();
        r.marks.resize(instructions.len(), Marks::default());
        run_parallel(self.program, instructions, r, Carried::Marks);
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
                .map(|own| [own.drop_a as u8, own.drop_b as u8])
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

/// Points each end of a loop at its beginning, which has moved.
fn close_loops(instructions: &mut [Instruction]) {
    let mut open = Vec::new();
    for (at, instr) in instructions.iter_mut().enumerate() {
        match instr.op {
            abi::OP_REPEAT | abi::OP_RADIAL => open.push(at as u32),
            abi::OP_NEXT => instr.operand = open.pop().expect("each end of a loop has a beginning"),
            _ => {}
        }
    }
}

/// The state of writing a pruned program.
#[derive(Debug, Default)]
struct PrunedWriter {
    /// The beginning of what is in the accumulator.
    segment: usize,
    /// For each saved value: its beginning, and where it was saved.
    saved: Vec<(usize, usize)>,
    /// Open frames: where each was opened, and whether anything was measured in it.
    frames: Vec<(usize, bool)>,
    /// Scratch memory of [`PrunedWriter::erase`].
    kept: Vec<Instruction>,
}

impl PrunedWriter {
    /// Appends the pruned program. `drops` tells for an instruction whether what is before it is dropped, and whether
    /// it is itself. `skips` tells whether a run of instructions is.
    #[inline(always)]
    fn prune(
        &mut self,
        instructions: &[Instruction],
        drops: impl Fn(usize) -> (bool, bool),
        skips: impl Fn(usize) -> bool,
        out: &mut Vec<Instruction>,
    ) {
        let begin = out.len();
        self.clear(begin);
        let mut at = 0;
        while let Some(instr) = instructions.get(at) {
            if at.is_multiple_of(RUN) && skips(at / RUN) {
                at += RUN;
                continue;
            }
            let (drop_a, drop_b) = drops(at);
            at += 1;
            if drop_b && instr.op < abi::OP_SHAPES_END {
                continue;
            }
            match instr.op {
                abi::OP_REPEAT | abi::OP_RADIAL => {
                    // A loop stays whole.
                    let mut open = 1;
                    out.push(*instr);
                    while open > 0
                        && let Some(inner) = instructions.get(at)
                    {
                        at += 1;
                        match inner.op {
                            abi::OP_REPEAT | abi::OP_RADIAL => open += 1,
                            abi::OP_NEXT => open -= 1,
                            _ => {}
                        }
                        out.push(*inner);
                    }
                    self.has_value();
                }
                op if op < abi::OP_SHAPES_END => self.brush(*instr, drop_a, drop_b, out),
                abi::OP_COMBINE => self.combine(*instr, drop_a, drop_b, out),
                abi::OP_PUSH_VALUE if drop_b => {
                    // A bounded group that is too far.
                    at = end_of_group(instructions, at - 1).map_or(at, |end| end + 1);
                }
                abi::OP_PUSH_VALUE => self.push_value(*instr, out),
                abi::OP_PUSH_POINT | abi::OP_TWIST | abi::OP_BEND => self.open(*instr, out),
                abi::OP_POP_POINT | abi::OP_UNCLAMP => self.close(*instr, out),
                _ => out.push(*instr),
            }
        }
        close_loops(&mut out[begin..]);
    }

    fn clear(&mut self, begin: usize) {
        self.segment = begin;
        self.saved.clear();
        self.frames.clear();
    }

    fn has_value(&mut self) {
        if let Some((_, has_value)) = self.frames.last_mut() {
            *has_value = true;
        }
    }

    fn brush(
        &mut self,
        instr: Instruction,
        drop_a: bool,
        drop_b: bool,
        out: &mut Vec<Instruction>,
    ) {
        if drop_b {
            return;
        }
        if drop_a {
            self.erase(self.segment, out.len(), out);
        }
        out.push(instr);
        self.has_value();
    }

    fn push_value(&mut self, instr: Instruction, out: &mut Vec<Instruction>) {
        self.saved.push((self.segment, out.len()));
        out.push(instr);
        self.segment = out.len();
    }

    fn combine(
        &mut self,
        instr: Instruction,
        drop_a: bool,
        drop_b: bool,
        out: &mut Vec<Instruction>,
    ) {
        let Some((begin, pushed)) = self.saved.pop() else {
            return;
        };
        let is_swapped = instr.flags & abi::FLAG_SWAPPED != 0;
        let (drop_saved, drop_current) = if is_swapped {
            (drop_b, drop_a)
        } else {
            (drop_a, drop_b)
        };
        if drop_current {
            // All frames within it are closed.
            out.truncate(pushed);
        } else if drop_saved {
            self.erase(begin, pushed + 1, out);
        } else {
            out.push(instr);
        }
        self.has_value();
        self.segment = begin;
    }

    fn open(&mut self, instr: Instruction, out: &mut Vec<Instruction>) {
        self.frames.push((out.len(), false));
        out.push(instr);
    }

    fn close(&mut self, instr: Instruction, out: &mut Vec<Instruction>) {
        match self.frames.pop() {
            Some((begin, false)) => out.truncate(begin),
            _ => {
                out.push(instr);
                self.has_value();
            }
        }
    }

    /// Removes what a range of the program measured. Open frames stay, with what moves their point.
    fn erase(&mut self, begin: usize, end: usize, out: &mut Vec<Instruction>) {
        self.kept.clear();
        let mut closed = 0;
        let mut frame = self.frames.len();
        for at in (begin..end).rev() {
            let instr = out[at];
            let stays = match instr.op {
                abi::OP_POP_POINT | abi::OP_UNCLAMP | abi::OP_NEXT => {
                    closed += 1;
                    false
                }
                abi::OP_PUSH_POINT
                | abi::OP_TWIST
                | abi::OP_BEND
                | abi::OP_REPEAT
                | abi::OP_RADIAL => {
                    if closed > 0 {
                        closed -= 1;
                        false
                    } else {
                        // An open frame: its position relative to the range's new end.
                        frame = frame.saturating_sub(1);
                        if let Some(open) = self.frames.get_mut(frame) {
                            *open = (self.kept.len(), false);
                        }
                        true
                    }
                }
                abi::OP_AFFINE | abi::OP_MIRROR | abi::OP_ELONGATE => closed == 0,
                _ => false,
            };
            if stays {
                self.kept.push(instr);
            }
        }
        let kept = self.kept.len();
        for (at, _) in &mut self.frames[frame..] {
            *at = begin + kept - 1 - *at;
        }
        out.splice(begin..end, self.kept.drain(..).rev());
    }
}
