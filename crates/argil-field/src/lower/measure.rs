//! Measures a scene before lowering: stack slots, and the regularity of distances.

use super::frame::extent_in_world;
use super::instances::LARGE_CLUSTER;
use super::lowering::{FEW_OPERANDS, Lowering, OpenScope};
use super::params::{is_loop, is_single};
use crate::jump_regions::loose_of;
use crate::node_map::NodeMap;
use crate::pieces::{
    OpenGroup, Piece, PieceInfo, Pieces, ROOT, acting, magnitude, ramp_overshoot, regularity_of,
    scaled,
};
use crate::program::Program;
use crate::regularity::{Regularity, regularity};
use crate::spans::GroupSpan;
use argil_abi::Instruction;
use argil_scene::{Extents, Modifier, NodeId, NodeKind, Operator, OperatorKind, Scene};
use rustc_hash::FxHashMap;
use std::collections::HashMap;

impl<'a> Lowering<'a> {
    /// Measures a node and its contents. Nothing is emitted yet. `pieces` are the root's.
    pub(super) fn of(scene: &'a Scene, root: NodeId, pieces: Option<&Pieces>) -> Self {
        let names = scene.materials().keys().map(String::as_str);
        let material_index = names.zip(1..).collect();
        let mut extents = Extents::of(scene);
        let aabb = extents.node_bounds(root).aabb;
        let parents_first: Vec<NodeId> = scene.descendants(root).collect();
        let all = regularity(scene, &mut extents, &parents_first);
        let regular = all[root];
        let mut lowering = Lowering {
            scene,
            extents,
            operands: HashMap::new(),
            slots: NodeMap::of(&parents_first, 0),
            regular: all,
            prefix_slots: HashMap::new(),
            material_index,
            texture_places: crate::materials::texture_places(scene),
            program: Program {
                aabb,
                lipschitz: regular.lipschitz,
                slack: regular.slack,
                hidden_slack: regular.hidden,
                isolation: regular.isolation,
                underestimate: regular.underestimate,
                ..Program::blank()
            },
            points: 0,
            tasks: Vec::new(),
            open: FxHashMap::default(),
            begun: 0,
            instances: Vec::new(),
        };
        if let Some(pieces) = pieces.filter(|pieces| pieces.all.len() > FEW_OPERANDS) {
            let groups = pieces.groups.iter().zip(0..);
            let open = |(open_group, group): (&OpenGroup, u32)| {
                let scale = open_group.scale;
                (open_group.node, OpenScope { group, scale })
            };
            lowering.open = groups.map(open).collect();
            let root = GroupSpan {
                parent: ROOT,
                operator: Operator::default(),
                open: Instruction::default(),
                close: Instruction::default(),
            };
            lowering.program.groups = vec![root; pieces.groups.len()];
        }
        lowering.measure(&parents_first);
        lowering
    }

    /// Finds the operands that take part, and the stack slots of each node, from the leaves up.
    pub(super) fn measure(&mut self, parents_first: &[NodeId]) {
        for &id in parents_first.iter().rev() {
            let node = self.scene.node(id);
            let mut need = 0;
            if matches!(node.at_current_time().kind, NodeKind::Group) {
                // The first operand has nothing to act on unless it adds.
                let mut operands: Vec<NodeId> = Vec::new();
                let mut prefix: Vec<u32> = Vec::new();
                for &child in node.children() {
                    let entry = self.scene.node(child).at_current_time();
                    let acts = !operands.is_empty() || entry.operator.kind == OperatorKind::Union;
                    if !acts || !self.extents.takes_part(child) {
                        continue;
                    }
                    let of_child = self.slots[child];
                    need = match operands.is_empty() {
                        true => of_child,
                        false if is_single(entry) => need,
                        false if self.open.contains_key(&id) => need.max(1 + of_child),
                        // The operand that needs more goes first, and the other then has one slot less.
                        false => need.max(of_child).max(1 + need.min(of_child)),
                    };
                    operands.push(child);
                    prefix.push(need);
                }
                self.operands.insert(id, operands);
                self.prefix_slots.insert(id, prefix);
            }
            self.slots[id] = need
                + node
                    .at_current_time()
                    .modifiers
                    .iter()
                    .map(|m| match m {
                        // Clusters in each other, and an instance in them.
                        Modifier::Instances { poses } => 2 + u32::from(poses.len() > LARGE_CLUSTER),
                        _ => u32::from(is_loop(m)),
                    })
                    .sum::<u32>();
        }
        if let Some(&root) = parents_first.first() {
            self.program.value_slots = self.slots[root] as usize;
        }
    }

    pub(super) fn set_regularity(&mut self, regularity: Regularity) {
        let program = &mut self.program;
        program.lipschitz = regularity.lipschitz;
        program.slack = regularity.slack;
        program.hidden_slack = regularity.hidden;
        program.isolation = regularity.isolation;
        program.underestimate = regularity.underestimate;
    }

    /// Returns the facts about a piece, if it takes part.
    pub(super) fn piece_info(&mut self, groups: &Pieces, piece: Piece) -> Option<PieceInfo> {
        let entry = self.scene.node(piece.node).at_current_time();
        let scale = groups.groups[piece.group as usize].scale;
        self.extents.takes_part(piece.node).then(|| PieceInfo {
            group: piece.group,
            operator: scaled(&entry.operator, scale),
            regularity: self.regular[piece.node].scaled(scale),
            extent: extent_in_world(self.scene, &mut self.extents, piece.node),
            overshoot: ramp_overshoot(entry) * scale,
        })
    }

    /// Combines the facts about pieces into those of the whole scene.
    pub(super) fn measure_pieces(&mut self, pieces: &Pieces) {
        let mut greatest = 0.0f32;
        for piece in &pieces.all {
            if self.extents.takes_part(piece.node) {
                let scale = pieces.groups[piece.group as usize].scale;
                greatest = greatest.max(magnitude(&self.extents.node_bounds(piece.node), scale));
            }
        }
        self.program.magnitude = greatest;
        let parent_of = |group: u32| pieces.groups[group as usize].parent;
        let operator_of = |group: u32| pieces.groups[group as usize].operator;
        let piece_infos = pieces.all.iter();
        let piece_infos = piece_infos.filter_map(|&piece| self.piece_info(pieces, piece));
        let piece_infos = acting(piece_infos, parent_of, operator_of);
        let all = regularity_of(&piece_infos, parent_of, operator_of);
        self.set_regularity(all);
        self.program.loose = loose_of(&piece_infos, parent_of, operator_of, all);
    }
}
