//! Compares triangles rendered on both devices with each other and with the field.

use argil_abi::{FrameUniform, HIT_INSIDE, HIT_NONE, HIT_OUTSIDE, Hit};
use argil_conformance::Wait;
use argil_conformance::{gpu, shipped};
use argil_field::Program;
use argil_gpu::{GpuMesh, GpuProgram, GpuVolume, ImageOutput, SurfaceOptions};
use argil_math::Aabb;
use argil_mesh::{Mesh, MeshNormals, MeshReport, marching, project_to_field};
use argil_render::{
    Camera, PrunedField, RenderMode, RenderSettings, Triangles, frame_uniforms, render_with_hits,
};
use argil_scene::{Brush, Scene, Shape};
use argil_volume::{BrickLayout, BrickSettings, Bricks, Dense, Encoding, SampleFormat, VoxelGrid};
use glam::Vec3;
use std::collections::BTreeMap;

fn mesh(program: &Program, resolution: u32) -> (Mesh, VoxelGrid) {
    let voxel_grid = VoxelGrid::fitting(program.aabb(), None, resolution).expect("a voxel grid");
    let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
    let (bricks, lists, _) = Bricks::bake_with_programs(program, layout, None).expect("bricks");
    let mut marched = marching::bricks::march(&bricks);
    project_to_field::project_to_field(program, &lists, &mut marched, true);
    project_to_field::orient_normals(&mut marched);
    (marched.mesh, voxel_grid)
}

fn look(program: &Program, voxel_grid: &VoxelGrid, eye: Vec3) -> Vec<FrameUniform> {
    let settings = RenderSettings {
        size: [160, 120],
        mode: RenderMode::Normal,
        samples: 1,
        ..RenderSettings::default()
    };
    let camera = Camera {
        eye,
        target: Vec3::ZERO,
        field_of_view_degrees: 45.0,
    };
    let focus = Aabb::centered(Vec3::ONE);
    frame_uniforms(&settings, &camera, program, Some(voxel_grid), focus)
}

fn triangles(mesh: &Mesh) -> Triangles<'_> {
    Triangles {
        positions: &mesh.positions,
        normals: &mesh.normals,
        triangles: &mesh.triangles,
    }
}

/// Counts pixels that differ between two images: in the hit, in the distance by more than `tolerance`, or in the
/// normal.
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
    let (mut mesh, voxel_grid) = mesh(&program, 128);
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let on_gpu = GpuMesh::upload(&field, triangles(&mesh)).expect("triangles");
    // From outside, from within the box with triangles behind the eye, and from inside the solid.
    let inside = mesh.positions[mesh.triangles[1000][0] as usize]
        - 2.0 * voxel_grid.voxel_size * mesh.normals[mesh.triangles[1000][0] as usize];
    for eye in [Vec3::new(1.2, 0.8, 2.0), Vec3::new(0.05, 0.02, 0.9), inside] {
        let frames = look(&program, &voxel_grid, eye);
        let ours = render_with_hits(&program, &triangles(&mesh), &frames);
        let theirs = on_gpu
            .render(&field, &frames, ImageOutput::CpuWithHits)
            .wait()
            .expect("a picture")
            .0;
        let count = ours.hits.iter().filter(|h| h.kind != HIT_NONE).count();
        assert!(count > 2000, "{count} from {eye}");
        // Pixels on the edge between two triangles can be either's. Hardware puts corners on a grid of 256 steps a pixel.
        let off = differing(&ours.hits, &theirs.hits, 0.02 * voxel_grid.voxel_size);
        assert!(off * 200 < count, "{off} of {count} from {eye}");

        let field = render_with_hits(&program, &PrunedField, &frames);
        let off = differing(&ours.hits, &field.hits, voxel_grid.voxel_size);
        assert!(
            off * 20 < count,
            "{off} of {count} from {eye} against the field"
        );
        if eye == inside {
            let seen = ours.hits.iter().filter(|h| h.kind == HIT_INSIDE).count();
            assert!(seen > count / 2, "{seen} of {count}");
        }
    }

    // The comparison can fail: triangles that are moved, or turned over.
    let frames = look(&program, &voxel_grid, Vec3::new(1.2, 0.8, 2.0));
    let right = render_with_hits(&program, &triangles(&mesh), &frames);
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let turned = render_with_hits(&program, &triangles(&mesh), &frames);
    let outside = |hits: &[Hit]| hits.iter().filter(|h| h.kind == HIT_OUTSIDE).count();
    assert!(outside(&right.hits) > 2000 && outside(&turned.hits) < 20);
    mesh.positions
        .iter_mut()
        .for_each(|p| p.z += voxel_grid.voxel_size);
    let moved = render_with_hits(&program, &triangles(&mesh), &frames);
    assert!(differing(&right.hits, &moved.hits, 1e-3 * voxel_grid.voxel_size) > 2000);
}

