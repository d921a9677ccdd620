//! A program that follows a scene edit by edit, at the cost of what an edit touches.

mod additions;
mod arena;
mod boxes;
mod change_set;
mod changes;
mod counts;
mod groups;
mod index;
mod lists;
mod moved;
mod piece;
mod units;

use crate::jump_regions::loose_of;
use crate::jumps::JumpRegion;
use crate::materials::MaterialTable;
use crate::part_grid::PartGrid;
use crate::pieces::{PieceInfo, ROOT, acting, regularity_of};
use crate::program::Program;
use crate::{LowerError, OpcodeSet};
pub use additions::{Additions, HardBrush};
use arena::Arena;
use argil_math::Aabb;
use argil_scene::{Extents, NodeId, OperatorKind, Scene, SceneChange};
pub use change_set::ChangeSet;
use change_set::ChangeTracker;
use counts::PieceCounts;
use glam::Vec3;
use groups::{GroupPosition, GroupTree};
use index::PartIndex;
pub use moved::{BrushMotion, MovedBrush};
use piece::{Operand, lower_into};
use rustc_hash::FxHashSet;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicU64, Ordering};

/// Initial difference between the ranks of neighbors.
const RANK_STEP: u64 = 1 << 32;

/// The result of an update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UpdateOutcome {
    /// Whether bounds changed that all distances rely on, so that everything derived from them must be rebuilt.
    pub needs_rebuild: bool,
}

/// A scene's program, piece by piece, which follows edits.
///
/// Create it from a scene, then [update](Self::update) it after each change. [`IncrementalProgram::part_program`]
/// returns the instructions of a part of space.
///
/// *Practice.* Each piece is lowered by itself. Its parameters live in a table that all pieces
/// share. A coarse grid of parts knows which pieces can matter in each part, by their boxes grown as far as [dirty
/// boxes](argil_scene::SceneChange) reach. A part's program consists of them, in the scene's order, with the joints
/// of their groups. In the part, it gives the scene's distances below the program's far length. Finding a piece's
/// place in the order remains linear in the operands of a group, with a small factor.
#[derive(Debug)]
pub struct IncrementalProgram {
    /// The tables, and what holds for the whole scene. Its list is empty.
    tables: Program,
    /// All pieces, and the groups that contain them.
    operands: HashMap<NodeId, Operand>,
    groups: GroupTree,
    /// All pieces in the scene's order.
    order: BTreeMap<u64, NodeId>,
    /// Which pieces can matter where.
    index: PartIndex,
    /// Statistics of the operands that take part.
    counts: PieceCounts,
    /// Space in the table of parameters.
    arena: Arena,
    /// What the last update did.
    update: ChangeTracker,
    /// Instructions and iterations of all operands, whether they take part or not, and all opcodes that ever occurred.
    length: usize,
    iterations: u64,
    opcodes: OpcodeSet,
    revision: u64,
}

/// The next [`IncrementalProgram::revision`].
static NEXT_REVISION: AtomicU64 = AtomicU64::new(1);

fn new_revision() -> u64 {
    NEXT_REVISION.fetch_add(1, Ordering::Relaxed)
}

/// Returns the position of a box's center along a space-filling curve.
fn morton(aabb: Aabb, parts: &PartGrid) -> u64 {
    if !aabb.is_finite() {
        return 0;
    }
    // An eighth of a part is fine enough.
    let across = 8.0 * (aabb.center() - parts.corner) / parts.edge + 512.0;
    let at = across.clamp(Vec3::ZERO, Vec3::splat(1023.0)).as_uvec3();
    let spread = |c: u32| {
        (0..10).fold(0u64, |code, bit| {
            code | u64::from(c >> bit & 1) << (3 * bit)
        })
    };
    spread(at.x) | spread(at.y) << 1 | spread(at.z) << 2
}

impl IncrementalProgram {
    /// Creates the program of a scene.
    ///
    /// # Errors
    /// If the scene exceeds a limit: see [`Program::lower`].
    pub fn new(scene: &Scene, parts: PartGrid) -> Result<Self, LowerError> {
        let mut live = Self {
            tables: Program::default(),
            operands: HashMap::new(),
            groups: GroupTree::default(),
            order: BTreeMap::new(),
            index: PartIndex::new(parts),
            counts: PieceCounts::default(),
            arena: Arena::default(),
            update: ChangeTracker::default(),
            length: 0,
            iterations: 0,
            opcodes: OpcodeSet::default(),
            revision: new_revision(),
        };
        let mut extents = Extents::of(scene);
        let mut items = Vec::new();
        for &node in scene.node(Scene::ROOT).children() {
            lower_into(scene, &mut extents, node, &GroupPosition::ROOT, &mut items)?;
        }
        let mut all = live.place(items, ROOT, &mut Vec::new());
        for ((_, operand), position) in all.iter_mut().zip(1..) {
            operand.rank = position * RANK_STEP;
        }
        // Parameters of neighbors are stored together.
        all.sort_by_cached_key(|(_, operand)| morton(operand.extent.aabb, &parts));
        for (node, operand) in all {
            live.insert(node, operand);
        }
        live.arena.written.clear();
        live.tables.materials = MaterialTable::of(scene)?;
        live.index_all();
        live.recompute_regularity();
        live.update.loosened.clear();
        live.tables.aabb = live.solid_box();
        Ok(live)
    }

