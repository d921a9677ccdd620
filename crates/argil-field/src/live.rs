//! A program that follows a scene edit by edit, at the cost of what an edit touches.
//!
//! *Practice.* Each operand of the root is lowered on its own; its parameters stand in a table that all of them share. A
//! coarse grid of parts knows which operands can matter in each, by their boxes grown as far as [dirty
//! boxes](argil_scene::Change) reach: the list for a part is theirs, in the scene's order. In the part it gives the
//! scene's distances, as far as those are below the live program's far length. What remains linear in the number of
//! operands, with a small factor, is finding an operand's place in the order.

use crate::loose::{self, Loose, loose_of};
use crate::lower::materials_of;
use crate::operands::OperandSpan;
use crate::parts::{LEVELS, Part, Parts, parts_between};
use crate::program::Program;
use crate::regular::{Regularity, joined};
use crate::{ClearTerms, LowerError, Opcodes};
use argil_abi::{self as abi, Instr};
use argil_math::Aabb;
use argil_scene::{
    Change, Extent, Extents, NodeId, Operator, OperatorKind, Profile, Scene, greatest_fall,
};
use glam::{IVec3, Vec3};
use rustc_hash::{FxHashMap, FxHashSet};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Ranks between neighbours, to begin with.
const RANK_STEP: u64 = 1 << 32;