/// A closed surface has no gaps: from any camera, no ray passes between neighboring triangles.
#[test]
fn no_ray_slips_through_between_triangles() {
    let mut scene = Scene::new();
    let ball = Brush::new(Shape::sphere(0.7));
    scene.push(ball).expect("a brush");
    let program = Program::lower(&scene).expect("a program");
    let (mesh, voxel_grid) = mesh(&program, 48);
    for k in 0..12 {
        let turn = k as f32 * 0.37;
        // From inside, every ray meets the surface.
        let eye = 0.3 * Vec3::new(turn.cos(), 0.1 * turn, turn.sin());
        let frames = look(&program, &voxel_grid, eye);
        let picture = render_with_hits(&program, &triangles(&mesh), &frames);
        let gaps = picture.hits.iter().filter(|h| h.kind != HIT_INSIDE).count();
        assert_eq!(gaps, 0, "from {eye}");
    }
}

/// Identifies triangles by the edges of their vertices, which rounding does not change. Each coordinate is twice
/// the sample's index, or the odd number between two.
fn by_edges(mesh: &Mesh, first: Vec3, voxel: f32) -> BTreeMap<[[i32; 3]; 3], [Vec3; 3]> {
    let key = |p: Vec3| {
        let at = (p - first) / voxel;
        at.to_array().map(|x| {
            let near = x.round();
            // No vertex is nearer to a sample than 1/256 of its edge.
            if (x - near).abs() < 1e-3 {
                2 * near as i32
            } else {
                2 * x.floor() as i32 + 1
            }
        })
    };
    let of = |i: usize| {
        let corners = mesh.triangle_vertices(i);
        let keys = corners.map(key);
        // The least corner first, in the same sense.
        let turn = (0..3).min_by_key(|&k| keys[k]).unwrap_or(0);
        let turned = |k: usize| (turn + k) % 3;
        let keys = [0, 1, 2].map(|k| keys[turned(k)]);
        (keys, [0, 1, 2].map(|k| corners[turned(k)]))
    };
    let all: BTreeMap<_, _> = (0..mesh.triangles.len()).map(of).collect();
    assert_eq!(
        all.len(),
        mesh.triangles.len(),
        "no triangle is there twice"
    );
    all
}

/// Checks that two meshes have the same triangles, with vertices within `tolerance`.
fn assert_same(ours: &Mesh, theirs: &Mesh, first: Vec3, voxel: f32, tolerance: f32) {
    let (ours, theirs) = (by_edges(ours, first, voxel), by_edges(theirs, first, voxel));
    assert!(ours.keys().eq(theirs.keys()), "other triangles");
    let off = ours
        .values()
        .zip(theirs.values())
        .flat_map(|(a, b)| (0..3).map(move |k| (a[k] - b[k]).length()));
    let off = off.fold(0.0, f32::max);
    assert!(off <= tolerance * voxel, "{} voxels apart", off / voxel);
}

fn csg20() -> Program {
    let case = shipped().into_iter().find(|case| case.name == "csg20");
    Program::lower(&case.expect("a scene that ships").scene).expect("a program")
}

