//! Sampling bricks.

use super::BrickLayout;
use super::material::{PLACES, packed};
use crate::Texel;
use crate::encoding::encode;
use argil_abi::{BRICK_MIXED, Fill, Instr, MATERIAL_SIDE, MaterialWords};
use argil_field::{Evaluator, LANES, Program};
use glam::{UVec3, uvec3};
use multiversion::multiversion;

/// Evaluates bricks for one thread.
pub(super) struct Filler<'a> {
    program: &'a Program,
    layout: &'a BrickLayout,
    fill: &'a Fill,
    evaluator: Evaluator<'a>,
    /// Of each sample of a brick, in the order of the pool: its place along x, y and z.
    places: [Vec<f32>; 3],
    d: Vec<f32>,
}

impl<'a> Filler<'a> {
    pub fn new(program: &'a Program, layout: &'a BrickLayout, fill: &'a Fill) -> Self {
        let side = layout.brick + 1;
        let of = |divisor: u32| -> Vec<f32> {
            (0..layout.brick_samples())
                .map(|i| (i / divisor % side) as f32)
                .collect()
        };
        Self {
            program,
            layout,
            fill,
            evaluator: Evaluator::new(program),
            places: [of(1), of(side), of(side * side)],
            d: vec![0.0; layout.brick_samples() as usize],
        }
    }

    /// Sample a cell's brick; the distance that is nearest to the surface.
    pub fn brick<T: Texel>(&mut self, instrs: &[Instr], cell: UVec3, out: &mut [T]) -> f32 {
        let lattice = &self.layout.lattice;
        let first = (cell * self.layout.brick).as_vec3();
        let [mut x, mut y, mut z] = [[0.0f32; LANES]; 3];
        for begin in (0..self.d.len()).step_by(LANES) {
            let n = LANES.min(self.d.len() - begin);
            for (axis, out) in [&mut x, &mut y, &mut z].into_iter().enumerate() {
                let (corner, first) = (lattice.corner[axis], first[axis]);
                let places = &self.places[axis][begin..begin + n];
                for (out, place) in out[..n].iter_mut().zip(places) {
                    *out = corner + lattice.voxel * (first + place);
                }
            }
            let d = &mut self.d[begin..begin + n];
            self.evaluator
                .distances_by(instrs, &x[..n], &y[..n], &z[..n], d);
        }
        encode(&self.d, self.fill, out);
        nearest(&self.d)
    }

    /// What a cell's brick looks like: one material, or a mixed brick's place among the block's.
    pub fn material(&mut self, instrs: &[Instr], cell: UVec3, mixed: &mut Vec<[u32; 2]>) -> u32 {
        let takes = |i: &&Instr| {
            i.op < argil_abi::OP_SHAPES_END && i.flags & argil_abi::FLAG_KEEP_MATERIAL == 0
        };
        let mut all = instrs.iter().filter(takes).map(|i| i.operand);
        let first = all.next().unwrap_or(0);
        if all.all(|other| other == first) {
            return first;
        }
        let lattice = &self.layout.lattice;
        let begin = (cell * self.layout.brick).as_vec3();
        let step = self.layout.brick as f32 / (MATERIAL_SIDE - 1) as f32;
        let [mut x, mut y, mut z, mut d] = [[0.0f32; PLACES]; 4];
        for i in 0..PLACES {
            let place = i as u32;
            let place = uvec3(
                place % MATERIAL_SIDE,
                place / MATERIAL_SIDE % MATERIAL_SIDE,
                place / MATERIAL_SIDE / MATERIAL_SIDE,
            );
            let p = lattice.corner + lattice.voxel * (begin + step * place.as_vec3());
            (x[i], y[i], z[i]) = (p.x, p.y, p.z);
        }
        let mut found = [MaterialWords::default(); PLACES];
        self.evaluator
            .materials_by(instrs, [&x, &y, &z], &mut d, &mut found);
        // Between places that are farther from the surface than the diagonal from one to the next, there is none.
        let reach = 1.01 * self.program.lipschitz() * 3f32.sqrt() * step * lattice.voxel;
        let mut near = found.iter().zip(&d).filter(|(_, d)| d.abs() <= reach);
        let palette = self.program.materials();
        if let Some(one) = near.next().map(|(m, _)| packed(m))
            && near.all(|(m, _)| packed(m) == one)
            && let Some(place) = palette.iter().position(|m| packed(m) == one)
        {
            return place as u32;
        }
        mixed.extend(found.iter().map(packed));
        BRICK_MIXED | (mixed.len() / PLACES - 1) as u32
    }
}

/// The value of least magnitude.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn nearest(d: &[f32]) -> f32 {
    // Positive floats are ordered as their bits; the sign goes to the lowest bit.
    let least = d
        .iter()
        .map(|d| d.to_bits().rotate_left(1))
        .fold(u32::MAX, |a, b| if b < a { b } else { a });
    f32::from_bits(least.rotate_right(1))
}