    /// Returns the grid of parts.
    pub fn parts(&self) -> &PartGrid {
        &self.index.parts
    }

    /// Returns a number that is never 0. It changes whenever instructions or the places of their parameters may have
    /// changed, and no other program has it.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Returns the tables that part programs refer to, and what holds for the whole scene. Its own list is empty.
    pub fn program(&self) -> &Program {
        &self.tables
    }

    /// Returns the ranges of parameters that the last update wrote, including appended ones.
    pub fn dirty_ranges(&self) -> &[(u32, u32)] {
        &self.arena.written
    }

    /// Returns the box of what the last update inserted, and whether the scene's extent may have changed elsewhere
    /// too: if the update touched an infinite solid, or one that clips others.
    pub fn inserted_box(&self) -> (Aabb, bool) {
        (self.update.put, self.update.touched_ends)
    }

    /// Returns boxes in which the facts about [jumps and slopes](Program::jumps_near) changed in the last update.
    pub fn jumps_added(&self) -> &[Aabb] {
        &self.update.loosened
    }

    /// Iterates over boxes outside which distances are at least the parts' far length, one for each operand. They may be
    /// infinite.
    pub fn near_boxes(&self) -> impl Iterator<Item = Aabb> {
        let acts = |operand: &&Operand| {
            operand.takes_part && operand.operator.kind != OperatorKind::Intersect
        };
        let acting = self.operands.values().filter(acts);
        acting.map(|operand| self.index.grown_box(operand, &self.groups))
    }

    /// Returns the maximum number of instructions of the whole program.
    pub fn instruction_count(&self) -> usize {
        self.length
    }

    /// Returns [`Program::max_iterations`] of the whole program, or more.
    pub fn max_iterations(&self) -> u64 {
        self.iterations
    }

    /// Returns the opcodes of the whole program, including earlier ones.
    pub fn opcodes(&self) -> OpcodeSet {
        self.opcodes.union(OpcodeSet::of_materials(&self.tables))
    }

    /// Applies a scene's changes since the last update.
    ///
    /// # Errors
    /// If the scene exceeds a limit: see [`Program::lower`]. Nothing changes then.
    pub fn update(
        &mut self,
        scene: &Scene,
        changes: &[SceneChange],
    ) -> Result<UpdateOutcome, LowerError> {
        let before = self.reliance();
        let units = self.units(scene, changes);
        let has_other = changes.iter().any(|change| change.node.is_none());
        let materials = has_other.then(|| MaterialTable::of(scene)).transpose()?;
        let mut extents = Extents::of(scene);
        let mut there = Vec::new();
        for &node in &units {
            if let Some(group) = self.group_for(scene, node, &units) {
                let mut items = Vec::new();
                let place = self.groups.inside(group);
                lower_into(scene, &mut extents, node, &place, &mut items)?;
                there.push((node, group, items));
            }
        }
        if !units.is_empty() {
            self.revision = new_revision();
        }
        let gone = self.groups.remove_unused();
        let old = std::mem::take(&mut self.update).touched;
        let old = old.unwrap_or_default().before.into_iter();
        self.arena.begin(old.map(|old| old.params).chain(gone));
        let mut changes_made = ChangeSet::default();
        let had_morphs = self.counts.morphs > 0;
        let first_acting = self.first_acting();
        for &node in &units {
            self.take_out(node, &mut changes_made);
        }
        let mut plain = changes_made.before.iter().all(Operand::is_plain);
        self.update.touched_ends |= changes_made.before.iter().any(Operand::ends);
        for (node, group, items) in there {
            let pieces = self.place(items, group, &mut changes_made.stretches);
            let (mut rank, step) = self.ranks_for(scene, node, pieces.len() as u64);
            for (node, mut operand) in pieces {
                rank += step;
                operand.rank = rank;
                plain &= operand.is_plain();
                changes_made.after.insert(node);
                self.update.touched_ends |= operand.ends();
                if operand.adds() {
                    self.update.put = self.update.put.union(operand.extent.aabb);
                }
                self.insert(node, operand);
                self.enter(node);
            }
        }
        // Blends extend what they join.
        self.update.put = self.update.put.grown(self.counts.max_outward_offset());
        self.tables.aabb = self.tables.aabb.union(self.update.put);
        let needed = self.counts.blend_propagation(self.index.parts.far);
        if !self.index.has_room_for(needed) {
            self.index_all();
        }
        let has_morphs = had_morphs || self.counts.morphs > 0;
        self.update.is_collected = !has_morphs && !self.update.renumbered;
        if self.update.is_collected {
            self.collect_changes(&mut changes_made);
        }
        // Kept for their parameters, whether they are collected or not.
        self.update.touched = Some(changes_made);
        let jumps = self.tables.slack + self.tables.hidden_slack > 0.0;
        let is_steep = self.tables.lipschitz > 1.0;
        if !plain || jumps || is_steep || self.first_acting() != first_acting {
            self.recompute_regularity();
        }
        self.tables.magnitude = self.counts.magnitude();
        let mut moves_textures = false;
        if let Some(table) = materials {
            // They follow the materials, and instructions hold where.
            moves_textures = table.has_textures() || self.tables.materials.has_textures();
            self.tables.materials = table;
        }
        let of_everything =
            |change: &SceneChange| change.node.is_none() && !change.is_unused_material;
        Ok(UpdateOutcome {
            needs_rebuild: changes.iter().any(of_everything)
                || moves_textures
                || before != self.reliance(),
        })
    }

