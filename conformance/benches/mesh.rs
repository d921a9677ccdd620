//! Marching cubes of csg20. Each variant is compared with the others of one run.
//!
//! * a dense grid of 256³ samples, with one thread and without normals, and with two and normals;
//! * the scene at 256³ by bricks: bake, march, refine, materials.

use argil_conformance::shipped;
use argil_field::{Grid, Program};
use argil_mesh::{MeshReport, marching, project_to_field};
use argil_volume::{BrickLayout, BrickSettings, Bricks, VoxelGrid};
use glam::Vec3;
use std::time::Instant;

fn median(mut act: impl FnMut()) -> f64 {
    let mut all: Vec<f64> = (0..15)
        .map(|_| {
            let start = Instant::now();
            act();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

fn main() {
    let case = shipped().into_iter().find(|case| case.name == "csg20");
    let scene = case.expect("a scene that ships").scene;
    let program = Program::lower(&scene).expect("a program");

    let grid = Grid::spanning(Vec3::splat(-1.0), Vec3::ONE, 256);
    let mut d = vec![0.0; 256 * 256 * 256];
    program.distances(&grid, &mut d);
    for (threads, normals) in [(1, false), (1, true), (2, false), (2, true)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| {
            let mesh = marching::dense::march(&d, &grid, 0.0, normals);
            let ms = median(|| drop(marching::dense::march(&d, &grid, 0.0, normals)));
            println!(
                "dense 256³, {threads} threads, normals {normals}: {ms:.2} ms, {} triangles, {} vertices",
                mesh.triangles.len(),
                mesh.positions.len()
            );
        });
    }

    let frame = scene.view.bounds;
    let frame = frame.map(|[min, max]| argil_math::Aabb::new(min.into(), max.into()));
    let voxel_grid = VoxelGrid::fitting(program.aabb(), frame, 256).expect("a voxel grid");
    let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
    let all = || {
        let (bricks, lists, _) =
            Bricks::bake_with_programs(&program, layout, None).expect("bricks");
        let mut marched = marching::bricks::march(&bricks);
        project_to_field::project_to_field(&program, &lists, &mut marched, true);
        marched
    };
    let ms = median(|| drop(all()));
    let bake = median(|| drop(Bricks::bake(&program, layout, None)));
    let (bricks, lists, _) = Bricks::bake_with_programs(&program, layout, None).expect("bricks");
    let march = median(|| drop(marching::bricks::march(&bricks)));
    let mut marched = marching::bricks::march(&bricks);
    let off = |mesh: &argil_mesh::Mesh| {
        let sum: f64 = mesh
            .positions
            .iter()
            .map(|&p| f64::from(program.distance(p)).powi(2))
            .sum();
        (sum / mesh.positions.len() as f64).sqrt() / f64::from(voxel_grid.voxel_size)
    };
    let before = off(&marched.mesh);
    let refine =
        median(|| project_to_field::project_to_field(&program, &lists, &mut marched, true));
    let marched = all();
    println!(
        "scene to mesh, 256³: {ms:.2} ms; bake {bake:.2}, march {march:.2}, refine {refine:.2}; off {before:.5} voxels, then {:.5}",
        off(&marched.mesh)
    );
    let start = Instant::now();
    let report = MeshReport::of(&marched.mesh);
    println!(
        "{report:?}, watertight {}, looked at in {:.1?}",
        report.is_watertight(),
        start.elapsed()
    );
    let turned = (0..marched.mesh.triangles.len())
        .filter(|&t| {
            let [a, b, c] = marched.mesh.triangle_vertices(t);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let (_, gradient) = program.gradient((a + b + c) / 3.0);
            normal.dot(gradient) < 0.0
        })
        .count();
    println!("{turned} triangles face inwards");
}
