//! The program of a world, and what queries derive from it when first asked.

use crate::edit_session::EditSession;
use argil_field::{OperandIndex, PartGrid, Program, ProgramTree};
use argil_math::Aabb;
use std::sync::OnceLock;

/// Parts along the longest side in which queries find nearby operands. Distances are exact within as many of them.
const QUERY_PARTS: f32 = 24.0;
const QUERY_REACH: f32 = 3.0;

/// A program, and what queries derive from it when first asked.
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
    /// Returns the cache. While edits apply in place, the program is put together when it is first needed.
    pub(crate) fn of<'a>(program: &'a OnceLock<Self>, live: &EditSession) -> &'a Self {
        program.get_or_init(|| {
            let whole = live.to_program();
            whole.expect("a program, or one that is followed").into()
        })
    }

    /// Returns the box that queries cover: the solid's, or `focus` for an infinite one.
    fn held(&self, focus: impl FnOnce() -> Aabb) -> Aabb {
        let held = self.program.aabb();
        if held.is_finite() { held } else { focus() }
    }

    /// Returns the tree of pruned programs, for a program that is neither short nor very long.
    pub(crate) fn list_tree(&self, focus: impl FnOnce() -> Aabb) -> Option<&ProgramTree> {
        let make = || ProgramTree::new(&self.program, self.held(focus));
        self.tree.get_or_init(make).as_ref()
    }

    /// Returns the index over operands, for a program of many pieces. `focus` replaces the box of an infinite solid.
    pub(crate) fn operand_index(&self, focus: impl FnOnce() -> Aabb) -> Option<&OperandIndex> {
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
