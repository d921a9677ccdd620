//! A program that follows a scene edit by edit, at the cost of what an edit touches.
//!
//! *Practice.* Each [piece](crate::pieces) is lowered on its own; its parameters stand in a table that all of them share. A
//! coarse grid of parts knows which pieces can matter in each, by their boxes grown as far as [dirty
//! boxes](argil_scene::Change) reach: the list for a part is theirs, in the scene's order, with the joints of the groups that they
//! are in. In the part it gives the scene's distances, as far as those are below the live program's far length. What remains
//! linear in the number of operands of a group, with a small factor, is finding a piece's place in the order.

mod groups;

use crate::loose::{Loose, loose_of};
use crate::lower::{Around, extent_in_world, materials_of};
use crate::operands::OperandSpan;
use crate::parts::{LEVELS, Part, Parts, parts_between};
use crate::pieces::{ROOT, Told, is_open, leaves_open, regularity_of, scale_of, scaled};
use crate::program::Program;
use crate::regular::Regularity;
use crate::{ClearTerms, LowerError, Opcodes};
use argil_abi::{self as abi, Instr};
use argil_math::Aabb;
use argil_scene::{
    Change, Extent, Extents, NodeId, Operator, OperatorKind, Profile, Scene, greatest_fall,
};
use glam::{IVec3, Vec3};
use groups::{Group, Groups, Place, Writer};
use rustc_hash::{FxHashMap, FxHashSet};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Ranks between neighbours, to begin with.
const RANK_STEP: u64 = 1 << 32;

/// A piece.
struct Operand {
    /// Where it stands in the order.
    rank: u64,
    /// The open group that it is in.
    group: u32,
    /// Whether that group and all around it add.
    group_adds: bool,
    instrs: Vec<Instr>,
    /// Its parameters, until they have a place.
    own_params: Vec<f32>,
    /// Its stretch of the parameters.
    params: (u32, u32),
    /// In the world's unit.
    operator: Operator,
    visible: bool,
    /// In the world.
    extent: Extent,
    regularity: Regularity,
    magnitude: f32,
    slots: (usize, usize),
    brushes: usize,
    opcodes: Opcodes,
    iterations: u64,
}

impl Operand {
    fn is_chamfered(&self) -> bool {
        self.operator.profile == Profile::Chamfer && self.operator.blend > 0.0
    }

    /// Whether something can be solid where it is.
    fn adds(&self) -> bool {
        self.visible
            && self.group_adds
            && matches!(
                self.operator.kind,
                OperatorKind::Union | OperatorKind::Morph
            )
    }

    /// Whether it is endless, or cuts what is.
    fn ends(&self) -> bool {
        let is_endless =
            self.adds() && !self.extent.aabb.is_empty() && !self.extent.aabb.is_finite();
        is_endless || (self.visible && self.operator.kind == OperatorKind::Intersect)
    }

    /// Whether another has the same instructions but for the values of parameters.
    fn is_alike(&self, other: &Self) -> bool {
        let relative = |operand: &Self, instr: &Instr| Instr {
            params: instr.params - operand.params.0,
            ..*instr
        };
        self.visible == other.visible
            && self.group == other.group
            && self.params.1 == other.params.1
            && self.instrs.len() == other.instrs.len()
            && self
                .instrs
                .iter()
                .zip(&other.instrs)
                .all(|(a, b)| relative(self, a) == relative(other, b))
    }

    /// Where the words of each instruction begin and end among its own.
    fn stretches(&self) -> Vec<(u32, u32)> {
        let mut begins: Vec<u32> = self
            .instrs
            .iter()
            .map(|i| i.params - self.params.0)
            .collect();
        begins.push(self.params.1);
        begins.sort_unstable();
        begins.dedup();
        begins.windows(2).map(|pair| (pair[0], pair[1])).collect()
    }

    /// Whether how regular the whole is cannot depend on it.
    fn is_plain(&self) -> bool {
        !self.visible || (self.regularity == Regularity::SMOOTH && !self.is_chamfered())
    }
}

