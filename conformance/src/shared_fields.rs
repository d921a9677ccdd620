//! Fields of a GPU that cases share. A software device compiles an interpreter for seconds, and runs all of its cases for
//! every sample.

use crate::SceneCase;
use argil_field::{OpcodeSet, Program};
use argil_gpu::{Gpu, GpuProgram};
use std::sync::Arc;

/// Lowers cases. Those with the most opcodes come first, so that others can run with their interpreters.
pub fn by_opcodes(cases: Vec<SceneCase>) -> Vec<(SceneCase, Program)> {
    let lowered = cases.into_iter().map(|case| {
        let program = Program::lower(&case.scene).expect("a program");
        (case, program)
    });
    let mut all: Vec<_> = lowered.collect();
    all.sort_by_key(|(_, program)| std::cmp::Reverse(count(OpcodeSet::of(program))));
    all
}

fn count(opcodes: OpcodeSet) -> usize {
    (0..128).filter(|&op| opcodes.contains(op)).count()
}

/// How many opcodes an interpreter may have that a program does not need.
const SPARE: usize = 3;

/// Fields, each for programs whose opcodes are among those of its first one.
#[derive(Debug)]
pub struct SharedFields {
    gpu: Arc<Gpu>,
    all: Vec<(OpcodeSet, GpuProgram)>,
}

impl SharedFields {
    /// Creates none yet.
    pub fn new(gpu: Arc<Gpu>) -> Self {
        let all = Vec::new();
        Self { gpu, all }
    }

    /// Returns the field with the fewest opcodes that runs a program, with this program. Creates it if there is none.
    pub fn running(&mut self, program: &Program) -> &GpuProgram {
        let needed = OpcodeSet::of(program);
        let able = |index: &usize| {
            let all = self.all[*index].0;
            all.is_superset(needed) && count(all) <= count(needed) + SPARE
        };
        let able = (0..self.all.len()).filter(able);
        let index = able.min_by_key(|&index| count(self.all[index].0));
        let index = index.unwrap_or_else(|| {
            let field = GpuProgram::new(self.gpu.clone(), program, false);
            self.all.push((needed, field.expect("a field")));
            self.all.len() - 1
        });
        let field = &mut self.all[index].1;
        field.update(program).expect("a field");
        field
    }
}
