//! Tests that the samples of meshes are distances: near and far from the surface, inside and outside. The truth is the nearest of
//! all triangles, with a sign from all solid angles.

use argil_field::{Grid, Program};
use argil_mesh::marching::dense;
use argil_mesh::{Mesh, MeshFormat, MeshSdf, from_bytes};
use argil_scene::{Brush, Scene, Shape};
use glam::{DVec3, Vec3};
use std::path::Path;

/// Distances from the surface, in samples' spacings.
const NEAR_OFFSETS: [f32; 5] = [0.01, 0.3, 1.0, 3.0, 10.0];

/// Distances from the surface, in sizes of the mesh.
const FAR_OFFSETS: [f32; 3] = [0.5, 1.0, 2.0];

/// Points that are measured for each offset.
const POINTS: usize = 120;

fn cube() -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5;
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: faces
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..Mesh::default()
    }
}

/// Extracts triangles of a field.
fn marched(field: impl Fn(Vec3) -> f32) -> Mesh {
    let n = 25;
    let grid = Grid::spanning(Vec3::splat(-1.3), Vec3::splat(1.3), n);
    let place = |i: u32| {
        let at = Vec3::new((i % n) as f32, (i / n % n) as f32, (i / n / n) as f32);
        grid.min + grid.spacing * at
    };
    let d: Vec<f32> = (0..n.pow(3)).map(|i| field(place(i))).collect();
    dense::march(&d, &grid, 0.0, false)
}

/// Returns an animal: a body, a head, and two long ears, with bumps.
fn animal(p: Vec3) -> f32 {
    let bumps = 0.03 * (9.0 * p.x).sin() * (11.0 * p.y).sin() * (8.0 * p.z).sin();
    let ear = |x: f32| {
        let foot = Vec3::new(x, 0.45, 0.3);
        let along = ((p - foot).dot(Vec3::Y) / 0.55).clamp(0.0, 1.0);
        p.distance(foot + along * 0.55 * Vec3::Y) - 0.11
    };
    let body = p.distance(Vec3::new(0.0, -0.45, 0.0)) - 0.6;
    let head = p.distance(Vec3::new(0.0, 0.3, 0.35)) - 0.35;
    body.min(head).min(ear(0.2)).min(ear(-0.2)) + bumps
}

fn meshes() -> [(&'static str, Mesh); 4] {
    let head = include_bytes!("../../../scenes/suzanne.obj");
    let head = from_bytes(head, MeshFormat::Obj, Path::new("suzanne.obj")).expect("a mesh");
    [
        ("cube", cube()),
        ("sphere", marched(|p| p.length() - 1.0)),
        ("animal", marched(animal)),
        ("head", head.mesh),
    ]
}

/// Computes the distance to the nearest of all triangles, with a sign.
fn exact(mesh: &Mesh, p: Vec3) -> f64 {
    let (mut best, mut turns) = (f64::INFINITY, 0.0);
    for i in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.triangle_vertices(i).map(|c| (c - p).as_dvec3());
        let n = (b - a).cross(c - a);
        let is_within = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(u, v)| (v - u).cross(n).dot(-u) <= 0.0);
        let side = |u: DVec3, v: DVec3| {
            let t = ((-u).dot(v - u) / (v - u).length_squared()).clamp(0.0, 1.0);
            (u + (v - u) * t).length()
        };
        best = best.min(match is_within {
            true => a.dot(n.normalize()).abs(),
            false => side(a, b).min(side(b, c)).min(side(c, a)),
        });
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        turns += 2.0 * a.dot(b.cross(c)).atan2(under);
    }
    if turns > std::f64::consts::TAU {
        -best
    } else {
        best
    }
}

/// Points at about an offset from a mesh, on both sides.
fn points_at(mesh: &Mesh, offset: f32) -> Vec<Vec3> {
    let mut state = 7u32;
    let mut number = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut point = || {
        let triangle = (number() * mesh.triangles.len() as f32) as usize;
        let [a, b, c] = mesh.triangle_vertices(triangle.min(mesh.triangles.len() - 1));
        let (mut s, mut t) = (number(), number());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        let way = Vec3::new(number(), number(), number()) - 0.5;
        a + s * (b - a) + t * (c - a) + offset * way.normalize_or_zero()
    };
    (0..POINTS).map(|_| point()).collect()
}