#[test]
fn the_gpu_marches_bricks_as_the_cpu_does() {
    let program = csg20();
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    for (brick, bits) in [
        (4, SampleFormat::Snorm16),
        (8, SampleFormat::Snorm16),
        (8, SampleFormat::Snorm8),
        (16, SampleFormat::Snorm16),
    ] {
        // A frame that cuts the solid, so that there are bricks without neighbors.
        let cut = Aabb::new(Vec3::new(-0.3, -0.4, -0.5), Vec3::new(0.6, 0.5, 0.45));
        for frame in [None, Some(cut)] {
            let voxel_grid = match frame {
                Some(cut) => VoxelGrid {
                    corner: cut.min,
                    voxel_size: 0.9 / 61.0,
                    begin: glam::IVec3::ZERO,
                    size: glam::UVec3::new(61, 61, 64),
                    is_clipped: true,
                },
                None => VoxelGrid::fitting(program.aabb(), None, 61).expect("a voxel grid"),
            };
            let mut settings = BrickSettings {
                brick_size_voxels: brick,
                ..BrickSettings::default()
            };
            settings.encoding.format = bits;
            let layout = BrickLayout::new(voxel_grid, &settings).expect("a layout");
            let bricks = Bricks::bake(&program, layout, None).expect("bricks").0;
            let ours = marching::bricks::march(&bricks).mesh;
            let volume = GpuVolume::upload(&field, &bricks.into())
                .wait()
                .expect("a volume");
            let options = SurfaceOptions {
                normals: MeshNormals::Gradient,
                ..SurfaceOptions::default()
            };
            let (mesh, _) = volume.march(&field, &options).wait().expect("triangles");
            let theirs = mesh.download(field.gpu()).wait().expect("triangles");
            assert!(ours.triangles.len() > 3000, "{}", ours.triangles.len());
            assert_eq!(
                ours.positions.len(),
                theirs.positions.len(),
                "shared as well"
            );
            assert_same(
                &ours,
                &theirs,
                voxel_grid.corner,
                voxel_grid.voxel_size,
                1e-4,
            );
            assert!(facing(&theirs) * 100 > 97 * theirs.triangles.len());
        }
    }
}

/// Counts triangles whose normals point to the correct side.
fn facing(mesh: &Mesh) -> usize {
    let faces = |t: &usize| {
        let [a, b, c] = mesh.triangle_vertices(*t);
        let sum: Vec3 = mesh.triangles[*t]
            .iter()
            .map(|&i| mesh.normals[i as usize])
            .sum();
        (b - a).cross(c - a).dot(sum) > 0.0
    };
    (0..mesh.triangles.len()).filter(faces).count()
}

