//! Projects a mesh of bricks onto the exact field.

use crate::Mesh;
use crate::marching::bricks::{BrickVertexRange, MarchedMesh};
use crate::marching::dense::{clamp, edge_crossing};
use argil_abi::{GpuMaterial, Instruction};
use argil_field::{Evaluator, LANES, Program};
use argil_volume::CellPrograms;
use glam::Vec3;
use rayon::prelude::*;

/// How far outside the surface the gradient is evaluated, in edges. Where a distance is nearly 0, its gradient is
/// only rounding error.
const OUT: f32 = 0.05;

/// Moves the vertices of a mesh along their edges to where the exact field is 0, and gives them its gradients as
/// normals, if they are wanted.
///
/// One evaluation of the distance, between the stored samples, gives one step of false position, so no vertex
/// leaves its edge. One evaluation of the gradient follows, next to the surface.
///
/// # Panics
/// If `surface` was not made from bricks of this program and these cell programs.
pub fn project_to_field(
    program: &Program,
    cell_programs: &CellPrograms,
    surface: &mut MarchedMesh,
    with_normals: bool,
) {
    let MarchedMesh {
        mesh,
        groups,
        edge_distances: spans,
    } = surface;
    mesh.normals = vec![Vec3::ZERO; mesh.positions.len()];
    let voxel = cell_programs.layout().voxel_grid().voxel_size;
    let jobs = split(groups, &mut mesh.positions, &mut mesh.normals);
    let whole = program.instructions();
    jobs.into_par_iter().with_min_len(8).for_each_init(
        || (Evaluator::new(program), Box::new([[0.0; LANES]; 7])),
        |(evaluator, room), (group, positions, normals)| {
            // Bricks of a file may be where the field is not.
            let list = cell_programs.cell_program(group.cell).unwrap_or(whole);
            let mut at = group.begin as usize;
            let parts = positions.chunks_mut(LANES).zip(normals.chunks_mut(LANES));
            for (positions, normals) in parts {
                let n = positions.len();
                let axis_of = |at: usize| {
                    let axis = group.ends.iter().position(|&end| at < end as usize);
                    axis.expect("a vertex of the group")
                };
                measure(evaluator, list, positions, room);
                for (i, (position, beside)) in positions.iter_mut().zip(&mut *normals).enumerate() {
                    let axis = axis_of(at + i);
                    let span = spans[at + i];
                    let by = correction(span, room[3][i]);
                    position[axis] += voxel * by;
                    // Where the gradient is evaluated, stored as the normal.
                    *beside = *position;
                    beside[axis] += voxel * step_out(span, by);
                }
                at += n;
                if !with_normals {
                    continue;
                }
                look(evaluator, list, normals, room);
                let [_, _, _, _, gx, gy, gz] = &**room;
                for i in 0..n {
                    normals[i] = Vec3::new(gx[i], gy[i], gz[i]).normalize_or_zero();
                }
            }
        },
    );
}

/// Turns normals toward the outer end of their edges. At a crease, the gradient can belong to a hidden surface,
/// which would be lit from inside. Dual contouring uses the gradients unchanged.
///
/// # Panics
/// If `surface` has a vertex outside its ranges.
pub fn orient_normals(surface: &mut MarchedMesh) {
    let MarchedMesh {
        mesh,
        groups,
        edge_distances: spans,
    } = surface;
    for group in groups {
        for at in group.begin..group.ends[2] {
            let axis = group.ends.iter().position(|&end| at < end);
            let axis = axis.expect("a vertex of the group");
            let [a, b] = spans[at as usize];
            if let Some(normal) = mesh.normals.get_mut(at as usize) {
                normal[axis] = normal[axis].abs().copysign(b - a);
            }
        }
    }
}

/// Returns how far a vertex moves, in edges, if its distance is `d` and it was placed between two stored ones.
fn correction([a, b]: [f32; 2], d: f32) -> f32 {
    let t = edge_crossing(a, b, 0.0);
    // The part of the edge on which the sign changes.
    let to = if (d < 0.0) == (a < 0.0) {
        t + (1.0 - t) * d / (d - b)
    } else {
        t * a / (a - d)
    };
    if to.is_finite() { clamp(to) - t } else { 0.0 }
}

/// Returns how far from a moved vertex, in edges, the gradient is evaluated: outside, or inside where the edge
/// ends.
fn step_out([a, b]: [f32; 2], moved: f32) -> f32 {
    let t = edge_crossing(a, b, 0.0) + moved;
    let out = OUT.copysign(b - a);
    if (0.0..=1.0).contains(&(t + out)) {
        out
    } else {
        -out
    }
}

/// Lanes of coordinates, distances and gradients.
type PointBuffers = [[f32; LANES]; 7];

fn fill(positions: &[Vec3], room: &mut PointBuffers) {
    for (i, p) in positions.iter().enumerate() {
        (room[0][i], room[1][i], room[2][i]) = (p.x, p.y, p.z);
    }
}

/// Computes distances only.
fn measure(
    evaluator: &mut Evaluator<'_>,
    list: &[Instruction],
    positions: &[Vec3],
    room: &mut PointBuffers,
) {
    fill(positions, room);
    let n = positions.len();
    let [x, y, z, d, ..] = room;
    evaluator.distances_with(list, &x[..n], &y[..n], &z[..n], &mut d[..n]);
}

