//! A program that follows a scene edit by edit, at the cost of what an edit touches.
//!
//! *Practice.* Each [piece](crate::pieces) is lowered on its own; its parameters stand in a table that all of them share. A
//! coarse grid of parts knows which pieces can matter in each, by their boxes grown as far as [dirty
//! boxes](argil_scene::Change) reach: the list for a part is theirs, in the scene's order, with the joints of the groups that they
//! are in. In the part it gives the scene's distances, as far as those are below the live program's far length. What remains
//! linear in the number of operands of a group, with a small factor, is finding a piece's place in the order.

mod added;
mod groups;
mod listed;
mod lists;
mod piece;
mod touched;
mod units;

use crate::jumps::Loose;
use crate::loose::loose_of;
use crate::materials::materials_of;
use crate::parts::{Part, Parts};
use crate::pieces::{ROOT, Told, regularity_of};
use crate::program::Program;
use crate::{ClearTerms, LowerError, Opcodes};
pub use added::{Added, HardBrush};
use argil_math::Aabb;
use argil_scene::{Change, Extents, NodeId, OperatorKind, Scene};
use glam::Vec3;
use groups::{Groups, Place};
use listed::Near;
use piece::{Operand, lower_into};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::{BTreeMap, HashMap};
pub use touched::Touched;

/// Ranks between neighbours, to begin with.
const RANK_STEP: u64 = 1 << 32;

/// What an update could not keep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Upset {
    /// Distances everywhere are relied on in another way than before: all that was made of them is to be made again.
    pub everything: bool,
}

/// A scene's program, operand by operand. See the module's page.
pub struct LiveProgram {
    /// The tables, and what holds of the whole; its list is not kept.
    tables: Program,
    parts: Parts,
    /// All pieces, and the groups that they are in.
    operands: HashMap<NodeId, Operand>,
    groups: Groups,
    /// All pieces in the scene's order.
    order: BTreeMap<u64, NodeId>,
    /// Of each part, the operands that can matter there, by rank.
    near: FxHashMap<Part, Vec<Near>>,
    /// Levels that have any.
    levels: u32,
    /// Those that matter wherever others do.
    everywhere: BTreeMap<u64, NodeId>,
    /// Stretches of the parameters that are free, by length.
    free: HashMap<u32, Vec<u32>>,
    /// By the bits of what they count: the visible operands' magnitudes and blend radii.
    magnitudes: BTreeMap<u32, u32>,
    blends: BTreeMap<u32, u32>,
    /// The same of what is in open groups.
    inner_blends: BTreeMap<u32, u32>,
    chamfers: u32,
    morphs: u32,
    /// How far values can fall at the root and in each open group, as far as `near` allows for it.
    falls: [f32; 2],
    touched: Option<Touched>,
    /// Whether what was touched is known.
    is_told: bool,
    /// Whether ranks were given anew in this update.
    renumbered: bool,
    /// Stretches of parameters that this update has written.
    written: Vec<(u32, u32)>,
    /// The boxes of what the last update put in, with room for blends, and whether it touched what is endless or cuts.
    put: Aabb,
    touched_ends: bool,
    /// Boxes outside of which the last update changed nothing of what is known of jumps.
    loosened: Vec<Aabb>,
    /// Instructions and iterations of all operands, seen or not; opcodes of all that there ever were.
    length: usize,
    iterations: u64,
    opcodes: Opcodes,
}

/// Where along a curve through the parts' region a box's middle is.
fn morton(aabb: Aabb, parts: &Parts) -> u64 {
    if !aabb.is_finite() {
        return 0;
    }
    // An eighth of a part is as fine as need be.
    let across = 8.0 * (aabb.center() - parts.corner) / parts.edge + 512.0;
    let at = across.clamp(Vec3::ZERO, Vec3::splat(1023.0)).as_uvec3();
    let spread = |c: u32| {
        (0..10).fold(0u64, |code, bit| {
            code | u64::from(c >> bit & 1) << (3 * bit)
        })
    };
    spread(at.x) | spread(at.y) << 1 | spread(at.z) << 2
}

fn count(counts: &mut BTreeMap<u32, u32>, value: f32, is_there: bool) {
    let bits = value.max(0.0).to_bits() & 0x7fff_ffff;
    let own = counts.entry(bits).or_default();
    if is_there {
        *own += 1;
    } else {
        *own -= 1;
        if *own == 0 {
            counts.remove(&bits);
        }
    }
}

fn greatest(counts: &BTreeMap<u32, u32>) -> f32 {
    counts
        .last_key_value()
        .map_or(0.0, |(&bits, _)| f32::from_bits(bits))
}

