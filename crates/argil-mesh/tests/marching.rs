//! Tests meshes of fields: they are closed, equal for dense grids and bricks, and on the surface.

use argil_field::{Grid, Program};
use argil_mesh::marching::bricks::{self, MarchedMesh};
use argil_mesh::marching::dense;
use argil_mesh::{Mesh, MeshReport, dual_contouring, project_to_field};
use argil_scene::{Brush, Scene, Shape};
use argil_volume::{BrickLayout, BrickSettings, Bricks, VoxelGrid};
use glam::{UVec3, Vec3};

fn blend() -> Program {
    let mut scene = Scene::new();
    for brush in [
        Brush::new(Shape::rounded_box([0.5, 0.3, 0.4], 0.05)).rotated([0.3, 1.0, 0.2], 25.0),
        Brush::new(Shape::torus(0.5, 0.12))
            .at([0.1, 0.2, 0.0])
            .smooth(0.1),
        Brush::new(Shape::sphere(0.25))
            .at([0.3, 0.2, 0.3])
            .subtract()
            .smooth(0.02),
    ] {
        scene.push(brush).expect("a brush");
    }
    Program::lower(&scene).expect("a program")
}

/// Samples the field at the corners of voxels.
fn corners(program: &Program, voxel_grid: &VoxelGrid) -> (Grid, Vec<f32>) {
    let grid = Grid {
        min: voxel_grid.corner,
        spacing: Vec3::splat(voxel_grid.voxel_size),
        begin: UVec3::ZERO,
        size: voxel_grid.size + 1,
    };
    let mut d = vec![0.0; grid.layer_len() * grid.size.z as usize];
    program.distances(&grid, &mut d);
    (grid, d)
}

fn baked(program: &Program, resolution: u32, brick: u32) -> Bricks {
    let voxel_grid = VoxelGrid::fitting(program.aabb(), None, resolution).expect("a voxel grid");
    let settings = BrickSettings {
        brick_size_voxels: brick,
        ..BrickSettings::default()
    };
    let layout = BrickLayout::new(voxel_grid, &settings).expect("a layout");
    Bricks::bake(program, layout, None).expect("bricks").0
}

