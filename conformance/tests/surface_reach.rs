//! How far surfaces reach, against the triangles of marching cubes.

use argil_conformance::all_cases;
use argil_field::{Program, SurfaceReach};
use argil_math::Aabb;
use argil_mesh::marching::bricks::march;
use argil_volume::{BrickLayout, BrickSettings, Bricks, VoxelGrid};
use glam::Vec3;

/// Returns the smallest distance at points that are half a voxel apart, and at least so far in a direction.
fn nearest_in_slab(program: &Program, voxel: f32, direction: Vec3, least: f32) -> f32 {
    let known = program.aabb().grown(voxel);
    let counts = (known.size() / (0.5 * voxel)).ceil().as_uvec3();
    let mut nearest = f32::MAX;
    for z in 0..=counts.z {
        for y in 0..=counts.y {
            for x in 0..=counts.x {
                let point = known.min + 0.5 * voxel * glam::UVec3::new(x, y, z).as_vec3();
                if point.dot(direction) >= least {
                    nearest = nearest.min(program.distance(point).abs());
                }
            }
        }
    }
    nearest
}

/// Along the axes and two other directions, and back, the surface of each case reaches as far as its triangles do, to a voxel and a
/// half, or there is a thin edge that they cut off. The box that is known without a search is much larger for some.
#[test]
fn surfaces_reach_as_far_as_their_triangles() {
    let mut directions = vec![Vec3::X, Vec3::Y, Vec3::Z];
    directions.extend([Vec3::new(0.6, 0.64, 0.48), Vec3::new(-0.36, 0.48, 0.8)]);
    let (mut tested, mut loose) = (0, 0);
    for case in all_cases() {
        let program = Program::lower(&case.scene).expect("a program");
        let known = program.aabb();
        if !known.is_finite() {
            continue;
        }
        let grid = VoxelGrid::fitting(known, None, 96).expect("a grid");
        let layout = BrickLayout::new(grid, &BrickSettings::default()).expect("a layout");
        let (bricks, _) = Bricks::bake(&program, layout, None).expect("bricks");
        let mesh = march(&bricks).mesh;
        let mut reach = SurfaceReach::new(&program, known);
        for &axis in &directions {
            for direction in [axis, -axis] {
                let ends = mesh.positions.iter().map(|p| p.dot(direction));
                let expected = ends.reduce(f32::max);
                let found = reach.along(direction);
                let (Some(expected), Some(found)) = (expected, found) else {
                    assert!(expected.is_none(), "{}: {found:?}", case.name);
                    continue;
                };
                tested += 1;
                let corners = known.corners().into_iter();
                let known = corners.map(|p| p.dot(direction)).fold(f32::MIN, f32::max);
                loose += usize::from(known > expected + 6.0 * grid.voxel_size);
                let off = (found - expected) / grid.voxel_size;
                let place = format!("{}: {direction}: off by {off} voxels", case.name);
                // Parts that stick out by less than a 64th may be missed.
                assert!(off > -1.6, "{place}");
                // Triangles cut thin edges off.
                if off > 1.5 {
                    let voxel = grid.voxel_size;
                    let nearest = nearest_in_slab(&program, voxel, direction, found - 3.0 * voxel);
                    assert!(nearest < grid.voxel_size, "{place}, {nearest} away");
                }
            }
        }
    }
    assert!(tested > 500 && loose > 50, "{tested} {loose}");
}

/// Empty and infinite boxes have no surface.
#[test]
fn boxes_without_a_surface_have_no_reach() {
    let mut scene = argil_scene::Scene::new();
    let empty = Program::lower(&scene).expect("a program");
    assert_eq!(SurfaceReach::new(&empty, empty.aabb()).along(Vec3::X), None);
    scene
        .push(argil_scene::Shape::cuboid([1e6, 1.0, 1e6]))
        .expect("a plane");
    let plane = Program::lower(&scene).expect("a program");
    assert_eq!(SurfaceReach::new(&plane, plane.aabb()).along(Vec3::X), None);
    let within = Aabb::centered(Vec3::ONE);
    let top = SurfaceReach::new(&plane, within).along(Vec3::Y);
    assert!(top.is_some_and(|top| (top - 1.0).abs() < 1e-3), "{top:?}");
    let apart = Aabb::new(Vec3::splat(2.0), Vec3::splat(3.0));
    assert_eq!(SurfaceReach::new(&plane, apart).along(Vec3::Y), None);
}
