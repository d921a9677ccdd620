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

/// A brush that an update moved, turned or scaled as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovedBrush {
    /// The piece that has it.
    pub piece: NodeId,
    /// The number of its instruction in the piece.
    pub nth: usize,
    /// Maps a point of the brush to where that point was.
    pub before_from_now: DAffine3,
}

/// Brushes that moved, and what else there is near them, for a device that asks where the points of a surface were.
#[derive(Clone, Debug)]
pub struct BrushMotion {
    /// A program that gives the scene's distances in the boxes. Its parameters are the scene's.
    pub instructions: Vec<Instruction>,
    boxes: Vec<Aabb>,
    /// The place of each brush's parameters, and its map.
    brushes: BTreeMap<u32, DAffine3>,
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
        let corners = self.boxes.iter().flat_map(|own| [own.min, own.max]);
        all.extend(corners.map(corner));
        for (&params, map) in &self.brushes {
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
    /// Returns the brushes that the last update moved, turned or scaled. A brush that only changed its form is none of them, and
    /// neither is one that moved inside of a modifier, such as a repetition.
    pub fn moved(&self) -> Vec<MovedBrush> {
        let Some(touched) = &self.update.touched else {
            return Vec::new();
        };
        let mut all = Vec::new();
        for (before, &piece) in touched.before.iter().zip(&touched.nodes) {
            let Some(now) = self.operands.get(&piece) else {
                continue;
            };
            let ops = |of: &Operand| of.instructions.iter().map(|own| own.op).collect::<Vec<_>>();
            if ops(before) == ops(now) {
                let maps = self.first_maps(before).into_iter();
                for ((nth, old), (_, new)) in maps.zip(self.first_maps(now)) {
                    let before_from_now = old.inverse() * new;
                    if old != new && before_from_now.is_finite() {
                        all.push(MovedBrush {
                            piece,
                            nth,
                            before_from_now,
                        });
                    }
                }
            }
        }
        all
    }

    /// Returns brushes that updates moved, one update after another, with what is near them now. Returns `None` if nothing of them
    /// is there.
    pub fn motion_of<'a>(
        &self,
        updates: impl IntoIterator<Item = &'a [MovedBrush]>,
    ) -> Option<BrushMotion> {
        let mut maps: BTreeMap<(NodeId, usize), DAffine3> = BTreeMap::new();
        for own in updates.into_iter().flatten() {
            let map = maps
                .entry((own.piece, own.nth))
                .or_insert(DAffine3::IDENTITY);
            *map *= own.before_from_now;
        }
        let (mut boxes, mut brushes) = (Vec::new(), BTreeMap::new());
        let air = self.counts.max_outward_offset();
        let mut last = None;
        for ((piece, nth), map) in maps {
            let operand = self.operands.get(&piece).filter(|own| own.takes_part);
            let Some((operand, instr)) =
                operand.and_then(|own| Some((own, own.instructions.get(nth)?)))
            else {
                continue;
            };
            brushes.insert(instr.params, map);
            if last.replace(piece) != Some(piece) {
                let held = operand.extent.aabb;
                // What a sphere of rays finds lies a little beside the surface.
                boxes.push(
                    held.grown(air + 0.01 * held.size().max_element().min(self.index.parts.far)),
                );
            }
        }
        if boxes.is_empty() {
            return None;
        }
        if boxes.len() > MAX_BOXES {
            boxes = vec![boxes.into_iter().fold(Aabb::EMPTY, Aabb::union)];
        }
        let mut instructions = Vec::new();
        self.list_near(&boxes, &mut instructions);
        Some(BrushMotion {
            instructions,
            boxes,
            brushes,
        })
    }

    /// Returns the first maps of each brush of a piece, as one: those before anything that is no map. A brush has its number of an
    /// instruction.
    fn first_maps(&self, piece: &Operand) -> Vec<(usize, DAffine3)> {
        let mut all = Vec::new();
        // Whether only maps came before, and these.
        let mut place = (true, DAffine3::IDENTITY);
        let mut kept = Vec::new();
        for (nth, instr) in piece.instructions.iter().enumerate() {
            match instr.op {
                op if op < abi::OP_SHAPES_END => all.push((nth, self.with_map(place, instr).1)),
                abi::OP_AFFINE => place = self.with_map(place, instr),
                abi::OP_PUSH_POINT => kept.push(place),
                abi::OP_POP_POINT
                | abi::OP_NEXT
                | abi::OP_UNCLAMP
                | abi::OP_EXTRUDE
                | abi::OP_UNWRAP => {
                    place = kept.pop().unwrap_or(place);
                }
                abi::OP_REPEAT
                | abi::OP_RADIAL
                | abi::OP_TWIST
                | abi::OP_BEND
                | abi::OP_FLATTEN
                | abi::OP_WRAP => {
                    kept.push(place);
                    place.0 = false;
                }
                abi::OP_MIRROR | abi::OP_ELONGATE | abi::OP_REVOLVE | abi::OP_SHIFT => {
                    place.0 = false
                }
                _ => {}
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
        let own = DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), t);
        (true, own * map)
    }
}
