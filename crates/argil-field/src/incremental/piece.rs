//! The pieces of an incremental program, and how they are lowered.

use super::groups::GroupPosition;
use crate::lower::{EnclosingGroup, extent_in_world};
use crate::pieces::{ROOT, is_open, ramp_overshoot, scale_of, scaled};
use crate::places::place_words_of;
use crate::program::Program;
use crate::regularity::Regularity;
use crate::{LowerError, OpcodeSet};
use argil_abi::Instruction;
use argil_scene::{BlendProfile, Extent, Extents, NodeId, Operator, OperatorKind, Scene};

/// A piece.
#[derive(Debug)]
pub(super) struct Operand {
    /// Its place in the order.
    pub rank: u64,
    /// The open group that contains it.
    pub group: u32,
    /// Whether that group and all around it add.
    pub group_adds: bool,
    pub instructions: Vec<Instruction>,
    /// Its parameters, until they are stored in the table.
    pub own_params: Vec<f32>,
    /// Its range of the parameters.
    pub params: (u32, u32),
    /// Its operator, in the scene's unit.
    pub operator: Operator,
    /// Whether it is visible and has content.
    pub takes_part: bool,
    /// Its extent, in the scene's space.
    pub extent: Extent,
    pub regularity: Regularity,
    /// See [`PieceInfo`](crate::pieces::PieceInfo).
    pub overshoot: f32,
    pub magnitude: f32,
    pub slots: (usize, usize),
    pub brushes: usize,
    pub opcodes: OpcodeSet,
    pub iterations: u64,
}

impl Operand {
    pub(super) fn is_chamfered(&self) -> bool {
        self.operator.profile == BlendProfile::Chamfer && self.operator.blend > 0.0
    }

    /// Whether it can add to the solid.
    pub(super) fn adds(&self) -> bool {
        self.takes_part
            && self.group_adds
            && matches!(
                self.operator.kind,
                OperatorKind::Union | OperatorKind::Morph
            )
    }

    /// Whether it is infinite, or clips infinite solids.
    pub(super) fn ends(&self) -> bool {
        let is_infinite =
            self.adds() && !self.extent.aabb.is_empty() && !self.extent.aabb.is_finite();
        is_infinite || (self.takes_part && self.operator.kind == OperatorKind::Intersect)
    }

    /// Whether another piece has the same instructions, apart from the values of parameters.
    pub(super) fn same_structure(&self, other: &Self) -> bool {
        let relative = |operand: &Self, instr: &Instruction| Instruction {
            params: instr.params - operand.params.0,
            ..*instr
        };
        self.takes_part == other.takes_part
            && self.group == other.group
            && self.params.1 == other.params.1
            && self.instructions.len() == other.instructions.len()
            && self
                .instructions
                .iter()
                .zip(&other.instructions)
                .all(|(a, b)| relative(self, a) == relative(other, b))
    }

    /// Returns the range of each instruction's words among its own, with the place in front of a map.
    pub(super) fn stretches(&self) -> Vec<(u32, u32)> {
        let mut begins: Vec<u32> = self
            .instructions
            .iter()
            .map(|instr| instr.params - self.params.0 - place_words_of(instr))
            .collect();
        begins.push(self.params.1);
        begins.sort_unstable();
        begins.dedup();
        begins.windows(2).map(|pair| (pair[0], pair[1])).collect()
    }

    /// Whether the regularity of the whole scene cannot depend on it.
    pub(super) fn is_plain(&self) -> bool {
        !self.takes_part || (self.regularity == Regularity::SMOOTH && !self.is_chamfered())
    }
}

/// A step of walking through a node's pieces.
pub(super) enum PieceItem {
    Piece(NodeId, Box<Operand>),
    /// Enters an open group with its operator in the scene's unit, and its unit in that of the surrounding group.
    Enter(NodeId, EnclosingGroup, Operator, f32),
    Leave,
}

/// Lowers a node into a place.
pub(super) fn lower_into(
    scene: &Scene,
    extents: &mut Extents<'_>,
    node: NodeId,
    place: &GroupPosition,
    items: &mut Vec<PieceItem>,
) -> Result<(), LowerError> {
    if !is_open(scene, node, place.depth) {
        let operand = lowered(scene, extents, node, place)?;
        items.push(PieceItem::Piece(node, Box::new(operand)));
        return Ok(());
    }
    let entry = scene.node(node).at_current_time();
    let around = EnclosingGroup::of(scene, node, place.frame)?;
    let scale = scale_of(entry);
    let inside = GroupPosition {
        frame: around.frame,
        scale: place.scale * scale,
        depth: place.depth + 1,
        ..*place
    };
    let operator = scaled(&entry.operator, place.scale);
    items.push(PieceItem::Enter(node, around, operator, scale));
    for &child in scene.node(node).children() {
        lower_into(scene, extents, child, &inside, items)?;
    }
    items.push(PieceItem::Leave);
    Ok(())
}

/// Lowers a piece. It has no rank yet, and its parameters no place.
fn lowered(
    scene: &Scene,
    extents: &mut Extents<'_>,
    node: NodeId,
    place: &GroupPosition,
) -> Result<Operand, LowerError> {
    let entry = scene.node(node).at_current_time();
    let takes_part = extents.takes_part(node);
    // What is hidden cannot exceed a limit.
    let program = if takes_part {
        Program::lower_piece(scene, node, place.frame, place.scale)?
    } else {
        Program::blank()
    };
    let (opcodes, iterations) = (OpcodeSet::of(&program), program.max_iterations());
    Ok(Operand {
        rank: 0,
        group: ROOT,
        group_adds: true,
        instructions: program.instructions,
        own_params: program.params,
        params: (0, 0),
        operator: scaled(&entry.operator, place.scale),
        takes_part,
        extent: extent_in_world(scene, extents, node),
        regularity: Regularity {
            lipschitz: program.lipschitz,
            slack: program.slack,
            hidden: program.hidden_slack,
            isolation: program.isolation,
            underestimate: if program.hidden_slack > 0.0 {
                program.underestimate
            } else {
                1.0
            },
            ..Regularity::SMOOTH
        },
        overshoot: ramp_overshoot(entry) * place.scale,
        magnitude: program.magnitude,
        slots: (program.value_slots, program.point_slots),
        brushes: program.brushes,
        opcodes,
        iterations,
    })
}