/// Returns the positions of the triangles' vertices, in order.
fn places(mesh: &Mesh, voxel: f32) -> Vec<[[i64; 3]; 3]> {
    let mut all: Vec<_> = (0..mesh.triangles.len())
        .map(|i| {
            let mut corners = mesh
                .triangle_vertices(i)
                .map(|p| (p / (0.001 * voxel)).to_array().map(|c| c.round() as i64));
            let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
            corners.rotate_left(first);
            corners
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn bricks_and_a_dense_grid_have_the_same_surface() {
    let program = blend();
    for (resolution, brick) in [(61, 8), (96, 8), (50, 4), (100, 16)] {
        let bricks = baked(&program, resolution, brick);
        let layout = bricks.layout();
        let (grid, mut d) = corners(&program, layout.voxel_grid());
        // Rounded as bricks are: what is within half a step from 0 is 0.
        let step = layout.encoding().band_width(layout.voxel_grid(), 0)
            / layout.encoding().format.max_code() as f32;
        d.iter_mut().for_each(|d| *d = (*d / step).round());
        let whole = dense::march(&d, &grid, 0.0, true);
        let MarchedMesh {
            mesh: sparse,
            groups,
            ..
        } = bricks::march(&bricks);
        let report = MeshReport::of(&whole);
        assert!(report.is_watertight(), "{resolution}: {report:?}");
        assert_eq!(report.degenerate_triangles, 0);
        assert!(
            MeshReport::of(&sparse).is_watertight(),
            "{resolution}: {:?}",
            MeshReport::of(&sparse)
        );
        assert_eq!(sparse.positions.len(), whole.positions.len());
        assert_eq!(sparse.triangles.len(), whole.triangles.len());
        let last = groups.last().expect("bricks");
        assert_eq!(last.ends[2] as usize, sparse.positions.len());
        let (a, b) = (
            places(&whole, bricks.layout().voxel_grid().voxel_size),
            places(&sparse, bricks.layout().voxel_grid().voxel_size),
        );
        let off = a.iter().zip(&b).filter(|(a, b)| a != b).count();
        assert!(off * 1000 < a.len(), "{off} of {}", a.len());
        assert_eq!(
            report.euler_characteristic,
            MeshReport::of(&sparse).euler_characteristic
        );
    }
}

#[test]
fn normals_and_triangles_point_outwards() {
    let program = blend();
    let voxel_grid = VoxelGrid::fitting(program.aabb(), None, 80).expect("a voxel grid");
    let (grid, d) = corners(&program, &voxel_grid);
    let mesh = dense::march(&d, &grid, 0.0, true);
    let report = MeshReport::of(&mesh);
    assert!(report.volume > 0.1, "{report:?}");
    for (&p, &n) in mesh.positions.iter().zip(&mesh.normals) {
        let (d, gradient) = program.gradient(p);
        assert!(d.abs() < 0.3 * voxel_grid.voxel_size, "{d} at {p}");
        assert!(gradient.normalize().dot(n) > 0.6, "{gradient} {n} at {p}");
    }
}

#[test]
fn edges_and_corners_come_out_sharp() {
    let half = Vec3::new(0.5, 0.35, 0.42);
    let (axis, degrees) = ([0.3, 1.0, 0.2], 27.0);
    let mut scene = Scene::new();
    let shape = Shape::cuboid(half.to_array());
    scene
        .push(Brush::new(shape).rotated(axis, degrees))
        .expect("a brush");
    let program = Program::lower(&scene).expect("a program");
    let voxel_grid = VoxelGrid::fitting(program.aabb(), None, 48).expect("a voxel grid");
    let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
    let (bricks, lists, _) = Bricks::bake_with_programs(&program, layout, None).expect("bricks");
    let (mut marched, rings) = bricks::march_with_loops(&bricks);
    project_to_field::project_to_field(&program, &lists, &mut marched, true);
    let dual = dual_contouring::contour(&voxel_grid, &marched, &rings);

    let (soft, sharp) = (MeshReport::of(&marched.mesh), MeshReport::of(&dual));
    assert!(
        sharp.is_watertight() && sharp.euler_characteristic == 2,
        "{sharp:?}"
    );
    let size = f64::from(8.0 * half.element_product());
    let missing = |report: &MeshReport| (1.0 - report.volume / size).abs();
    // Where an edge passes by the grid's own without crossing one, nothing tells of it.
    assert!(missing(&sharp) < 3e-4, "{} of {size}", sharp.volume);
    // Marching cubes cut the edges off.
    assert!(
        missing(&soft) > 4.0 * missing(&sharp),
        "{} of {size}",
        soft.volume
    );
    // Nearly all of the area lies in the sides.
    let back = glam::Quat::from_axis_angle(Vec3::from(axis).normalize(), f32::to_radians(-degrees));
    let beveled = |mesh: &Mesh| {
        let mut area = 0.0;
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.triangle_vertices(t);
            let cross = back * (b - a).cross(c - a);
            if cross.normalize_or_zero().abs().max_element() < 0.999 {
                area += 0.5 * cross.length();
            }
        }
        area
    };
    assert!(
        beveled(&dual) < 0.35 * beveled(&marched.mesh),
        "{} {}",
        beveled(&dual),
        beveled(&marched.mesh)
    );
}

#[test]
fn dual_meshes_of_noise_close() {
    // Balls that overlap at random, a voxel or two large: many cells with more than one sheet.
    let mut scene = Scene::new();
    let mut state = 3u32;
    let mut number = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    for _ in 0..400 {
        let brush = Brush::new(Shape::sphere(0.07 + 0.03 * number()));
        scene
            .push(brush.at([number(), number(), number()]))
            .expect("a brush");
    }
    let program = Program::lower(&scene).expect("a program");
    let voxel_grid = VoxelGrid::fitting(program.aabb(), None, 60).expect("a voxel grid");
    let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
    let (bricks, lists, _) = Bricks::bake_with_programs(&program, layout, None).expect("bricks");
    let (mut marched, rings) = bricks::march_with_loops(&bricks);
    project_to_field::project_to_field(&program, &lists, &mut marched, true);
    let report = MeshReport::of(&dual_contouring::contour(&voxel_grid, &marched, &rings));
    let soft = MeshReport::of(&marched.mesh);
    assert!(
        soft.is_watertight() && report.is_watertight(),
        "{soft:?} {report:?}"
    );
    // Joining a face the other way round cuts a bridge.
    assert!(
        (report.euler_characteristic - soft.euler_characteristic).abs() <= 4,
        "{} {}",
        report.euler_characteristic,
        soft.euler_characteristic
    );
    // Balls of two voxels: what marching cubes cut off counts.
    assert!((1.0..1.25).contains(&(report.volume / soft.volume)));
}

#[test]
fn noise_of_any_kind_gives_a_closed_surface() {
    // Random signs have all 256 cases, with all ambiguous faces.
    let n = 40usize;
    let mut state = 1u32;
    let d: Vec<f32> = (0..n * n * n)
        .map(|i| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let (x, y, z) = (i % n, i / n % n, i / n / n);
            let is_rim = [x, y, z].iter().any(|&c| c == 0 || c == n - 1);
            if is_rim {
                1.0
            } else {
                (state >> 8) as f32 / (1 << 23) as f32 - 1.0
            }
        })
        .collect();
    let grid = Grid::spanning(Vec3::ZERO, Vec3::ONE, n as u32);
    let report = MeshReport::of(&dense::march(&d, &grid, 0.0, false));
    assert!(report.is_watertight(), "{report:?}");
    assert!(report.triangles > 100_000);
}

#[test]
fn rows_of_any_length() {
    for n in [2u32, 3, 63, 64, 65, 128, 129, 130] {
        let size = UVec3::new(n, 5, 6);
        let grid = Grid {
            min: Vec3::ZERO,
            spacing: Vec3::ONE,
            begin: UVec3::ZERO,
            size,
        };
        // A slab whose normal is x: two triangles a square.
        let half = 0.5 * (n - 1) as f32;
        let d: Vec<f32> = (0..n * 30).map(|i| (i % n) as f32 - half + 0.25).collect();
        let mesh = dense::march(&d, &grid, 0.0, true);
        assert_eq!(mesh.positions.len(), 30, "{n}");
        assert_eq!(mesh.triangles.len(), 40, "{n}");
        assert!(
            mesh.positions
                .iter()
                .all(|p| (p.x - half + 0.25).abs() < 1e-4)
        );
        assert!(mesh.normals.iter().all(|&n| n.dot(Vec3::X) > 0.99));
        let out = |t: usize| {
            let [a, b, c] = mesh.triangle_vertices(t);
            (b - a).cross(c - a).x
        };
        assert!((0..40).all(|t| out(t) > 0.0), "{n}");
        let all_in = vec![-1.0; (n * 30) as usize];
        assert_eq!(dense::march(&all_in, &grid, 0.0, true), Mesh::default());
    }
}

/// If the gradient at a crease belongs to the hidden side, the normal is turned outward.
#[test]
fn normals_at_creases_are_turned_outwards() {
    let mut scene = Scene::new();
    let slab = |degrees: f32| {
        let shape = Shape::cuboid([0.8, 0.05, 0.8]);
        Brush::new(shape).rotated([1.0, 0.2, 0.1], degrees)
    };
    scene.push(slab(10.0)).expect("a brush");
    scene.push(slab(24.0)).expect("a brush");
    scene.push(slab(70.0).subtract()).expect("a brush");
    let program = Program::lower(&scene).expect("a program");
    let voxel_grid = VoxelGrid::fitting(program.aabb(), None, 48).expect("a voxel grid");
    let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
    let (bricks, lists, _) = Bricks::bake_with_programs(&program, layout, None).expect("bricks");
    let mut marched = bricks::march(&bricks);
    project_to_field::project_to_field(&program, &lists, &mut marched, true);
    let against = |marched: &bricks::MarchedMesh| {
        let of = |group: &bricks::BrickVertexRange| {
            let ends = group.ends;
            (group.begin..ends[2])
                .filter(|at| {
                    let axis = ends.iter().position(|end| at < end).expect("an axis");
                    let [a, b] = marched.edge_distances[*at as usize];
                    marched.mesh.normals[*at as usize][axis] * (b - a) < 0.0
                })
                .count()
        };
        marched.groups.iter().map(of).sum::<usize>()
    };
    assert!(against(&marched) > 0);
    let lengths = |marched: &bricks::MarchedMesh| -> f32 {
        marched.mesh.normals.iter().map(|n| n.length()).sum()
    };
    let before = lengths(&marched);
    project_to_field::orient_normals(&mut marched);
    assert_eq!((against(&marched), lengths(&marched)), (0, before));
}

/// Cells that share a corner of the solid have separate vertices. No triangle has an area of 0, and the surface is
/// closed.
#[test]
fn dual_meshes_have_no_flat_triangles() {
    for resolution in [20, 32, 33, 48] {
        for blend in [0.0, 0.05] {
            let mut scene = Scene::new();
            for (half, at) in [
                ([0.5, 0.25, 0.5], [0.0; 3]),
                ([0.25, 0.5, 0.25], [0.25, 0.25, 0.0]),
                ([0.125, 0.125, 0.5], [-0.5, 0.25, 0.25]),
            ] {
                let brush = Brush::new(Shape::cuboid(half)).at(at).smooth(blend);
                scene.push(brush).expect("a brush");
            }
            let program = Program::lower(&scene).expect("a program");
            let voxel_grid =
                VoxelGrid::fitting(program.aabb(), None, resolution).expect("a voxel grid");
            let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
            let (bricks, lists, _) =
                Bricks::bake_with_programs(&program, layout, None).expect("bricks");
            let (mut marched, rings) = bricks::march_with_loops(&bricks);
            project_to_field::project_to_field(&program, &lists, &mut marched, true);
            let report = MeshReport::of(&dual_contouring::contour(&voxel_grid, &marched, &rings));
            assert!(report.is_watertight(), "{resolution}: {report:?}");
            assert_eq!(
                report.degenerate_triangles, 0,
                "{resolution}, {blend}: {report:?}"
            );
        }
    }
}
