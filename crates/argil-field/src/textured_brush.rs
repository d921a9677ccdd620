//! Mixes in materials with textures, point by point.

use crate::dispatch::measure;
use crate::eval_brush::{BrushParams, HEADER, mapped};
use crate::interpreter_state::{InterpreterState, lanes_of};
use crate::material_mix::mix_materials;
use crate::scalar::{F32Lanes, LANES, Real};
use crate::textures::{NORMAL_STEP, TexturedPoint, apply, needs_normal};
use crate::{FAR, Program};
use argil_abi as abi;
use glam::Vec3;

/// Corners of a tetrahedron. Differences of distances at them give a normal.
const CORNERS: [[f32; 3]; 4] = [
    [1.0, -1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [-1.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
];

/// Mixes in a brush's material, given the weights of lanes.
#[inline(never)]
pub(crate) fn mix_textured<R: Real>(
    program: &Program,
    r: &mut InterpreterState<R>,
    instr: &abi::Instruction,
    b: &BrushParams,
    weights: &F32Lanes,
) {
    let plain = program.materials.appearance(instr.operand as usize);
    let mut appearances = [plain; LANES];
    let is_seen = |i: usize| weights.0[i] != 0.0;
    if lanes_of(r.active).any(is_seen) {
        let words: &[f32] = bytemuck::cast_slice(program.material_table());
        let record = (instr.flags >> abi::TEXTURES_SHIFT) as usize;
        let size = needs_normal(words, record);
        let normals = size.map(|size| normals(program, r, instr, b, NORMAL_STEP * size));
        for i in lanes_of(r.active).filter(|&i| is_seen(i)) {
            let p = [0, 1, 2].map(|axis| R::get(&r.point[axis], i).value());
            let local = Vec3::from(mapped(p, &b.m));
            let normal = normals.as_ref().map_or(Vec3::Y, |all| all[i]);
            let m = &b.m;
            let in_scene = Vec3::new(m[0], m[1], m[2]) * normal.x
                + Vec3::new(m[4], m[5], m[6]) * normal.y
                + Vec3::new(m[8], m[9], m[10]) * normal.z;
            let at = TexturedPoint {
                points: [local, Vec3::from(r.at.each_ref().map(|axis| axis.0[i]))],
                normals: [normal, in_scene],
            };
            apply(words, record, &at, &mut appearances[i]);
        }
    }
    mix_materials(r, |k, i| appearances[i][k], weights);
}

/// Returns normals of a brush's own shape, in its space, of any length.
fn normals<R: Real>(
    program: &Program,
    r: &mut InterpreterState<R>,
    instr: &abi::Instruction,
    b: &BrushParams,
    step: f32,
) -> [Vec3; LANES] {
    let mut found = [Vec3::ZERO; LANES];
    let kept = r.acc.clone();
    for corner in CORNERS {
        let mut moved = b.clone();
        for (axis, offset) in corner.into_iter().enumerate() {
            moved.m[4 * axis + 3] += step * offset;
        }
        for i in lanes_of(r.active) {
            R::set(&mut r.acc, i, R::constant(FAR));
        }
        let at = instr.params as usize + HEADER;
        measure(program, r, instr.op, instr.flags, &moved, at);
        for i in lanes_of(r.active) {
            found[i] += Vec3::from(corner) * R::get(&r.acc, i).value();
        }
    }
    r.acc = kept;
    found
}
