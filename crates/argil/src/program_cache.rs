//! The program of a world, and what is made of it when it is first asked for.

use crate::edit_session::EditSession;
use argil_field::{OperandIndex, PartGrid, Program, ProgramTree};
use argil_math::Aabb;
use std::sync::OnceLock;

/// Parts along the longest side of a world in which queries look for what is near, and how many of them far they tell distances.
const QUERY_PARTS: f32 = 24.0;
const QUERY_REACH: f32 = 3.0;

/// A program, and what is made of it for queries when they are first asked.
#[derive(Debug)]
pub(crate) struct ProgramCache {
    pub program: Program,
    index: OnceLock<Option<OperandIndex>>,
    tree: OnceLock<Option<ProgramTree>>,
}

impl From<Program> for ProgramCache {
    fn from(program: Program) -> Self {
        Self {
            program,
            index: OnceLock::new(),
            tree: OnceLock::new(),
        }
    }
}

impl ProgramCache {
    /// While edits are followed in place, the program is put together when it is asked for.
    pub(crate) fn of<'a>(program: &'a OnceLock<Self>, live: &EditSession) -> &'a Self {
        program.get_or_init(|| {
            let whole = live.to_program();
            whole.expect("a program, or one that is followed").into()
        })
    }

    /// The box that is asked about: the solid's, or `focus` of one without end.
    fn held(&self, focus: Aabb) -> Aabb {
        let held = self.program.aabb();
        if held.is_finite() { held } else { focus }
    }

    /// What can matter near a point, of a program that is neither short nor very long.
    pub(crate) fn list_tree(&self, focus: Aabb) -> Option<&ProgramTree> {
        let make = || ProgramTree::new(&self.program, self.held(focus));
        self.tree.get_or_init(make).as_ref()
    }

    /// What is near where in the program, of one with many pieces. `focus` is the box of one without end.
    pub(crate) fn operand_index(&self, focus: Aabb) -> Option<&OperandIndex> {
        let make = || {
            let held = self.held(focus);
            let size = held.size().max_element();
            let parts = PartGrid {
                corner: held.min,
                edge: size / QUERY_PARTS,
                far: QUERY_REACH * size / QUERY_PARTS,
                base: size,
            };
            (size > 0.0 && size.is_finite())
                .then(|| OperandIndex::new(&self.program, parts))
                .flatten()
        };
        self.index.get_or_init(make).as_ref()
    }
}
