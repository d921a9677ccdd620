//! How far updates moved brushes.

use super::IncrementalProgram;
use super::piece::Operand;
use argil_abi::{self as abi, Instruction};
use argil_math::Aabb;
use argil_scene::NodeId;
use glam::{DAffine3, DMat3, DVec3, Vec3};
use std::collections::BTreeMap;

/// With more boxes, one around all of them is kept.
const MAX_BOXES: usize = 64;
/// With more brushes in an update, what moved is not known.
const MAX_BRUSHES: usize = 1024;
/// With more instructions near what moved, nothing is followed: each pixel there runs all of them.
const MAX_INSTRUCTIONS: usize = 4096;

/// A brush that an update moved, turned or scaled as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovedBrush {
    /// The piece that has it.
    pub piece: NodeId,
    /// The number of its instruction in the piece.
    pub index: usize,
    /// The number of the piece's instructions.
    pub count: usize,
    /// Maps a point of the brush to where that point was.
    pub before_from_now: DAffine3,
}

/// Brushes that moved, and what else there is near them, for a device that asks where the points of a surface were.
#[derive(Clone, Debug)]
pub struct BrushMotion {
    /// A program that gives the scene's distances in the boxes. Its parameters are the scene's.
    pub instructions: Vec<Instruction>,
    boxes: Vec<Aabb>,
    /// The place of each brush's parameters, ascending, and its map.
    brushes: Vec<(u32, DAffine3)>,
}

impl BrushMotion {
    /// Returns what [`Interpreter::motion_wgsl`](crate::Interpreter::motion_wgsl) reads as `moved`.
    pub fn words(&self) -> Vec<[u32; 4]> {
        let corner = |corner: Vec3| {
            let bits = corner
                .clamp(Vec3::splat(-1e30), Vec3::splat(1e30))
                .to_array();
            [bits[0].to_bits(), bits[1].to_bits(), bits[2].to_bits(), 0]
        };
        let mut all = vec![[self.boxes.len() as u32, self.brushes.len() as u32, 0, 0]];
        let corners = self
            .boxes
            .iter()
            .flat_map(|region| [region.min, region.max]);
        all.extend(corners.map(corner));
        for &(params, map) in &self.brushes {
            all.push([params, 0, 0, 0]);
            // A way is what the map changes, which is small.
            let way = (map.matrix3 - DMat3::IDENTITY).transpose();
            for axis in 0..3 {
                let row = way.col(axis).as_vec3();
                let shift = map.translation[axis] as f32;
                all.push([row.x, row.y, row.z, shift].map(f32::to_bits));
            }
        }
        all
    }
}

impl IncrementalProgram {
    /// Returns the brushes of each piece that the last update moved, turned or scaled, or in which it did so to one thing. A piece
    /// that only changed its form is none of them, and neither is one in which something moved inside of a modifier, such as a
    /// repetition. Returns `None` if they are more than 1,024.
    pub fn moved(&self) -> Option<Vec<MovedBrush>> {
        let Some(touched) = &self.update.touched else {
            return Some(Vec::new());
        };
        let mut all = Vec::new();
        for (before, &piece) in touched.before.iter().zip(&touched.nodes) {
            let Some(now) = self.operands.get(&piece) else {
                continue;
            };
            let [old, new] = [before, now].map(|of| self.first_maps(of));
            // Maps around them may come and go.
            let ops = |of: &Operand, all: &[(usize, DAffine3)]| -> Vec<u32> {
                all.iter()
                    .map(|&(index, _)| of.instructions[index].op)
                    .collect()
            };
            if ops(before, &old) != ops(now, &new) {
                continue;
            }
            let pairs = old.into_iter().zip(new);
            let moves = pairs.map(|((_, old), (index, new))| MovedBrush {
                piece,
                index,
                count: now.instructions.len(),
                // Exact where nothing moved.
                before_from_now: match old == new {
                    true => DAffine3::IDENTITY,
                    false => old.inverse() * new,
                },
            });
            let moves: Vec<MovedBrush> = moves.collect();
            let mut changed = moves
                .iter()
                .map(|brush| brush.before_from_now)
                .filter(|map| *map != DAffine3::IDENTITY);
            // Where brushes change their places in the piece, each has another map.
            if let Some(first) = changed.next()
                && first.is_finite()
                && changed.all(|map| is_like(&first, &map))
            {
                all.extend(moves);
            }
            if all.len() > MAX_BRUSHES {
                return None;
            }
        }
        Some(all)
    }