/// An operand of the root.
struct Operand {
    /// Where it stands in the order.
    rank: u64,
    instrs: Vec<Instr>,
    /// Its parameters, until they have a place.
    own_params: Vec<f32>,
    /// Its stretch of the parameters.
    params: (u32, u32),
    operator: Operator,
    visible: bool,
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
    operands: HashMap<NodeId, Operand>,
    /// All operands in the scene's order.
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
    chamfers: u32,
    morphs: u32,
    /// How far values can fall, as far as `near` allows for it.
    falls: f32,
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
            order: BTreeMap::new(),
            near: FxHashMap::default(),
            levels: 1,
            everywhere: BTreeMap::new(),
            free: HashMap::new(),
            magnitudes: BTreeMap::new(),
            blends: BTreeMap::new(),
            chamfers: 0,
            morphs: 0,
            falls: 0.0,
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
        let nodes = scene.node(Scene::ROOT).children();
        let mut all = Vec::with_capacity(nodes.len());
        for (&node, nth) in nodes.iter().zip(1..) {
            let mut operand = lowered(scene, &mut extents, node)?;
            operand.rank = nth * RANK_STEP;
            all.push((node, operand));
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
        let mut touched: Vec<NodeId> = changes
            .iter()
            .flat_map(|change| change.operands)
            .flatten()
            .collect();
        touched.sort_unstable();
        touched.dedup();
        let mut extents = Extents::of(scene);
        let mut there = Vec::new();
        for &node in &touched {
            if scene.operand_of(node) == Some(node) {
                there.push((node, lowered(scene, &mut extents, node)?));
            }
        }
        self.written.clear();
        for old in self.touched.take().unwrap_or_default().before {
            let (at, length) = old.params;
            self.free.entry(length).or_default().push(at);
        }
        let mut plain = true;
        (self.put, self.touched_ends) = (Aabb::EMPTY, false);
        let mut told = Touched::default();
        let mut is_told = self.morphs == 0;
        for &node in &touched {
            if let Some(old) = self.remove(node) {
                plain &= old.is_plain();
                self.touched_ends |= old.ends();
                told.before.push(old);
            }
        }
        self.renumbered = false;
        for (node, mut operand) in there {
            operand.rank = self.rank_for(scene, node);
            plain &= operand.is_plain();
            told.after.insert(node);
            self.touched_ends |= operand.ends();
            if operand.adds() {
                self.put = self.put.union(operand.extent.aabb);
            }
            self.insert(node, operand);
            self.index(node);
        }
        // Blends swell what they join.
        self.put = self.put.grown(greatest(&self.blends));
        self.tables.aabb = self.tables.aabb.union(self.put);
        if self.needed_falls() > self.falls {
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
        if self.morphs > 0 {
            // A morph takes its share of everything; the first operand to act is one that adds.
            let all = self.order.values().map(|node| &self.operands[node]);
            let acting = all
                .filter(|operand| operand.visible)
                .skip_while(|operand| operand.operator.kind != OperatorKind::Union);
            acting.for_each(|operand| append(&operand.instrs, out));
            return;
        }
        let mut others = self.everywhere.iter().map(|(&r, &n)| (r, n)).peekable();
        for own in self.near_in(part).iter() {
            while let Some((_, other)) = others.next_if(|&(other, _)| other < own.rank) {
                append(&self.operands[&other].instrs, out);
            }
            match own.instr {
                Some(instr) => out.push(instr),
                None => append(&self.operands[&own.node].instrs, out),
            }
        }
        others.for_each(|(_, other)| append(&self.operands[&other].instrs, out));
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
        let all = self.order.values().map(|node| &self.operands[node]);
        let acting = all
            .filter(|operand| operand.visible)
            .skip_while(|operand| operand.operator.kind != OperatorKind::Union);
        for operand in acting {
            append(&operand.instrs, &mut whole.instrs);
            whole.brushes += operand.brushes;
            whole.operands.push(OperandSpan {
                end: whole.instrs.len() as u32,
                operator: operand.operator,
                extent: operand.extent,
            });
        }
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
        let params = &mut self.tables.params;
        let at = match self.free.get_mut(&length).and_then(Vec::pop) {
            Some(at) => {
                params[at as usize..(at + length) as usize].copy_from_slice(&own);
                at
            }
            None => {
                let at = params.len() as u32;
                params.extend_from_slice(&own);
                at
            }
        };
        for instr in &mut operand.instrs {
            instr.params += at;
        }
        operand.params = (at, length);
        self.written.push((at, at + length));
        self.length += operand.instrs.len();
        self.iterations += operand.iterations;
        self.opcodes = self.opcodes.union(operand.opcodes);
        let slots = (&mut self.tables.value_slots, &mut self.tables.point_slots);
        *slots.0 = operand.slots.0.max(*slots.0);
        *slots.1 = operand.slots.1.max(*slots.1);
        self.order.insert(operand.rank, node);
        self.count_in(&operand, true);
        self.operands.insert(node, operand);
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
        for own in self.near_in(part).iter().filter(|own| stays(&own.node)) {
            while let Some((_, other)) = others.next_if(|&(other, _)| other < own.rank) {
                append(&other.instrs, out);
            }
            match own.instr {
                Some(instr) => out.push(instr),
                None => append(&self.operands[&own.node].instrs, out),
            }
        }
        others.for_each(|(_, other)| append(&other.instrs, out));
    }

    fn count_in(&mut self, operand: &Operand, is_there: bool) {
        if !operand.visible {
            return;
        }
        count(&mut self.magnitudes, operand.magnitude, is_there);
        count(&mut self.blends, operand.operator.blend, is_there);
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

    /// A rank between those of a node's neighbours in the scene.
    fn rank_for(&mut self, scene: &Scene, node: NodeId) -> u64 {
        let siblings = scene.node(Scene::ROOT).children();
        let at = siblings.iter().rposition(|&n| n == node).unwrap_or(0);
        let rank_of = |n: &NodeId| self.operands.get(n).map(|operand| operand.rank);
        let before = siblings[..at].iter().rev().find_map(rank_of).unwrap_or(0);
        let after = siblings[at + 1..].iter().find_map(rank_of);
        let rank = match after {
            Some(after) => before + (after - before) / 2,
            None => before + RANK_STEP,
        };
        if rank > before {
            return rank;
        }
        // No room: everyone moves.
        self.renumbered = true;
        self.order.clear();
        self.everywhere.clear();
        for (i, sibling) in siblings.iter().enumerate() {
            if let Some(operand) = self.operands.get_mut(sibling) {
                operand.rank = (i as u64 + 1) * RANK_STEP;
                self.order.insert(operand.rank, *sibling);
            }
        }
        self.index_all();
        (at as u64 + 1) * RANK_STEP
    }

    /// How far values can fall through the joints of operands, before anything of a change is lost in rounding.
    fn needed_falls(&self) -> f32 {
        greatest_fall(greatest(&self.blends), self.chamfers > 0, self.parts.far)
    }

    /// The box in which an operand can matter where it is not everywhere that others do.
    fn grown_box(&self, operand: &Operand) -> Aabb {
        self.parts
            .reached_by(&operand.operator, &operand.extent, self.falls)
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
        let own = Near { rank, node, instr };
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
        self.falls = self.falls.max(1.25 * self.needed_falls());
        self.near.clear();
        self.everywhere.clear();
        let all: Vec<NodeId> = self.order.values().copied().collect();
        all.into_iter().for_each(|node| self.index(node));
    }

    /// How regular the whole is.
    fn settle(&mut self) {
        let mut all = Regularity::SMOOTH;
        for node in self.order.values() {
            let operand = &self.operands[node];
            if operand.visible {
                all = joined(all, operand.regularity, &operand.operator);
            }
        }
        // Each operand has told its own underestimate.
        let all = all.settled(1.0);
        let loose = if all.slack + all.hidden == 0.0 {
            Vec::new()
        } else {
            let visible = self.order.values().rev().map(|node| &self.operands[node]);
            let visible = visible.filter(|operand| operand.visible);
            let told = visible.map(|operand| loose::Operand {
                operator: &operand.operator,
                regularity: operand.regularity,
                extent: operand.extent,
            });
            loose_of(told, all)
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
        boxes.grown(greatest(&self.blends))
    }
}

/// Lower an operand; it has no rank yet, and its parameters no place.
fn lowered(scene: &Scene, extents: &mut Extents<'_>, node: NodeId) -> Result<Operand, LowerError> {
    let entry = scene.node(node).acting();
    let own = Program::lower_operand(scene, node)?;
    let (opcodes, iterations) = (Opcodes::of(&own), own.iterations());
    Ok(Operand {
        rank: 0,
        instrs: own.instrs,
        own_params: own.params,
        params: (0, 0),
        operator: entry.operator,
        visible: entry.visible,
        extent: extents.outer(node),
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
