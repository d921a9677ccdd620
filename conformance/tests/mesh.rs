//! Triangles drawn on both devices: each other's hits, and the field's.

use argil_abi::{Frame, HIT_INSIDE, HIT_NONE, HIT_OUTSIDE, Hit};
use argil_conformance::{gpu, shipped};
use argil_field::Program;
use argil_gpu::{GpuField, GpuMesh};
use argil_march::{Camera, Settings, Show, Through, Triangles, frames, render_with_hits};
use argil_math::Aabb;
use argil_mesh::{Mesh, exact, marching};
use argil_scene::{Brush, Scene, Shape};
use argil_volume::{BrickLayout, BrickSettings, Bricks, Lattice};
use glam::Vec3;

fn mesh(program: &Program, resolution: u32) -> (Mesh, Lattice) {
    let lattice = Lattice::holding(program.aabb(), None, resolution).expect("a lattice");
    let layout = BrickLayout::new(lattice, &BrickSettings::default()).expect("a layout");
    let (bricks, lists, _) = Bricks::bake_with_lists(program, layout, None).expect("bricks");
    let mut marched = marching::bricks::march(&bricks);
    exact::refine(program, &lists, &mut marched);
    (marched.mesh, lattice)
}

fn look(program: &Program, lattice: &Lattice, eye: Vec3) -> Vec<Frame> {
    let settings = Settings {
        size: [160, 120],
        show: Show::Normal,
        samples: 1,
        ..Settings::default()
    };
    let camera = Camera {
        eye,
        target: Vec3::ZERO,
        field_of_view_degrees: 45.0,
    };
    let focus = Aabb::centered(Vec3::ONE);
    frames(&settings, &camera, program, Some(lattice), focus)
}

fn triangles(mesh: &Mesh) -> Triangles<'_> {
    Triangles {
        positions: &mesh.positions,
        normals: &mesh.normals,
        triangles: &mesh.triangles,
    }
}

/// Pixels in which two pictures differ: in what is hit, in how far it is by more than `tolerance`, or in the normal.
fn differing(a: &[Hit], b: &[Hit], tolerance: f32) -> usize {
    let differ = |(a, b): (&Hit, &Hit)| {
        let turn: f32 = (0..3).map(|k| a.normal_t[k] * b.normal_t[k]).sum();
        a.kind != b.kind
            || (a.kind != HIT_NONE
                && ((a.normal_t[3] - b.normal_t[3]).abs() > tolerance || turn < 0.99))
    };
    a.iter().zip(b).filter(|&pair| differ(pair)).count()
}

#[test]
fn both_devices_draw_the_same_triangles_and_they_are_the_surface() {
    let case = shipped().into_iter().find(|case| case.name == "csg20");
    let program = Program::lower(&case.expect("a scene that ships").scene).expect("a program");
    let (mut mesh, lattice) = mesh(&program, 128);
    let field = GpuField::new(gpu(), &program, false).expect("a field");
    let on_gpu = GpuMesh::upload(&field, triangles(&mesh)).expect("triangles");
    // From outside, from within the box with triangles behind the eye, and from inside the solid.
    let inside = mesh.positions[mesh.triangles[1000][0] as usize]
        - 2.0 * lattice.voxel * mesh.normals[mesh.triangles[1000][0] as usize];
    for eye in [Vec3::new(1.2, 0.8, 2.0), Vec3::new(0.05, 0.02, 0.9), inside] {
        let frames = look(&program, &lattice, eye);
        let own = render_with_hits(&program, Through::Mesh(triangles(&mesh)), &frames);
        let theirs = on_gpu.render(&field, &frames).expect("a picture").0;
        let count = own.hits.iter().filter(|h| h.kind != HIT_NONE).count();
        assert!(count > 2000, "{count} from {eye}");
        // Pixels on the edge between two triangles can be either's.
        let off = differing(&own.hits, &theirs.hits, 1e-3 * lattice.voxel);
        assert!(off * 200 < count, "{off} of {count} from {eye}");

        let field = render_with_hits(&program, Through::Field, &frames);
        let off = differing(&own.hits, &field.hits, lattice.voxel);
        assert!(
            off * 20 < count,
            "{off} of {count} from {eye} against the field"
        );
        if eye == inside {
            let seen = own.hits.iter().filter(|h| h.kind == HIT_INSIDE).count();
            assert!(seen > count / 2, "{seen} of {count}");
        }
    }

    // The comparison can fail: triangles that are moved, or turned over.
    let frames = look(&program, &lattice, Vec3::new(1.2, 0.8, 2.0));
    let right = render_with_hits(&program, Through::Mesh(triangles(&mesh)), &frames);
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let turned = render_with_hits(&program, Through::Mesh(triangles(&mesh)), &frames);
    let outside = |hits: &[Hit]| hits.iter().filter(|h| h.kind == HIT_OUTSIDE).count();
    assert!(outside(&right.hits) > 2000 && outside(&turned.hits) < 20);
    mesh.positions.iter_mut().for_each(|p| p.z += lattice.voxel);
    let moved = render_with_hits(&program, Through::Mesh(triangles(&mesh)), &frames);
    assert!(differing(&right.hits, &moved.hits, 1e-3 * lattice.voxel) > 2000);
}

/// A closed surface has no gaps: wherever the eye is, no ray slips through between neighbours.
#[test]
fn no_ray_slips_through_between_triangles() {
    let mut scene = Scene::new();
    let ball = Brush::new(Shape::sphere(0.7));
    scene.push(ball).expect("a brush");
    let program = Program::lower(&scene).expect("a program");
    let (mesh, lattice) = mesh(&program, 48);
    for k in 0..12 {
        let turn = k as f32 * 0.37;
        // From inside, every ray meets the surface.
        let eye = 0.3 * Vec3::new(turn.cos(), 0.1 * turn, turn.sin());
        let frames = look(&program, &lattice, eye);
        let picture = render_with_hits(&program, Through::Mesh(triangles(&mesh)), &frames);
        let gaps = picture.hits.iter().filter(|h| h.kind != HIT_INSIDE).count();
        assert_eq!(gaps, 0, "from {eye}");
    }
}