impl LiveProgram {
    /// Of a scene as it is now.
    ///
    /// # Errors
    /// As [`Program::lower`].
    pub fn new(scene: &Scene, parts: Parts) -> Result<Self, LowerError> {
        let mut live = Self {
            tables: Program::default(),
            parts,
            operands: HashMap::new(),
            groups: Groups::default(),
            order: BTreeMap::new(),
            near: FxHashMap::default(),
            levels: 1,
            everywhere: BTreeMap::new(),
            free: HashMap::new(),
            magnitudes: BTreeMap::new(),
            blends: BTreeMap::new(),
            inner_blends: BTreeMap::new(),
            chamfers: 0,
            morphs: 0,
            falls: [0.0; 2],
            touched: None,
            is_told: false,
            renumbered: false,
            written: Vec::new(),
            put: Aabb::EMPTY,
            touched_ends: false,
            loosened: Vec::new(),
            length: 0,
            iterations: 0,
            opcodes: Opcodes::default(),
        };
        let mut extents = Extents::of(scene);
        let mut items = Vec::new();
        for &node in scene.node(Scene::ROOT).children() {
            lower_into(scene, &mut extents, node, &Place::ROOT, &mut items)?;
        }
        let mut all = live.place(items, ROOT, &mut Vec::new());
        for ((_, operand), nth) in all.iter_mut().zip(1..) {
            operand.rank = nth * RANK_STEP;
        }
        // Parameters of neighbours stand side by side.
        all.sort_by_cached_key(|(_, operand)| morton(operand.extent.aabb, &parts));
        for (node, operand) in all {
            live.insert(node, operand);
        }
        live.written.clear();
        live.tables.materials = materials_of(scene);
        live.index_all();
        live.settle();
        live.loosened.clear();
        live.tables.aabb = live.solid_box();
        Ok(live)
    }

    /// Where it tells lists.
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// The tables that lists point into, and what holds of the whole scene. It has no list of its own.
    pub fn program(&self) -> &Program {
        &self.tables
    }

    /// Stretches of the parameters, each from one to before another, that the last update has written. Those that it has
    /// appended are among them.
    pub fn written(&self) -> &[(u32, u32)] {
        &self.written
    }

    /// A box of what the last update put into the scene, and whether how far the scene reaches may have changed elsewhere too:
    /// if that touched what is endless, or what cuts the rest.
    pub fn put(&self) -> (Aabb, bool) {
        (self.put, self.touched_ends)
    }

    /// Boxes in which the last update changed what is known of [jumps](Program::jumps_near).
    pub fn loosened(&self) -> &[Aabb] {
        &self.loosened
    }

    /// Instructions of the whole at most.
    pub fn length(&self) -> usize {
        self.length
    }

    /// [`Program::iterations`] of the whole at most.
    pub fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Opcodes of the whole, and of what was there before.
    pub fn opcodes(&self) -> Opcodes {
        self.opcodes
    }

    /// Follow a scene's changes since the last time.
    ///
    /// # Errors
    /// As [`Program::lower`]; nothing is changed then.
    pub fn follow(&mut self, scene: &Scene, changes: &[Change]) -> Result<Upset, LowerError> {
        let before = self.reliance();
        let units = self.units(scene, changes);
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
        self.written.clear();
        let gone = self.groups.forget_gone();
        let old = self.touched.take().unwrap_or_default().before;
        let free = old.into_iter().map(|old| old.params).chain(gone);
        for (at, length) in free {
            self.free.entry(length).or_default().push(at);
        }
        (self.put, self.touched_ends) = (Aabb::EMPTY, false);
        let mut told = Touched::default();
        let mut is_told = self.morphs == 0;
        for &node in &units {
            self.take_out(node, &mut told);
        }
        let mut plain = told.before.iter().all(Operand::is_plain);
        self.touched_ends |= told.before.iter().any(Operand::ends);
        self.renumbered = false;
        for (node, group, items) in there {
            let pieces = self.place(items, group, &mut told.stretches);
            let (mut rank, step) = self.ranks_for(scene, node, pieces.len() as u64);
            for (node, mut operand) in pieces {
                rank += step;
                operand.rank = rank;
                plain &= operand.is_plain();
                told.after.insert(node);
                self.touched_ends |= operand.ends();
                if operand.adds() {
                    self.put = self.put.union(operand.extent.aabb);
                }
                self.insert(node, operand);
                self.index(node);
            }
        }
        // Blends swell what they join.
        self.put = self.put.grown(self.swelling());
        self.tables.aabb = self.tables.aabb.union(self.put);
        let needed = self.needed_falls();
        if needed[0] > self.falls[0] || needed[1] > self.falls[1] {
            self.index_all();
        }
        is_told &= self.morphs == 0 && !self.renumbered;
        if is_told {
            self.tell(&mut told);
        }
        // Kept for their parameters, whether they are told of or not.
        self.touched = Some(told);
        self.is_told = is_told;
        self.loosened.clear();
        if !plain || !self.tables.loose.is_empty() {
            self.settle();
        }
        self.tables.magnitude = greatest(&self.magnitudes);
        let of_everything = changes.iter().any(|change| change.far_box == Aabb::ALL);
        if of_everything {
            self.tables.materials = materials_of(scene);
        }
        let everything = of_everything || before != self.reliance();
        Ok(Upset { everything })
    }