    /// Returns brushes that updates moved, one update after another, with what is near them now. Returns `None` if nothing of them
    /// is there, or so much is near them that it is not followed.
    pub fn motion_of<'a>(
        &self,
        updates: impl IntoIterator<Item = &'a [MovedBrush]>,
    ) -> Option<BrushMotion> {
        let mut maps: BTreeMap<(NodeId, usize), DAffine3> = BTreeMap::new();
        let is_as_it_was = |brush: &&MovedBrush| {
            let now = self.operands.get(&brush.piece);
            now.is_some_and(|now| now.instructions.len() == brush.count)
        };
        for brush in updates.into_iter().flatten().filter(is_as_it_was) {
            let map = maps
                .entry((brush.piece, brush.index))
                .or_insert(DAffine3::IDENTITY);
            *map *= brush.before_from_now;
        }
        let mut boxes = Vec::new();
        let mut brushes: BTreeMap<u32, Option<DAffine3>> = BTreeMap::new();
        let air = self.counts.max_outward_offset();
        let mut last = None;
        for ((piece, index), map) in maps {
            let operand = self
                .operands
                .get(&piece)
                .filter(|piece_operand| piece_operand.takes_part);
            let Some((operand, instr)) = operand.and_then(|piece_operand| {
                Some((piece_operand, piece_operand.instructions.get(index)?))
            }) else {
                continue;
            };
            // Copies share parameters, and are not told apart if they moved differently.
            brushes
                .entry(instr.params)
                .and_modify(|known| *known = known.filter(|other| is_like(other, &map)))
                .or_insert(Some(map));
            if last.replace(piece) != Some(piece) {
                // A stored surface lies a little beside the field's.
                let beside = 0.1 * self.index.parts.far;
                boxes.push(operand.extent.aabb.grown(air + beside));
            }
        }
        if boxes.is_empty() {
            return None;
        }
        if boxes.len() > MAX_BOXES {
            boxes = vec![boxes.into_iter().fold(Aabb::EMPTY, Aabb::union)];
        }
        let mut instructions = Vec::new();
        let is_listed = self.list_near(&boxes, &mut instructions);
        if !is_listed || instructions.len() > MAX_INSTRUCTIONS {
            return None;
        }
        Some(BrushMotion {
            instructions,
            boxes,
            brushes: brushes
                .into_iter()
                .filter_map(|(params, map)| Some((params, map?)))
                .collect(),
        })
    }

    /// Returns the first maps of each brush of a piece, as one: those before anything that is no map. A brush has its number of an
    /// instruction.
    fn first_maps(&self, piece: &Operand) -> Vec<(usize, DAffine3)> {
        let mut all = Vec::new();
        // Whether only maps came before, and these.
        let mut place = (true, DAffine3::IDENTITY);
        let mut kept = Vec::new();
        for (index, instr) in piece.instructions.iter().enumerate() {
            let op = instr.op;
            if op < abi::OP_SHAPES_END {
                all.push((index, self.with_map(place, instr).1));
            } else if op == abi::OP_AFFINE {
                place = self.with_map(place, instr);
            } else if op == abi::OP_PUSH_POINT {
                kept.push(place);
            } else if abi::restores_point(op) || op == abi::OP_NEXT {
                place = kept.pop().unwrap_or(place);
            } else if abi::saves_point(op) || matches!(op, abi::OP_REPEAT | abi::OP_RADIAL) {
                kept.push(place);
                place.0 = false;
            } else if abi::moves_point(op) {
                place.0 = false;
            }
        }
        all
    }

    /// Returns a place behind an instruction's map, if only maps came before.
    fn with_map(&self, (is_first, map): (bool, DAffine3), instr: &Instruction) -> (bool, DAffine3) {
        if !is_first {
            return (false, map);
        }
        let rows: [f32; 12] =
            std::array::from_fn(|i| self.tables.params[instr.params as usize + i]);
        let [x, y, z, t] = std::array::from_fn(|i| {
            DVec3::new(rows[i].into(), rows[4 + i].into(), rows[8 + i].into())
        });
        let placement = DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), t);
        (true, placement * map)
    }
}

/// Whether two maps differ only by rounding.
fn is_like(a: &DAffine3, b: &DAffine3) -> bool {
    a.abs_diff_eq(*b, 1e-5 * (1.0 + a.translation.length()))
}
