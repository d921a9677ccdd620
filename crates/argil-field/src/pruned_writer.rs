//! Writes pruned programs.

use crate::Program;
use crate::bounded_group::end_of_group;
use argil_abi::{self as abi, Instruction};

/// Instructions that a cell skips at once, because most of a long program is dropped.
pub(crate) const RUN: usize = 8;

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
pub(crate) struct PrunedWriter {
    /// The beginning of what is in the accumulator.
    segment: usize,
    /// For each saved value: its beginning, and where it was saved.
    saved: Vec<(usize, usize)>,
    /// Open frames: where each was opened, and whether anything was measured in it.
    frames: Vec<(usize, bool)>,
    /// Scratch memory of [`PrunedWriter::erase`].
    kept: Vec<Instruction>,
    /// Whether groups can be empty: all joints are unions, so that nothing misses them.
    has_unions_only: bool,
}

impl PrunedWriter {
    pub(crate) fn of(program: &Program) -> Self {
        Self {
            has_unions_only: program.is_hard_union,
            ..Self::default()
        }
    }

    /// Appends the pruned program. `drops` tells for an instruction whether what is before it is dropped, and whether
    /// it is itself. `skips` tells whether a run of instructions is.
    #[inline(always)]
    pub(crate) fn prune(
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
                op if abi::saves_point(op) => self.open(*instr, out),
                op if abi::restores_point(op) => self.close(*instr, out),
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
        if self.has_unions_only && out.len() == pushed + 1 {
            out.truncate(pushed);
            self.segment = begin;
            return;
        }
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
                op if op == abi::OP_NEXT || abi::restores_point(op) => {
                    closed += 1;
                    false
                }
                op if matches!(op, abi::OP_REPEAT | abi::OP_RADIAL) || abi::saves_point(op) => {
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
                op => abi::moves_point(op) && closed == 0,
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
