//! Moves vertices to the exact surface, and gives them normals and materials.

use super::LevelsMesh;
use argil_abi::{GpuMaterial, Instruction};
use argil_field::{Evaluator, LANES, Program};
use argil_volume::Levels;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// Steps toward the surface.
const STEPS: usize = 3;
/// How far a vertex moves in a step at most, in its voxel's edges.
const MAX_STEP: f32 = 0.5;
/// How far outside the surface normals are evaluated, in edges.
const OUT: f32 = 0.05;

/// Moves the vertices of a mesh to where the exact field is 0, and gives them its gradients as normals and its
/// materials. Returns the distances that remain.
pub fn project_levels(program: &Program, levels: &mut Levels, made: &mut LevelsMesh) -> Vec<f32> {
    let lists = levels.page_programs(program, made.cells.iter().copied());
    let mut order: Vec<u32> = (0..made.cells.len() as u32).collect();
    order.par_sort_unstable_by_key(|&i| (made.cells[i as usize] / 8, i));
    let whole = program.instructions();
    let runs: Vec<&[u32]> = order
        .chunk_by(|&a, &b| made.cells[a as usize] / 8 == made.cells[b as usize] / 8)
        .flat_map(|run| run.chunks(LANES))
        .collect();
    let moved: Vec<Vec<MovedVertex>> = runs
        .par_iter()
        .with_min_len(4)
        .map_init(
            || Evaluator::new(program),
            |evaluator, run| {
                let slot = made.cells[run[0] as usize] / 8;
                let list = lists.get(&slot).map_or(whole, |list| &list[..]);
                let vertices = run.iter().map(|&i| {
                    let i = i as usize;
                    (made.mesh.positions[i], made.voxel_sizes[i])
                });
                project(evaluator, list, vertices.collect())
            },
        )
        .collect();
    let count = made.cells.len();
    let mesh = &mut made.mesh;
    mesh.normals = vec![Vec3::ZERO; count];
    mesh.materials = vec![GpuMaterial::default(); count];
    let mut distances = vec![0.0; count];
    for (&i, vertex) in order.iter().zip(moved.iter().flatten()) {
        let i = i as usize;
        mesh.positions[i] = vertex.position;
        mesh.normals[i] = vertex.normal;
        mesh.materials[i] = vertex.material;
        distances[i] = vertex.distance;
    }
    distances
}

struct MovedVertex {
    position: Vec3,
    normal: Vec3,
    material: GpuMaterial,
    distance: f32,
}

/// Lanes of coordinates, distances and gradients.
type PointBuffers = [[f32; LANES]; 7];

fn look(
    evaluator: &mut Evaluator<'_>,
    list: &[Instruction],
    points: impl Iterator<Item = Vec3>,
    room: &mut PointBuffers,
) {
    let mut n = 0;
    for p in points {
        (room[0][n], room[1][n], room[2][n]) = (p.x, p.y, p.z);
        n += 1;
    }
    let [x, y, z, d, gx, gy, gz] = room;
    let gradients = [&mut gx[..n], &mut gy[..n], &mut gz[..n]];
    evaluator.gradients_with(list, [&x[..n], &y[..n], &z[..n]], &mut d[..n], gradients);
}

fn gradient(room: &PointBuffers, i: usize) -> Vec3 {
    Vec3::new(room[4][i], room[5][i], room[6][i])
}

/// Projects some vertices of a page, given with the edges of their voxels.
fn project(
    evaluator: &mut Evaluator<'_>,
    list: &[Instruction],
    mut vertices: Vec<(Vec3, f32)>,
) -> Vec<MovedVertex> {
    let n = vertices.len();
    let mut room = Box::new([[0.0; LANES]; 7]);
    for _ in 0..STEPS {
        look(
            evaluator,
            list,
            vertices.iter().map(|vertex| vertex.0),
            &mut room,
        );
        for (i, (position, voxel)) in vertices.iter_mut().enumerate() {
            let (d, g) = (room[3][i], gradient(&room, i));
            let step = g * (d / g.length_squared().max(1e-4));
            *position -= step.clamp_length_max(MAX_STEP * *voxel);
        }
    }
    look(
        evaluator,
        list,
        vertices.iter().map(|vertex| vertex.0),
        &mut room,
    );
    let distances = room[3];
    let beside: Vec<Vec3> = vertices
        .iter()
        .enumerate()
        .map(|(i, (p, voxel))| *p + OUT * *voxel * gradient(&room, i).normalize_or_zero())
        .collect();
    look(evaluator, list, beside.into_iter(), &mut room);
    let normals: Vec<Vec3> = (0..n)
        .map(|i| gradient(&room, i).normalize_or_zero())
        .collect();
    let materials = materials(evaluator, list, &vertices, 0..n);
    (0..n)
        .map(|i| MovedVertex {
            position: vertices[i].0,
            normal: normals[i],
            material: materials[i],
            distance: distances[i],
        })
        .collect()
}

fn materials(
    evaluator: &mut Evaluator<'_>,
    list: &[Instruction],
    vertices: &[(Vec3, f32)],
    range: Range<usize>,
) -> Vec<GpuMaterial> {
    let n = range.len();
    let mut lanes = [[0.0; LANES]; 4];
    let [x, y, z, d] = &mut lanes;
    for (i, (p, _)) in vertices[range].iter().enumerate() {
        (x[i], y[i], z[i]) = (p.x, p.y, p.z);
    }
    let mut found = vec![GpuMaterial::default(); n];
    evaluator.materials_with(list, [&x[..n], &y[..n], &z[..n]], &mut d[..n], &mut found);
    found
}