#[test]
fn the_gpu_marches_dense_volumes_as_the_cpu_does() {
    let program = csg20();
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    for (resolution, bits, iso) in [
        (61, SampleFormat::Snorm16, 0.0),
        (65, SampleFormat::Snorm8, 0.0),
        (61, SampleFormat::Snorm16, 0.02),
    ] {
        let voxel_grid =
            VoxelGrid::fitting(program.aabb(), None, resolution).expect("a voxel grid");
        let encoding = Encoding {
            format: bits,
            ..Encoding::default()
        };
        let dense = Dense::bake(&program, voxel_grid, encoding, false);
        let level = iso / encoding.band_width(&voxel_grid, 0) * encoding.format.max_code() as f32;
        let grid = voxel_grid.grid(0);
        let texels = &dense.levels()[0];
        let ours = match bits {
            SampleFormat::Snorm8 => {
                marching::dense::march(texels.of::<i8>().expect("bytes"), &grid, level, true)
            }
            SampleFormat::Snorm16 => {
                marching::dense::march(texels.of::<i16>().expect("words"), &grid, level, true)
            }
        };
        let volume = GpuVolume::upload(&field, &dense.into())
            .wait()
            .expect("a volume");
        let options = SurfaceOptions {
            iso,
            normals: MeshNormals::Gradient,
            ..SurfaceOptions::default()
        };
        let (mesh, _) = volume.march(&field, &options).wait().expect("triangles");
        let theirs = mesh.download(field.gpu()).wait().expect("triangles");
        assert!(ours.triangles.len() > 3000, "{}", ours.triangles.len());
        assert_eq!(ours.positions.len(), theirs.positions.len());
        assert_same(&ours, &theirs, grid.min, voxel_grid.voxel_size, 1e-4);
        assert!(facing(&theirs) * 100 > 97 * theirs.triangles.len());
        // Triangles with corners of their own are the same ones, with their own normals.
        let unshared = SurfaceOptions {
            is_unindexed: true,
            normals: MeshNormals::Face,
            ..options
        };
        let (mesh, _) = volume.march(&field, &unshared).wait().expect("triangles");
        let spread = mesh.download(field.gpu()).wait().expect("triangles");
        assert_eq!(spread.positions.len(), 3 * theirs.triangles.len());
        assert_same(&ours, &spread, grid.min, voxel_grid.voxel_size, 1e-4);
        assert_eq!(facing(&spread), spread.triangles.len());
        assert!(mesh.memory_bytes() >= 72 * spread.triangles.len() as u64);
    }

    // The comparison can fail: another level.
    let voxel_grid = VoxelGrid::fitting(program.aabb(), None, 61).expect("a voxel grid");
    let dense = Dense::bake(&program, voxel_grid, Encoding::default(), false);
    let volume = GpuVolume::upload(&field, &dense.into())
        .wait()
        .expect("a volume");
    let march = |iso: f32| {
        let options = SurfaceOptions {
            iso,
            ..SurfaceOptions::default()
        };
        let (mesh, _) = volume.march(&field, &options).wait().expect("triangles");
        mesh.download(field.gpu()).wait().expect("triangles")
    };
    let first = voxel_grid.grid(0).min;
    let (one, other) = (
        by_edges(&march(0.0), first, voxel_grid.voxel_size),
        by_edges(&march(0.01), first, voxel_grid.voxel_size),
    );
    assert!(!one.keys().eq(other.keys()));
}

#[test]
fn vertices_that_the_gpu_moves_are_on_the_exact_surface() {
    let program = csg20();
    let (ours, voxel_grid) = mesh(&program, 96);
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
    let (volume, _) = GpuVolume::bricks(&field, &program, layout, None)
        .wait()
        .expect("bricks");
    let rms = |mesh: &Mesh| {
        let squares = mesh
            .positions
            .iter()
            .map(|&p| f64::from(program.distance(p)).powi(2));
        (squares.sum::<f64>() / mesh.positions.len() as f64).sqrt()
            / f64::from(voxel_grid.voxel_size)
    };
    let march = |is_moved: bool| {
        let options = SurfaceOptions {
            project_to_field: is_moved,
            ..SurfaceOptions::default()
        };
        let (mesh, stages) = volume.march(&field, &options).wait().expect("triangles");
        assert!(stages.iter().any(|(stage, _)| *stage == "refine"));
        mesh.download(field.gpu()).wait().expect("triangles")
    };
    let (moved, left) = (march(true), march(false));
    assert!(
        rms(&moved) < 0.005 && rms(&left) > 2.0 * rms(&moved),
        "{} {}",
        rms(&moved),
        rms(&left)
    );
    assert_same(
        &ours,
        &moved,
        voxel_grid.corner,
        voxel_grid.voxel_size,
        0.02,
    );
    assert!(MeshReport::of(&moved).is_watertight());
    let turned = |a: &Vec3| program.gradient(*a).1.normalize_or_zero();
    let off = moved
        .positions
        .iter()
        .zip(&moved.normals)
        .filter(|(p, n)| turned(p).dot(**n) < 0.99);
    // At creases too, hardly any is lit from within.
    for mesh in [&ours, &moved] {
        let away = mesh.triangles.len() - facing(mesh);
        assert!(away * 5000 < mesh.triangles.len(), "{away}");
    }
    // At creases the two sides differ.
    assert!(off.count() * 20 < moved.positions.len());
}