/// An operand where it can matter.
#[derive(Clone, Copy)]
struct Near {
    rank: u64,
    node: NodeId,
    group: u32,
    /// Of an operand of one instruction, that: most are, and their records lie all over memory.
    instr: Option<Instr>,
}

/// What the last update has touched, as it was and as it is: by instructions of either.
#[derive(Default)]
pub struct Touched {
    /// Operands as they were; their parameters stand until the next update.
    before: Vec<Operand>,
    /// Those of each part.
    near: FxHashMap<Part, Vec<usize>>,
    /// Operands as they are.
    after: HashSet<NodeId>,
    /// Stretches of parameters, ascending.
    stretches: Vec<(u32, u32)>,
}

impl Touched {
    /// Whether an instruction was touched, or is as it was before it was.
    pub fn has(&self, instr: &Instr) -> bool {
        let at = self
            .stretches
            .partition_point(|&(begin, _)| begin <= instr.params);
        let last = at.checked_sub(1).map(|last| self.stretches[last]);
        last.is_some_and(|(_, end)| instr.params < end)
    }

    /// Whether a list has an instruction that was touched: without one it gives the same distances as before.
    pub fn any(&self, list: &[Instr]) -> bool {
        list.iter().any(|instr| self.has(instr))
    }
}

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

    /// Append the instructions that can matter in a part.
    pub fn list(&self, part: IVec3, out: &mut Vec<Instr>) {
        let mut writer = Writer::new(&self.groups, out);
        if self.morphs > 0 {
            // A morph takes its share of everything.
            self.acting()
                .for_each(|own| writer.put(own.group, &own.instrs));
            writer.end();
            return;
        }
        let mut others = self.everywhere.iter().map(|(&r, &n)| (r, n)).peekable();
        for own in self.near_in(part).iter() {
            while let Some((_, other)) = others.next_if(|&(other, _)| other < own.rank) {
                let other = &self.operands[&other];
                writer.put(other.group, &other.instrs);
            }
            self.put_near(&mut writer, own);
        }
        for (_, other) in others {
            let other = &self.operands[&other];
            writer.put(other.group, &other.instrs);
        }
        writer.end();
    }

    fn put_near(&self, writer: &mut Writer<'_>, own: &Near) {
        match &own.instr {
            Some(instr) => writer.put(own.group, std::slice::from_ref(instr)),
            None => writer.put(own.group, &self.operands[&own.node].instrs),
        }
    }

    /// The visible pieces in the scene's order. The first to act is in what adds.
    fn acting(&self) -> impl Iterator<Item = &Operand> {
        let all = self.order.values().map(|node| &self.operands[node]);
        all.filter(|own| own.visible).skip_while(|own| {
            let kind = match self.groups.outermost(own.group) {
                ROOT => own.operator.kind,
                group => self.groups.operator_of(group).kind,
            };
            kind != OperatorKind::Union
        })
    }

    /// The operands that are entered in a part, or in one of another level that holds it, by rank.
    fn near_in(&self, part: IVec3) -> Cow<'_, [Near]> {
        let mut all = Cow::Borrowed(&[][..]);
        for level in 0..self.levels {
            let own = self.near.get(&(level, part >> (2 * level)));
            let own = own.map_or(&[][..], Vec::as_slice);
            if all.is_empty() {
                all = Cow::Borrowed(own);
            } else if !own.is_empty() {
                let joined = all.to_mut();
                joined.extend_from_slice(own);
                joined.sort_unstable_by_key(|near| near.rank);
            }
        }
        all
    }

    /// The whole scene's program, as [`Program::lower`] gives it but for the order of what does not depend on order.
    pub fn whole(&self) -> Program {
        let mut whole = self.tables.clone();
        let mut instrs = Vec::with_capacity(self.length);
        let mut spans: Vec<(u32, OperandSpan)> = Vec::new();
        let mut writer = Writer::new(&self.groups, &mut instrs);
        for own in self.acting() {
            let group = self.groups.outermost(own.group);
            let is_new = group == ROOT || spans.last().is_none_or(|(last, _)| *last != group);
            if is_new {
                let end = writer.end() as u32;
                if let Some((_, last)) = spans.last_mut() {
                    last.end = end;
                }
                let of_group = self.groups.get(group).map(|own| own.operator);
                spans.push((
                    group,
                    OperandSpan {
                        end,
                        operator: of_group.unwrap_or(own.operator),
                        extent: if of_group.is_some() {
                            Extent::EMPTY
                        } else {
                            own.extent
                        },
                    },
                ));
            }
            if let Some((_, last)) = spans.last_mut().filter(|_| group != ROOT)
                && own.operator.kind == OperatorKind::Union
            {
                last.extent = Extent {
                    aabb: last
                        .extent
                        .aabb
                        .union(own.extent.aabb.grown(self.swelling())),
                    underestimate: last.extent.underestimate.max(own.extent.underestimate),
                    shortfall: f32::INFINITY,
                };
            }
            writer.put(own.group, &own.instrs);
            whole.brushes += own.brushes;
        }
        let end = writer.end() as u32;
        if let Some((_, last)) = spans.last_mut() {
            last.end = end;
        }
        whole.instrs = instrs;
        whole.operands = spans.into_iter().map(|(_, span)| span).collect();
        whole
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

    /// What updates take out and put in whole: pieces, and open groups with all that they hold.
    fn units(&self, scene: &Scene, changes: &[Change]) -> FxHashSet<NodeId> {
        let mut units = FxHashSet::default();
        for change in changes {
            let Some(node) = change.node else {
                continue;
            };
            units.extend(self.unit_of(scene, node));
            for parent in change.parents.into_iter().flatten() {
                if self.groups.find(parent).is_none() {
                    units.extend(self.unit_of(scene, parent));
                } else if parent != Scene::ROOT
                    && scene.node(node).parent() == Some(parent)
                    && !leaves_open(scene.node(node).acting())
                {
                    // It is open no more.
                    units.insert(parent);
                }
            }
        }
        units
    }

    /// The open group that a node is, or the piece that it is in or is to be. Nothing of what is neither known nor in the scene.
    fn unit_of(&self, scene: &Scene, node: NodeId) -> Option<NodeId> {
        if self.groups.find(node).is_some() {
            return Some(node);
        }
        let mut at = node;
        loop {
            let parent = scene.node(at).parent();
            let is_apart = parent.is_some_and(|parent| self.groups.find(parent).is_some());
            if is_apart || self.operands.contains_key(&at) {
                return Some(at);
            }
            at = parent?;
        }
    }

    /// The group that a unit is to be put into: none if it is not in the scene, or another unit holds it.
    fn group_for(&self, scene: &Scene, node: NodeId, units: &FxHashSet<NodeId>) -> Option<u32> {
        let group = self.groups.find(scene.node(node).parent()?)?;
        let mut at = node;
        while let Some(parent) = scene.node(at).parent() {
            if units.contains(&parent) {
                return None;
            }
            at = parent;
        }
        (at == Scene::ROOT).then_some(group)
    }

    /// Take a unit out. The joints of groups are told as touched.
    fn take_out(&mut self, node: NodeId, told: &mut Touched) {
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            if let Some(old) = self.remove(node) {
                self.groups.let_go(old.group, node);
                told.before.push(old);
                continue;
            }
            let found = self.groups.find(node).filter(|&group| group != ROOT);
            let Some((id, group)) = found.and_then(|id| Some((id, self.groups.get(id)?))) else {
                continue;
            };
            open.extend(&group.children);
            let (at, length) = group.params;
            told.stretches.push((at, at + length));
            let (operator, depth) = (group.operator, group.inside.depth);
            self.count_blend(operator.blend, depth - 1, false);
            self.length -= 2;
            self.groups.remove(id);
        }
    }

    /// Put the groups of a unit in place, into a group; its pieces, which are told the groups that they are in. `stretches` are of
    /// the groups' parameters.
    fn place(
        &mut self,
        items: Vec<Item>,
        group: u32,
        stretches: &mut Vec<(u32, u32)>,
    ) -> Vec<(NodeId, Operand)> {
        let mut pieces = Vec::new();
        let mut at = group;
        for item in items {
            match item {
                Item::Piece(node, operand) => {
                    self.groups.hold(at, node);
                    let operand = Operand {
                        group: at,
                        group_adds: self.groups.inside(at).adds,
                        ..*operand
                    };
                    pieces.push((node, operand));
                }
                Item::Enter(node, around, operator, scale) => {
                    let outside = self.groups.inside(at);
                    let params = self.put_params(&around.params);
                    stretches.push((params, params + around.params.len() as u32));
                    self.count_blend(operator.blend, outside.depth, true);
                    self.length += 2;
                    let group = Group::new(node, &around, operator, &outside, scale, params);
                    at = self.groups.insert(group);
                }
                Item::Leave => at = self.groups.parent_of(at),
            }
        }
        pieces
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

    /// Find out what is touched, in which parts.
    fn tell(&self, told: &mut Touched) {
        let words = |operand: &Operand, begin: u32, end: u32| {
            let at = operand.params.0;
            &self.tables.params[(at + begin) as usize..(at + end) as usize]
        };
        let mut alike = HashSet::new();
        for old in &told.before {
            let there = self.order.get(&old.rank);
            let now = there
                .filter(|node| told.after.contains(node))
                .map(|node| &self.operands[node]);
            let now = now.filter(|now| old.is_alike(now));
            alike.extend(now.map(|now| now.rank));
            for (begin, end) in old.stretches() {
                if let Some(now) = now {
                    if words(old, begin, end) == words(now, begin, end) {
                        continue;
                    }
                    told.stretches
                        .push((now.params.0 + begin, now.params.0 + end));
                }
                told.stretches
                    .push((old.params.0 + begin, old.params.0 + end));
            }
        }
        for node in &told.after {
            let now = &self.operands[node];
            if !alike.contains(&now.rank) {
                let (at, length) = now.params;
                told.stretches.push((at, at + length));
            }
        }
        told.stretches.sort_unstable();
        for (nth, old) in told.before.iter().enumerate() {
            for part in self.parts_of(old) {
                told.near.entry(part).or_default().push(nth);
            }
        }
    }

    /// What the last update has touched; nothing where that may be anything.
    pub fn touched(&self) -> Option<&Touched> {
        self.touched.as_ref().filter(|_| self.is_told)
    }

    /// [`LiveProgram::list`] as it was before the last update, where what that touched is known.
    pub fn list_before(&self, part: IVec3, out: &mut Vec<Instr>) {
        let Some(touched) = self.touched() else {
            return;
        };
        let stays = |node: &NodeId| !touched.after.contains(node);
        let mut own: Vec<usize> = (0..LEVELS)
            .filter_map(|level| touched.near.get(&(level, part >> (2 * level))))
            .flatten()
            .copied()
            .collect();
        own.sort_unstable();
        own.dedup();
        let own = own.into_iter().map(|nth| &touched.before[nth]);
        let everywhere = self.everywhere.iter().filter(|(_, node)| stays(node));
        let was_everywhere = |old: &&Operand| self.is_everywhere(old);
        let mut others: Vec<(u64, &Operand)> = own
            .chain(touched.before.iter().filter(was_everywhere))
            .map(|old| (old.rank, old))
            .chain(everywhere.map(|(&rank, node)| (rank, &self.operands[node])))
            .collect();
        others.sort_by_key(|&(rank, _)| rank);
        let mut others = others.into_iter().peekable();
        let mut writer = Writer::new(&self.groups, out);
        for own in self.near_in(part).iter().filter(|own| stays(&own.node)) {
            while let Some((_, other)) = others.next_if(|&(other, _)| other < own.rank) {
                writer.put(other.group, &other.instrs);
            }
            self.put_near(&mut writer, own);
        }
        others.for_each(|(_, other)| writer.put(other.group, &other.instrs));
        writer.end();
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

    /// Ranks for so many pieces of a node, between those of its neighbours in the scene: what the first is more than, and by how much
    /// each is more than the one before.
    fn ranks_for(&mut self, scene: &Scene, node: NodeId, count: u64) -> (u64, u64) {
        for _ in 0..2 {
            let before = self.neighbour(scene, node, false).unwrap_or(0);
            let Some(after) = self.neighbour(scene, node, true) else {
                return (before, RANK_STEP);
            };
            let step = (after - before) / (count + 1);
            if step > 0 {
                return (before, step);
            }
            // No room: everyone moves.
            self.renumbered = true;
            let order = std::mem::take(&mut self.order);
            for (&node, nth) in order.values().zip(1..) {
                if let Some(operand) = self.operands.get_mut(&node) {
                    operand.rank = nth * RANK_STEP;
                    self.order.insert(operand.rank, node);
                }
            }
            self.index_all();
        }
        unreachable!("a step of 2³² has room for all pieces that there can be")
    }

    /// The rank of the piece that stands before or after a node.
    fn neighbour(&self, scene: &Scene, node: NodeId, is_after: bool) -> Option<u64> {
        let mut at = node;
        loop {
            let parent = scene.node(at).parent()?;
            let siblings = scene.node(parent).children();
            let own = siblings.iter().rposition(|&n| n == at)?;
            let end = |&node: &NodeId| self.end_rank(scene, node, is_after);
            let found = if is_after {
                siblings[own + 1..].iter().find_map(end)
            } else {
                siblings[..own].iter().rev().find_map(end)
            };
            if found.is_some() || parent == Scene::ROOT {
                return found;
            }
            at = parent;
        }
    }

    /// The rank of the first or the last piece of a node.
    fn end_rank(&self, scene: &Scene, node: NodeId, is_first: bool) -> Option<u64> {
        if let Some(operand) = self.operands.get(&node) {
            return Some(operand.rank);
        }
        self.groups.find(node)?;
        let mut children = scene.node(node).children().iter();
        let end = |&node: &NodeId| self.end_rank(scene, node, is_first);
        if is_first {
            children.find_map(end)
        } else {
            children.rev().find_map(end)
        }
    }

    /// How far values can fall through the joints of the root, and of each open group, before anything of a change is lost in
    /// rounding.
    fn needed_falls(&self) -> [f32; 2] {
        let root = greatest(&self.blends);
        [
            greatest_fall(root, self.chamfers > 0, self.parts.far),
            greatest_fall(greatest(&self.inner_blends), false, 0.0),
        ]
    }

    /// By how much joints swell what they join, at most.
    fn swelling(&self) -> f32 {
        let inner = greatest(&self.inner_blends);
        // Groups that are open are no deeper.
        greatest(&self.blends) + if inner > 0.0 { 4.0 * inner } else { 0.0 }
    }

    /// The box in which an operand can matter where it is not everywhere that others do.
    fn grown_box(&self, operand: &Operand) -> Aabb {
        let mut joints = vec![operand.operator];
        let mut at = operand.group;
        while let Some(group) = self.groups.get(at) {
            joints.push(group.operator);
            at = group.parent;
        }
        let outermost_first = joints.iter().rev();
        self.parts
            .reached_by(outermost_first, &operand.extent, self.falls)
    }

    fn is_everywhere(&self, operand: &Operand) -> bool {
        let acts = operand.visible && !operand.extent.aabb.is_empty();
        let is_intersection = operand.operator.kind == OperatorKind::Intersect;
        (operand.visible && is_intersection)
            || (acts && self.parts.level_of(self.grown_box(operand)).is_none())
    }

    /// The parts in which an operand can matter.
    fn parts_of(&self, operand: &Operand) -> impl Iterator<Item = Part> + use<> {
        let is_near = operand.visible
            && operand.operator.kind != OperatorKind::Intersect
            && !operand.extent.aabb.is_empty();
        let found = is_near
            .then(|| self.parts.level_of(self.grown_box(operand)))
            .flatten();
        found.into_iter().flat_map(parts_between)
    }

    /// Enter an operand into the parts.
    fn index(&mut self, node: NodeId) {
        let operand = &self.operands[&node];
        let rank = operand.rank;
        let instr = match operand.instrs[..] {
            [only] => Some(only),
            _ => None,
        };
        let own = Near {
            rank,
            node,
            group: operand.group,
            instr,
        };
        if self.is_everywhere(operand) {
            self.everywhere.insert(rank, node);
        }
        for at in self.parts_of(operand) {
            self.levels = self.levels.max(at.0 + 1);
            let list = self.near.entry(at).or_default();
            if let Err(place) = list.binary_search_by_key(&rank, |near| near.rank) {
                list.insert(place, own);
            }
        }
    }

    /// Enter all operands anew.
    fn index_all(&mut self) {
        // With some room, so that a blend which grows does not do this each time.
        let needed = self.needed_falls();
        self.falls = std::array::from_fn(|i| self.falls[i].max(1.25 * needed[i]));
        self.near.clear();
        self.everywhere.clear();
        let all: Vec<NodeId> = self.order.values().copied().collect();
        all.into_iter().for_each(|node| self.index(node));
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

/// What a node is put together of, as it is met.
enum Item {
    Piece(NodeId, Box<Operand>),
    /// An open group with its operator in the world's unit, and what its unit is in that of the group around.
    Enter(NodeId, Around, Operator, f32),
    Leave,
}

/// Lower a node into a place.
fn lower_into(
    scene: &Scene,
    extents: &mut Extents<'_>,
    node: NodeId,
    place: &Place,
    items: &mut Vec<Item>,
) -> Result<(), LowerError> {
    if !is_open(scene, node, place.depth) {
        let operand = lowered(scene, extents, node, place)?;
        items.push(Item::Piece(node, Box::new(operand)));
        return Ok(());
    }
    let entry = scene.node(node).acting();
    let around = Around::of(scene, node, place.frame)?;
    let scale = scale_of(entry);
    let inside = Place {
        frame: around.frame,
        scale: place.scale * scale,
        depth: place.depth + 1,
        ..*place
    };
    let operator = scaled(&entry.operator, place.scale);
    items.push(Item::Enter(node, around, operator, scale));
    for &child in scene.node(node).children() {
        lower_into(scene, extents, child, &inside, items)?;
    }
    items.push(Item::Leave);
    Ok(())
}

/// Lower a piece; it has no rank yet, and its parameters no place.
fn lowered(
    scene: &Scene,
    extents: &mut Extents<'_>,
    node: NodeId,
    place: &Place,
) -> Result<Operand, LowerError> {
    let entry = scene.node(node).acting();
    let own = Program::lower_piece(scene, node, place.frame, place.scale)?;
    let (opcodes, iterations) = (Opcodes::of(&own), own.iterations());
    Ok(Operand {
        rank: 0,
        group: ROOT,
        group_adds: true,
        instrs: own.instrs,
        own_params: own.params,
        params: (0, 0),
        operator: scaled(&entry.operator, place.scale),
        visible: entry.visible,
        extent: extent_in_world(scene, extents, node),
        regularity: Regularity {
            lipschitz: own.lipschitz,
            slack: own.slack,
            hidden: own.hidden_slack,
            isolation: own.isolation,
            underestimate: if own.hidden_slack > 0.0 {
                own.underestimate
            } else {
                1.0
            },
            ..Regularity::SMOOTH
        },
        magnitude: own.magnitude,
        slots: (own.value_slots, own.point_slots),
        brushes: own.brushes,
        opcodes,
        iterations,
    })
}

/// Append an operand's instructions; the ends of loops point at their beginnings.
pub(crate) fn append(instrs: &[Instr], out: &mut Vec<Instr>) {
    let begin = out.len() as u32;
    out.extend(instrs.iter().map(|&instr| Instr {
        operand: if instr.op == abi::OP_NEXT {
            instr.operand + begin
        } else {
            instr.operand
        },
        ..instr
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil_scene::{Brush, Edit, Group, Modifier, Shape};

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
}