    /// Whether what was made of a program's distances can be relied on as before.
    pub fn relies_on_the_same_as(&self, program: &Program) -> bool {
        let own = (
            program.lipschitz(),
            program.clear_terms_about(self.parts.base),
        );
        own == self.reliance() && program.materials() == self.tables.materials
    }

    /// What decisions about distances rest on.
    fn reliance(&self) -> (f32, ClearTerms) {
        (
            self.tables.lipschitz,
            self.tables.clear_terms_about(self.parts.base),
        )
    }

    /// Take note of an operand and give its parameters a place; `near` is not touched.
    fn insert(&mut self, node: NodeId, mut operand: Operand) {
        let own = std::mem::take(&mut operand.own_params);
        let length = own.len() as u32;
        let at = self.put_params(&own);
        for instr in &mut operand.instrs {
            instr.params += at;
        }
        operand.params = (at, length);
        self.length += operand.instrs.len();
        self.iterations += operand.iterations;
        self.opcodes = self.opcodes.union(operand.opcodes);
        let slots = (&mut self.tables.value_slots, &mut self.tables.point_slots);
        let depth = self.groups.inside(operand.group).depth;
        *slots.0 = (operand.slots.0 + depth).max(*slots.0);
        *slots.1 = operand.slots.1.max(*slots.1);
        self.order.insert(operand.rank, node);
        self.count_in(&operand, true);
        self.operands.insert(node, operand);
    }

    /// Put words among the parameters: where they begin.
    fn put_params(&mut self, own: &[f32]) -> u32 {
        let length = own.len() as u32;
        let params = &mut self.tables.params;
        let at = match self.free.get_mut(&length).and_then(Vec::pop) {
            Some(at) => {
                params[at as usize..(at + length) as usize].copy_from_slice(own);
                at
            }
            None => {
                let at = params.len() as u32;
                params.extend_from_slice(own);
                at
            }
        };
        self.written.push((at, at + length));
        at
    }

    /// Take an operand out; its parameters stay.
    fn remove(&mut self, node: NodeId) -> Option<Operand> {
        let operand = self.operands.remove(&node)?;
        self.length -= operand.instrs.len();
        self.iterations -= operand.iterations;
        self.order.remove(&operand.rank);
        self.everywhere.remove(&operand.rank);
        for at in self.parts_of(&operand) {
            let Some(list) = self.near.get_mut(&at) else {
                continue;
            };
            if let Ok(place) = list.binary_search_by_key(&operand.rank, |near| near.rank) {
                list.remove(place);
            }
            if list.is_empty() {
                self.near.remove(&at);
            }
        }
        self.count_in(&operand, false);
        Some(operand)
    }

    fn count_blend(&mut self, blend: f32, depth: usize, is_there: bool) {
        let counts = if depth == 0 {
            &mut self.blends
        } else {
            &mut self.inner_blends
        };
        count(counts, blend, is_there);
    }

    fn count_in(&mut self, operand: &Operand, is_there: bool) {
        if !operand.visible {
            return;
        }
        count(&mut self.magnitudes, operand.magnitude, is_there);
        let depth = self.groups.inside(operand.group).depth;
        self.count_blend(operand.operator.blend, depth, is_there);
        let by = |counter: &mut u32| {
            if is_there {
                *counter += 1;
            } else {
                *counter -= 1;
            }
        };
        if operand.is_chamfered() {
            by(&mut self.chamfers);
        }
        if operand.operator.kind == OperatorKind::Morph {
            by(&mut self.morphs);
        }
    }

    /// By how much joints swell what they join, at most.
    fn swelling(&self) -> f32 {
        let inner = greatest(&self.inner_blends);
        // Groups that are open are no deeper.
        greatest(&self.blends) + if inner > 0.0 { 4.0 * inner } else { 0.0 }
    }