    /// Finds the box of the solid again, which updates only let grow.
    pub fn tighten_box(&mut self) {
        self.tables.aabb = self.solid_box();
    }

    /// Whether everything derived from a program's distances is still valid for this one.
    pub fn has_same_bounds_as(&self, program: &Program) -> bool {
        program.lipschitz() == self.tables.lipschitz()
            && program.clearance_model_in(self.index.parts.base).slack == self.reliance()
            && program.materials() == self.tables.materials()
    }

    /// Returns what decisions about distances rely on everywhere: the error of `f32` arithmetic. Jumps and slopes are known
    /// [where they are](Self::jumps_added).
    fn reliance(&self) -> f32 {
        self.tables.clearance_model_in(self.index.parts.base).slack
    }

    /// Adds an operand and gives its parameters a place, without changing the index.
    fn insert(&mut self, node: NodeId, mut operand: Operand) {
        let words = std::mem::take(&mut operand.own_params);
        let length = words.len() as u32;
        let at = self.arena.put(&mut self.tables.params, &words);
        for instr in &mut operand.instructions {
            instr.params += at;
        }
        operand.params = (at, length);
        self.length += operand.instructions.len();
        self.iterations += operand.iterations;
        self.opcodes = self.opcodes.union(operand.opcodes);
        let slots = (&mut self.tables.value_slots, &mut self.tables.point_slots);
        let depth = self.groups.inside(operand.group).depth;
        *slots.0 = (operand.slots.0 + depth).max(*slots.0);
        *slots.1 = operand.slots.1.max(*slots.1);
        self.order.insert(operand.rank, node);
        self.counts.count(&operand, depth, true);
        self.operands.insert(node, operand);
    }

    /// Removes an operand. Its parameters stay.
    fn remove(&mut self, node: NodeId) -> Option<Operand> {
        let operand = self.operands.remove(&node)?;
        self.length -= operand.instructions.len();
        self.iterations -= operand.iterations;
        self.order.remove(&operand.rank);
        self.index.remove(&operand, &self.groups);
        let depth = self.groups.inside(operand.group).depth;
        self.counts.count(&operand, depth, false);
        Some(operand)
    }

    /// Recomputes the regularity of the whole scene.
    fn recompute_regularity(&mut self) {
        let parent_of = |group: u32| self.groups.parent_of(group);
        let operator_of = |group: u32| self.groups.operator_of(group);
        let piece_info = |node: &NodeId| {
            let operand = &self.operands[node];
            operand.takes_part.then_some(PieceInfo {
                group: operand.group,
                operator: operand.operator,
                regularity: operand.regularity,
                extent: operand.extent,
                overshoot: operand.overshoot,
            })
        };
        let pieces = self.order.values().filter_map(piece_info);
        let pieces = acting(pieces, parent_of, operator_of);
        let all = regularity_of(&pieces, parent_of, operator_of);
        let loose = loose_of(&pieces, parent_of, operator_of, all);
        let before = std::mem::replace(&mut self.tables.loose, loose);
        let tables = &mut self.tables;
        if before != tables.loose {
            let known: [FxHashSet<_>; 2] =
                [&before, &tables.loose].map(|all| all.iter().map(JumpRegion::bits).collect());
            let changed = known[0].symmetric_difference(&known[1]);
            self.update.loosened.extend(changed.map(JumpRegion::box_of));
        }
        tables.lipschitz = all.lipschitz;
        tables.slack = all.slack;
        tables.hidden_slack = all.hidden;
        tables.isolation = all.isolation;
        tables.magnitude = self.counts.magnitude();
    }

    /// Returns a box around everything that adds to the solid.
    fn solid_box(&self) -> Aabb {
        let adding = self.operands.values().filter(|operand| operand.adds());
        let boxes = adding.fold(Aabb::EMPTY, |all, operand| all.union(operand.extent.aabb));
        boxes.grown(self.counts.max_outward_offset())
    }
}

#[cfg(test)]
mod tests;