/// Computes distances and gradients.
fn look(
    evaluator: &mut Evaluator<'_>,
    list: &[Instruction],
    positions: &[Vec3],
    room: &mut PointBuffers,
) {
    fill(positions, room);
    let n = positions.len();
    let [x, y, z, d, gx, gy, gz] = room;
    let gradients = [&mut gx[..n], &mut gy[..n], &mut gz[..n]];
    evaluator.gradients_with(list, [&x[..n], &y[..n], &z[..n]], &mut d[..n], gradients);
}

/// A range of vertices, and the vertices.
type ProjectionJob<'a, T> = (BrickVertexRange, &'a mut [Vec3], &'a mut [T]);

fn split<'a, T>(
    groups: &[BrickVertexRange],
    mut positions: &'a mut [Vec3],
    mut others: &'a mut [T],
) -> Vec<ProjectionJob<'a, T>> {
    let mut jobs = Vec::with_capacity(groups.len());
    for group in groups {
        let n = (group.ends[2] - group.begin) as usize;
        let (own_positions, rest) = positions.split_at_mut(n);
        positions = rest;
        let (own_others, rest) = others.split_at_mut(n);
        others = rest;
        jobs.push((*group, own_positions, own_others));
    }
    jobs
}

/// Gives the vertices the field's gradient as normals, evaluated next to the surface as in [`project_to_field`].
pub fn normals(program: &Program, cell_programs: &CellPrograms, mesh: &mut Mesh) {
    let positions = &mesh.positions;
    let voxel = cell_programs.layout().voxel_grid().voxel_size;
    mesh.normals = each(
        program,
        cell_programs,
        positions,
        |evaluator, list, positions| {
            let mut room = Box::new([[0.0; LANES]; 7]);
            let unit = |room: &PointBuffers, i: usize| {
                Vec3::from([4, 5, 6].map(|k| room[k][i])).normalize_or_zero()
            };
            look(evaluator, list, positions, &mut room);
            let off = OUT * voxel;
            let beside = |(i, &p): (usize, &Vec3)| p + off * unit(&room, i);
            let beside: Vec<Vec3> = positions.iter().enumerate().map(beside).collect();
            look(evaluator, list, &beside, &mut room);
            (0..positions.len()).map(|i| unit(&room, i)).collect()
        },
    );
}

/// Gives the vertices the field's materials.
pub fn materials(program: &Program, cell_programs: &CellPrograms, mesh: &mut Mesh) {
    let positions = &mesh.positions;
    if let [only] = program.materials() {
        mesh.materials = vec![*only; positions.len()];
        return;
    }
    mesh.materials = each(
        program,
        cell_programs,
        positions,
        |evaluator, list, positions| {
            let n = positions.len();
            let mut lanes = [[0.0; LANES]; 4];
            let [x, y, z, d] = &mut lanes;
            for (i, p) in positions.iter().enumerate() {
                (x[i], y[i], z[i]) = (p.x, p.y, p.z);
            }
            let mut found = vec![GpuMaterial::default(); n];
            evaluator.materials_with(list, [&x[..n], &y[..n], &z[..n]], &mut d[..n], &mut found);
            found
        },
    );
}

/// Returns the signed distances of a mesh's vertices: their errors.
pub fn distances(program: &Program, cell_programs: &CellPrograms, mesh: &Mesh) -> Vec<f32> {
    each(
        program,
        cell_programs,
        &mesh.positions,
        |evaluator, list, positions| {
            let n = positions.len();
            let mut lanes = [[0.0; LANES]; 3];
            let [x, y, z] = &mut lanes;
            for (i, p) in positions.iter().enumerate() {
                (x[i], y[i], z[i]) = (p.x, p.y, p.z);
            }
            let mut d = vec![0.0; n];
            evaluator.distances_with(list, &x[..n], &y[..n], &z[..n], &mut d);
            d
        },
    )
}

/// Evaluates points in batches of one cell with its pruned program.
fn each<T: Copy + Default + Send>(
    program: &Program,
    cell_programs: &CellPrograms,
    points: &[Vec3],
    ask: impl Fn(&mut Evaluator<'_>, &[Instruction], &[Vec3]) -> Vec<T> + Sync,
) -> Vec<T> {
    let layout = cell_programs.layout();
    let cell = |p: Vec3| layout.cell_of(p);
    let mut order: Vec<([i32; 3], u32)> = (0u32..)
        .zip(points)
        .map(|(i, &p)| {
            let cell = cell(p);
            ([cell.z, cell.y, cell.x], i)
        })
        .collect();
    order.par_sort_unstable();
    let runs: Vec<&[([i32; 3], u32)]> = order
        .chunk_by(|a, b| a.0 == b.0)
        .flat_map(|run| run.chunks(LANES))
        .collect();
    let found: Vec<Vec<T>> = runs
        .par_iter()
        .with_min_len(8)
        .map_init(
            || Evaluator::new(program),
            |evaluator, run| {
                let run_points: Vec<Vec3> = run.iter().map(|&(_, i)| points[i as usize]).collect();
                let list = cell_programs.cell_program(cell(run_points[0]));
                ask(
                    evaluator,
                    list.unwrap_or(program.instructions()),
                    &run_points,
                )
            },
        )
        .collect();
    let mut out = vec![T::default(); points.len()];
    for (run, found) in runs.iter().zip(found) {
        for (&(_, i), found) in run.iter().zip(found) {
            out[i as usize] = found;
        }
    }
    out
}
