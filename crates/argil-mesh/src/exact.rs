//! What the exact field says of a mesh that was made from its bricks.

use crate::Mesh;
use crate::marching::bricks::{Group, Marched};
use argil_abi::{Instr, MaterialWords};
use argil_field::{Evaluator, LANES, Program};
use argil_volume::CellLists;
use glam::Vec3;
use rayon::prelude::*;

/// Move the vertices of a mesh along their edges to where the exact field is 0, and give them its gradients as normals. One
/// look at the field, between the stored samples: false position, so that no vertex leaves its edge.
pub fn refine(program: &Program, lists: &CellLists, marched: &mut Marched) {
    let Marched {
        mesh,
        groups,
        spans,
    } = marched;
    mesh.normals = vec![Vec3::ZERO; mesh.positions.len()];
    let voxel = lists.layout().lattice.voxel;
    let jobs = split(groups, &mut mesh.positions, &mut mesh.normals);
    let whole = program.instrs();
    jobs.into_par_iter().with_min_len(8).for_each_init(
        || (Evaluator::new(program), Box::new([[0.0; LANES]; 7])),
        |(evaluator, room), (group, positions, normals)| {
            // A file's bricks may be where the field is not.
            let list = lists.list(group.cell).unwrap_or(whole);
            let mut at = group.begin as usize;
            let parts = positions.chunks_mut(LANES).zip(normals.chunks_mut(LANES));
            for (positions, normals) in parts {
                let n = positions.len();
                look(evaluator, list, positions, room);
                let [_, _, _, d, gx, gy, gz] = &**room;
                for i in 0..n {
                    let axis = group.ends.iter().position(|&end| at < end as usize);
                    let axis = axis.unwrap_or(0);
                    positions[i][axis] += voxel * correction(spans[at], d[i]);
                    normals[i] = Vec3::new(gx[i], gy[i], gz[i]).normalize_or_zero();
                    at += 1;
                }
            }
        },
    );
}

/// By how much of an edge a vertex moves at which the distance is `d`, and which was set between two stored ones.
fn correction([a, b]: [f32; 2], d: f32) -> f32 {
    let t = crate::marching::dense::part(a, b, 0.0);
    // The part of the edge on which the sign changes.
    let step = if (d < 0.0) == (a < 0.0) {
        (1.0 - t) * crate::marching::dense::part(d, b, 0.0)
    } else {
        -t * (1.0 - crate::marching::dense::part(a, d, 0.0))
    };
    if step.is_finite() { step } else { 0.0 }
}

fn look(
    evaluator: &mut Evaluator<'_>,
    list: &[Instr],
    positions: &[Vec3],
    room: &mut [[f32; LANES]; 7],
) {
    let n = positions.len();
    let [x, y, z, d, gx, gy, gz] = room;
    for (i, p) in positions.iter().enumerate() {
        (x[i], y[i], z[i]) = (p.x, p.y, p.z);
    }
    let gradients = [&mut gx[..n], &mut gy[..n], &mut gz[..n]];
    evaluator.gradients_by(list, [&x[..n], &y[..n], &z[..n]], &mut d[..n], gradients);
}

/// A group with its own vertices.
type Job<'a, T> = (Group, &'a mut [Vec3], &'a mut [T]);

fn split<'a, T>(
    groups: &[Group],
    mut positions: &'a mut [Vec3],
    mut others: &'a mut [T],
) -> Vec<Job<'a, T>> {
    let mut jobs = Vec::with_capacity(groups.len());
    for group in groups {
        let n = (group.ends[2] - group.begin) as usize;
        let (own, rest) = positions.split_at_mut(n);
        positions = rest;
        let (own_others, rest) = others.split_at_mut(n);
        others = rest;
        jobs.push((*group, own, own_others));
    }
    jobs
}

/// Give the vertices the field's materials.
pub fn materials(program: &Program, lists: &CellLists, marched: &mut Marched) {
    let Marched { mesh, groups, .. } = marched;
    let Mesh {
        positions,
        materials,
        ..
    } = mesh;
    *materials = vec![MaterialWords::default(); positions.len()];
    if let [only] = program.materials() {
        materials.fill(*only);
        return;
    }
    let jobs = split(groups, positions, materials);
    jobs.into_par_iter().with_min_len(8).for_each_init(
        || (Evaluator::new(program), Box::new([[0.0; LANES]; 4])),
        |(evaluator, room), (group, positions, materials)| {
            let list = lists.list(group.cell).unwrap_or(program.instrs());
            let parts = positions.chunks(LANES).zip(materials.chunks_mut(LANES));
            for (positions, materials) in parts {
                let n = positions.len();
                let [x, y, z, d] = &mut **room;
                for (i, p) in positions.iter().enumerate() {
                    (x[i], y[i], z[i]) = (p.x, p.y, p.z);
                }
                let places = [&x[..n], &y[..n], &z[..n]];
                evaluator.materials_by(list, places, &mut d[..n], materials);
            }
        },
    );
}