/// The errors of a sampled mesh at an offset, in samples' spacings, from the smallest.
fn errors(program: &Program, mesh: &Mesh, offset: f32, spacing: f32) -> Vec<f64> {
    let error = |p: Vec3| (f64::from(program.distance(p)) - exact(mesh, p)).abs();
    let points = points_at(mesh, offset);
    let mut errors: Vec<f64> = points.into_iter().map(error).collect();
    errors
        .iter_mut()
        .for_each(|error| *error /= f64::from(spacing));
    errors.sort_by(f64::total_cmp);
    errors
}

/// Samples a mesh. Returns its program and the distance between samples.
fn sampled(mesh: &Mesh, resolution: u32) -> (Program, f32) {
    let solid = MeshSdf::new(mesh).expect("a solid");
    let grid = solid.sample(resolution).expect("samples");
    assert!(grid.lipschitz() < 1.74, "{}", grid.lipschitz());
    let spacing = grid.spacing();
    let mut scene = Scene::new();
    scene
        .push(Brush::new(Shape::sampled("mesh", grid)))
        .expect("a brush");
    (Program::lower(&scene).expect("a program"), spacing)
}

#[test]
fn samples_are_distances_at_all_offsets() {
    for (name, mesh) in meshes() {
        let size = MeshSdf::new(&mesh)
            .expect("a solid")
            .aabb()
            .size()
            .max_element();
        let mut sums = [0.0; 2];
        for (sum, resolution) in sums.iter_mut().zip([32, 64]) {
            let (program, spacing) = sampled(&mesh, resolution);
            for offset in NEAR_OFFSETS {
                let errors = errors(&program, &mesh, offset * spacing, spacing);
                let [middle, most] = [errors[POINTS / 2], errors[POINTS * 9 / 10]];
                assert!(
                    middle < 0.1,
                    "{name} {resolution}, {offset} voxels: {middle}"
                );
                assert!(most < 0.4, "{name} {resolution}, {offset} voxels: {most}");
                *sum += f64::from(spacing) * errors.iter().sum::<f64>();
            }
            // A voxel of a volume around the offset surface.
            for offset in FAR_OFFSETS {
                let voxel = spacing * (1.0 + 2.0 * offset);
                let errors = errors(&program, &mesh, offset * size, voxel);
                let [middle, most] = [errors[POINTS / 2], errors[POINTS * 9 / 10]];
                assert!(
                    middle < 0.1,
                    "{name} {resolution}, {offset} sizes: {middle}"
                );
                assert!(most < 0.4, "{name} {resolution}, {offset} sizes: {most}");
                *sum += f64::from(voxel) * errors.iter().sum::<f64>();
            }
        }
        // The error falls as voxels shrink.
        assert!(sums[1] < 0.7 * sums[0], "{name}: {sums:?}");
    }
}

/// Distances that were wrong: a cube's center, on the diagonal of its corner, in front of a face, and between two spheres.
#[test]
fn known_distances_of_cubes_and_spheres() {
    let (program, spacing) = sampled(&cube(), 64);
    for (p, right) in [
        (Vec3::ZERO, -0.5),
        (Vec3::splat(1.5), 3f32.sqrt()),
        (Vec3::new(0.8, 0.1, 0.2), 0.3),
        (Vec3::new(0.2, 2.4, 0.0), 1.9),
    ] {
        let d = program.distance(p);
        assert!((d - right).abs() < 0.1 * spacing, "{d} and {right} at {p}");
    }
    let bounds = program.aabb();
    assert!((bounds.max - 0.5).abs().max_element() < 1e-5, "{bounds:?}");
    let pair = marched(|p| p.distance(0.5 * Vec3::X).min(p.distance(-0.5 * Vec3::X)) - 0.35);
    let (program, spacing) = sampled(&pair, 64);
    let right = exact(&pair, Vec3::ZERO);
    let d = f64::from(program.distance(Vec3::ZERO));
    assert!(
        (d - right).abs() < 0.1 * f64::from(spacing),
        "{d} and {right}"
    );
}
