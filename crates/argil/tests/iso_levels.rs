//! Surfaces at a distance: closed, and at that distance from the solid, for each modifier. The truth is the nearest of many points
//! that lie inside, or outside.

use argil::{DenseOptions, Engine, MeshError, MeshOptions, MeshOutput};
use argil_field::{Grid, Program};
use argil_math::Aabb;
use argil_scene::{Brush, Modifier, Scene, Shape};
use glam::Vec3;

/// Points along the longest side of a box around the solid.
const SIDE: u32 = 56;

fn mesh(scene: &Scene, iso: f32) -> MeshOutput {
    let world = Engine::cpu().build(scene).expect("a world").field();
    let options = MeshOptions {
        resolution: 56,
        iso,
        ..MeshOptions::default()
    };
    world.mesh(&options).expect("a mesh")
}

/// Returns the points of a lattice that are inside, or outside, and the largest distance between neighbors.
fn points(program: &Program, bounds: Aabb, is_inside: bool) -> (Vec<Vec3>, f32) {
    let grid = Grid::spanning(bounds.min, bounds.max, SIDE);
    let mut distances = vec![0.0; SIDE.pow(3) as usize];
    program.distances(&grid, &mut distances);
    let place = |i: u32| {
        let [x, y, z] = [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE];
        grid.min + grid.spacing * Vec3::new(x as f32, y as f32, z as f32)
    };
    let all = (0..).map(place).zip(distances);
    let chosen = all.filter(|(_, d)| (*d < 0.0) == is_inside);
    (chosen.map(|(p, _)| p).collect(), grid.spacing.max_element())
}

/// Returns the largest difference between the distance of a vertex and the level, in steps between points.
fn worst(positions: &[Vec3], points: &[Vec3], level: f32, spacing: f32) -> f32 {
    let stride = positions.len() / 30 + 1;
    let error = |p: &Vec3| {
        let nearest = points.iter().map(|q| p.distance_squared(*q));
        let nearest = nearest.fold(f32::INFINITY, f32::min).sqrt();
        (nearest - level).abs() / spacing
    };
    positions
        .iter()
        .step_by(stride)
        .map(error)
        .fold(0.0, f32::max)
}

/// Returns a box under each modifier of the table, and under some stronger ones.
fn cases() -> Vec<(String, Scene)> {
    let stronger = [
        Modifier::Scale { by: 0.7 },
        Modifier::Stretch {
            by: [2.0, 0.6, 1.0],
        },
        Modifier::ScaleDistance { by: 0.5 },
        Modifier::Displace {
            amplitude: 0.1,
            frequency: 4.0,
            octaves: 2,
            seed: 3,
        },
    ];
    let of_one = |modifier: Modifier| {
        let name = format!("{modifier:?}");
        let mut scene = Scene::new();
        let brush = Brush::new(Shape::cuboid([0.5, 0.3, 0.4])).at([0.2, 0.0, 0.1]);
        let pushed = scene.push(brush.with_modifier(modifier));
        pushed.expect("a brush");
        (name, scene)
    };
    let all = Modifier::examples().into_iter().chain(stronger);
    all.map(of_one).collect()
}

#[test]
fn offsets_of_all_modifiers_are_closed_and_at_their_distance() {
    let mut count = 0;
    for (name, scene) in cases() {
        let program = Program::lower(&scene).expect("a program");
        let output = mesh(&scene, 0.2);
        if output.voxel_grid.is_clipped {
            continue;
        }
        count += 1;
        assert!(output.report.is_watertight(), "{name}: {:?}", output.report);
        let surface = mesh(&scene, 0.0);
        let bounds = Aabb::around(surface.mesh.positions.iter().copied());
        let (inside, spacing) = points(&program, bounds, true);
        let worst_by = worst(&output.mesh.positions, &inside, 0.2, spacing);
        assert!(
            worst_by < 1.8,
            "{name}: a vertex is off by {worst_by} steps"
        );
        let moved = Aabb::around(output.mesh.positions.iter().copied());
        let grown = bounds.grown(0.2);
        let off = (moved.min - grown.min)
            .abs()
            .max((moved.max - grown.max).abs());
        assert!(
            off.max_element() < 2.0 * spacing,
            "{name}: {moved:?} and {grown:?}"
        );
    }
    assert!(count > 15, "{count}");
}

