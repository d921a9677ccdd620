//! Whole programs as lists for three points of a column at once. Twin of column_lists.wgsl.

use crate::Program;
use crate::column_wgsl::{MAX_SLOTS, QUICK, SHAPES};
use argil_abi::{self as abi, Instruction};

impl Program {
    /// Returns the program's length, and its instructions as words for `column_distances` in
    /// [`crate::Interpreter::column_wgsl`]. Returns `None` if one of them is not common, or if it saves too many values.
    ///
    /// ```
    /// use argil_field::Program;
    /// use argil_scene::{Brush, Scene, Shape};
    /// let mut scene = Scene::new();
    /// scene.push(Brush::new(Shape::sphere(0.5)))?;
    /// assert!(Program::lower(&scene)?.column_words().is_some());
    /// scene.push(Brush::new(Shape::Octahedron { radius: 0.5 }))?;
    /// assert!(Program::lower(&scene)?.column_words().is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn column_words(&self) -> Option<Vec<u32>> {
        let mut words = vec![self.instructions.len() as u32];
        let (mut depth, mut most) = (0u32, 0u32);
        for instr in &self.instructions {
            match instr.op {
                abi::OP_PUSH_VALUE => depth += 1,
                abi::OP_COMBINE => depth = depth.saturating_sub(1),
                _ => {}
            }
            most = most.max(depth);
            words.push(self.column_word(instr)?);
        }
        // The word after the last one is loaded, too.
        words.push(0);
        (most <= MAX_SLOTS && words.len() > 2).then_some(words)
    }

    fn column_word(&self, instr: &Instruction) -> Option<u32> {
        let record = instr.params / abi::PARAMS_ALIGNMENT;
        if record >= 1 << (u32::BITS - abi::COLUMN_RECORD_SHIFT) {
            return None;
        }
        let word = instr.op | record << abi::COLUMN_RECORD_SHIFT;
        let flag = |flag: u32, on: bool| if on { flag } else { 0 };
        match instr.op {
            op if SHAPES.contains(&op) => {
                let joint: &[f32] = self.params.get(instr.params as usize + 13..)?;
                let &[_, _, sa, sb, ..] = joint else {
                    return None;
                };
                let is_moved = instr.flags & abi::FLAG_TRANSLATION != 0;
                Some(
                    word | flag(abi::COLUMN_UNION, sa > 0.0 && sb > 0.0)
                        | flag(abi::COLUMN_TRANSLATION, is_moved)
                        | flag(abi::COLUMN_QUICK, is_moved && QUICK.contains(&op)),
                )
            }
            abi::OP_COMBINE if instr.flags & abi::COMBINE_MASK == abi::COMBINE_SMOOTH => {
                Some(word | flag(abi::COLUMN_SWAPPED, instr.flags & abi::FLAG_SWAPPED != 0))
            }
            abi::OP_PUSH_VALUE | abi::OP_ROUND | abi::OP_SHELL => Some(word),
            _ => None,
        }
    }
}