    /// How regular the whole is.
    fn settle(&mut self) {
        let parent_of = |group: u32| self.groups.parent_of(group);
        let operator_of = |group: u32| self.groups.operator_of(group);
        let told = |node: &NodeId| {
            let own = &self.operands[node];
            own.visible.then_some(Told {
                group: own.group,
                operator: own.operator,
                regularity: own.regularity,
                extent: own.extent,
            })
        };
        let first_last = self.order.values().filter_map(told);
        let all = regularity_of(first_last, parent_of, operator_of);
        let loose = if all.slack + all.hidden == 0.0 {
            Vec::new()
        } else {
            let last_first = self.order.values().rev().filter_map(told);
            loose_of(last_first, parent_of, operator_of, all)
        };
        let before = std::mem::replace(&mut self.tables.loose, loose);
        let tables = &mut self.tables;
        if before != tables.loose {
            let known: [FxHashSet<_>; 2] =
                [&before, &tables.loose].map(|all| all.iter().map(Loose::bits).collect());
            let changed = known[0].symmetric_difference(&known[1]);
            self.loosened.extend(changed.map(Loose::box_of));
        }
        tables.lipschitz = all.lipschitz;
        tables.slack = all.slack;
        tables.hidden_slack = all.hidden;
        tables.isolation = all.isolation;
        tables.magnitude = greatest(&self.magnitudes);
    }

    /// A box around everything that adds.
    fn solid_box(&self) -> Aabb {
        let adding = self.operands.values().filter(|operand| operand.adds());
        let boxes = adding.fold(Aabb::EMPTY, |all, operand| all.union(operand.extent.aabb));
        boxes.grown(self.swelling())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil_scene::{Brush, Edit, Group, Modifier, Shape};
    use glam::IVec3;

    fn parts() -> Parts {
        Parts {
            corner: Vec3::splat(-1.0),
            edge: 0.25,
            far: 0.1,
            base: 2.0,
        }
    }

    /// Of a group of many, an edit of one lowers that one, and the list of a part is of what is near.
    #[test]
    fn an_edit_in_a_group_costs_what_it_touches() {
        let mut scene = Scene::new();
        let outer = Group::new().scaled(0.5).blend(0.01);
        let outer = scene.push(outer).expect("a group").node;
        let group = Group::new().at([0.1, 0.0, 0.0]);
        let group = scene.push_into(outer, group).expect("a group").node;
        let mut nodes = Vec::new();
        for i in 0..512 {
            let at = [i % 8, i / 8 % 8, i / 64].map(|c| 0.5 * c as f32 - 1.75);
            let solid = Brush::new(Shape::sphere(0.1)).at(at).blend(0.01);
            nodes.push(scene.push_into(group, solid).expect("a brush").node);
        }
        let mut live = LiveProgram::new(&scene, parts()).expect("a program");
        let seen = scene.change_count();
        let by = Modifier::Translate {
            by: [0.01, 0.0, 0.0],
        };
        scene
            .apply(Edit::Transform {
                node: nodes[99],
                by,
            })
            .expect("an edit");
        let changes = scene.changes_since(seen).expect("changes");
        let upset = live.follow(&scene, changes).expect("a program");
        assert!(!upset.everything);
        assert_eq!(live.written().len(), 1);
        let mut list = Vec::new();
        live.list(IVec3::splat(2), &mut list);
        assert!((5..60).contains(&list.len()), "{}", list.len());
        // The whole is what it would be if it were lowered at once.
        let (whole, fresh) = (live.whole(), Program::lower(&scene).expect("a program"));
        assert_eq!(whole.magnitude, fresh.magnitude);
        for i in 0..200 {
            let p = Vec3::new(i as f32, 1.7 * i as f32, 0.3 * i as f32).map(f32::sin);
            assert_eq!(whole.distance(p), fresh.distance(p), "{p}");
        }
    }

    /// What is checked is the piece: one in a group in a group, where only it is wrong, and what is no longer in the scene.
    #[test]
    fn pieces_are_checked_where_they_are() {
        let mut scene = Scene::new();
        let outer = scene.push(Group::new().scaled(0.5)).expect("a group").node;
        let solid = Brush::new(Shape::sphere(0.1));
        let good = scene.push_into(outer, solid.clone()).expect("a brush").node;
        let spacing = [0.001; 3];
        let many = solid.modify(Modifier::Repeat {
            spacing,
            count: None,
        });
        let bad = scene.push_into(outer, many).expect("a brush").node;
        assert_eq!(Program::check(&scene, good), Ok(()));
        for node in [bad, outer] {
            let found = Program::check(&scene, node);
            assert!(
                matches!(&found, Err(LowerError::TooManyCopies { path, .. }) if path.ends_with("[1]")),
                "{found:?}"
            );
        }
        scene.apply(Edit::Remove { node: bad }).expect("an edit");
        for node in [bad, outer] {
            assert_eq!(Program::check(&scene, node), Ok(()));
        }
    }
}