#[test]
fn insets_are_at_their_distance() {
    for (name, scene) in cases() {
        let program = Program::lower(&scene).expect("a program");
        let output = mesh(&scene, -0.05);
        if output.voxel_grid.is_clipped || output.mesh.positions.is_empty() {
            continue;
        }
        let surface = mesh(&scene, 0.0);
        let bounds = Aabb::around(surface.mesh.positions.iter().copied()).grown(0.1);
        let (outside, spacing) = points(&program, bounds, false);
        let worst_by = worst(&output.mesh.positions, &outside, 0.05, spacing);
        assert!(
            worst_by < 1.8,
            "{name}: a vertex is off by {worst_by} steps"
        );
    }
}

/// The level set of a stretched sphere left the box, and that of a displaced one was a ball.
#[test]
fn stretched_and_displaced_spheres() {
    let scene = |modifier: Modifier| {
        let mut scene = Scene::new();
        scene
            .push(Brush::new(Shape::sphere(1.0)).with_modifier(modifier))
            .expect("a brush");
        scene
    };
    let output = mesh(
        &scene(Modifier::Stretch {
            by: [4.0, 1.0, 1.0],
        }),
        0.5,
    );
    assert!(output.report.is_watertight());
    let bounds = Aabb::around(output.mesh.positions.iter().copied());
    let right = Vec3::new(4.5, 1.5, 1.5);
    assert!((bounds.max - right).abs().max_element() < 0.1, "{bounds:?}");
    let displaced = Modifier::Displace {
        amplitude: 0.3,
        frequency: 3.0,
        octaves: 3,
        seed: 1,
    };
    let output = mesh(&scene(displaced), 0.4);
    let radii = output.mesh.positions.iter().map(|p| p.length());
    let (low, high) = radii.fold((f32::MAX, 0.0f32), |(a, b), r| (a.min(r), b.max(r)));
    assert!(high - low > 0.1, "a ball from {low} to {high}");
    assert!(output.report.is_watertight());
}

/// A volume ends two voxels from the solid, so its mesh at a larger level would have holes.
#[test]
fn volumes_refuse_levels_that_leave_their_box() {
    let mut scene = Scene::new();
    scene
        .push(Brush::new(Shape::cuboid([0.5; 3])))
        .expect("a brush");
    let options = DenseOptions {
        resolution: 32,
        ..DenseOptions::default()
    };
    let build = Engine::cpu();
    let build = build.build(&scene).expect("a world");
    let world = build.dense(options).expect("a volume");
    let mesh = |iso: f32| {
        world.mesh(&MeshOptions {
            iso,
            ..MeshOptions::default()
        })
    };
    let voxel = 1.0 / 28.0;
    assert!(mesh(voxel).expect("a mesh").report.is_watertight());
    assert!(matches!(mesh(3.0 * voxel), Err(MeshError::LeavesBox(_))));
}

/// Around a sharp solid with sides a, b and c, the surface at a distance r has the volume abc + 2 (ab + bc + ca) r + π (a + b + c) r²
/// + 4/3 π r³ (Steiner 1840).
#[test]
fn offsets_of_sharp_solids_have_their_volume() {
    let mut scene = Scene::new();
    let stretched = Modifier::Stretch {
        by: [1.5, 0.8, 1.0],
    };
    let brush = Brush::new(Shape::cuboid([0.5, 0.5, 0.5])).with_modifier(stretched);
    scene.push(brush).expect("a brush");
    let [a, b, c] = [1.5f64, 0.8, 1.0];
    for (resolution, most) in [(32, 0.005), (64, 0.0015)] {
        let world = Engine::cpu().build(&scene).expect("a world").field();
        let options = MeshOptions {
            resolution,
            iso: 0.3,
            ..MeshOptions::default()
        };
        let output = world.mesh(&options).expect("a mesh");
        let mesh = &output.mesh;
        let of = |i: usize| {
            let [a, b, c] = mesh.triangle_vertices(i).map(|p| p.as_dvec3());
            a.dot(b.cross(c)) / 6.0
        };
        let volume: f64 = (0..mesh.triangles.len()).map(of).sum();
        let r = f64::from(options.iso);
        let pi = std::f64::consts::PI;
        let exact = a * b * c
            + 2.0 * (a * b + b * c + c * a) * r
            + pi * (a + b + c) * r * r
            + 4.0 / 3.0 * pi * r.powi(3);
        let error = (volume - exact).abs() / exact;
        assert!(error < most, "{resolution}: {volume} and {exact}: {error}");
    }
}
