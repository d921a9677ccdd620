//! Tests volumes in their buffers: the GPU's texels, codes and nodes against the CPU's, stored distances against
//! the field, and rays on both devices.
//!
//! *Length.* A test for each pass of dense volumes and octrees, with the scenes and bounds that they share.

use argil_abi::{FrameUniform, HIT_INSIDE, HIT_NONE, HIT_OUTSIDE, Hit};
use argil_conformance::{
    CaseRng, SceneCase, Wait, all_cases, gpu, primary_ray, random_blends, shipped, stored_integers,
    voxel_grid,
};
use argil_field::Program;
use argil_gpu::{Gpu, GpuProgram, GpuVolume, ImageOutput};
use argil_math::Aabb;
use argil_render::{
    Camera, LookupStart, RenderMode, RenderSettings, frame_uniforms, render_with_hits,
};
use argil_scene::{Brush, Scene, Shape};
use argil_volume::{
    Band, BrickLayout, BrickOrdering, BrickSettings, BrickTest, Bricks, Dense, DenseFill, Encoding,
    Octree, OctreeLayout, OctreeSettings, SampleFormat, Texels, Volume, is_brick,
};
use glam::Vec3;
use std::sync::Arc;

/// Counts texels that differ, and returns the largest difference in steps.
fn gap(a: &Texels, b: &Texels) -> (usize, i32) {
    let (a, b) = (stored_integers(a), stored_integers(b));
    assert_eq!(a.len(), b.len());
    let gaps = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
    gaps.fold((0, 0), |(count, most), gap| {
        (count + usize::from(gap > 0), most.max(gap))
    })
}

fn dense_of(volume: Volume) -> Dense {
    match volume {
        Volume::Dense(dense) => dense,
        _ => panic!("a dense volume was read"),
    }
}

fn octree_of(volume: Volume) -> Octree {
    match volume {
        Volume::Octree(octree) => octree,
        _ => panic!("an octree was read"),
    }
}

/// Steps by which rounding in `f32` can change a stored code: one, or more where the field itself rounds by more
/// than a step (`sin` and `cos`, long sums).
fn steps_of(d: f32, encoding: &Encoding, range: f32) -> i32 {
    let field = 2e-5 * (1.0 + d.abs());
    1 + (field / range * encoding.format.max_code() as f32) as i32
}

/// Bounded: texels of dense volumes.
#[test]
fn gpu_dense_volumes_are_the_cpus() {
    let gpu = gpu();
    let eight = Encoding::default();
    let sixteen = Encoding {
        format: SampleFormat::Snorm16,
        band: Band::Stride(8),
    };
    let mut cases = shipped();
    cases.push(random_blends(1, 25));
    for (i, case) in cases.iter().enumerate() {
        let program = Program::lower(&case.scene).expect("a program");
        let field = GpuProgram::new(gpu.clone(), &program, false).expect("a field");
        for (encoding, mips, way) in [
            (eight, true, DenseFill::Tiled),
            (sixteen, true, DenseFill::Tiled),
            (sixteen, false, DenseFill::Naive),
        ] {
            if encoding == sixteen && way == DenseFill::Tiled && i % 4 != 0 {
                continue;
            }
            // A software device takes its time for a group of one thread.
            let is_naive = way == DenseFill::Naive;
            let resolution = if is_naive {
                12 + i as u32
            } else {
                33 + i as u32
            };
            let voxel_grid = self::voxel_grid(&case.scene, &program, resolution);
            let cpu = Dense::bake(&program, voxel_grid, encoding, mips);
            let (volume, stages) =
                GpuVolume::dense(&field, &program, voxel_grid, encoding, mips, way)
                    .wait()
                    .expect("a volume");
            assert!(!stages.is_empty() && stages.iter().all(|(_, ms)| *ms > 0.0));
            let found = dense_of(volume.download(&gpu).wait().expect("a volume"));
            assert_eq!(cpu.levels().len(), found.levels().len());
            for (level, (a, b)) in cpu.levels().iter().zip(found.levels()).enumerate() {
                let range = encoding.band_width(&voxel_grid, level as u32);
                let allowed = steps_of(range, &encoding, range);
                let (count, most) = gap(a, b);
                assert!(
                    most <= allowed && count <= a.bytes().len() / 50 + 2,
                    "{}, level {level}: {count} texels differ, by up to {most}",
                    case.name
                );
            }
            // Negative control: a voxel grid moved by a twentieth of a voxel is told apart.
            let mut moved = voxel_grid;
            moved.corner += 0.05 * voxel_grid.voxel_size;
            let moved = Dense::bake(&program, moved, encoding, mips);
            let (count, _) = gap(&cpu.levels()[0], &moved.levels()[0]);
            assert!(
                count > cpu.levels()[0].bytes().len() / 50 + 2,
                "{}",
                case.name
            );
        }
    }
}

/// Exact: pruning changes no texel, on any level, in any case.
#[test]
fn pruned_bakes_are_whole_bakes() {
    let mut cases = all_cases();
    cases.extend(shipped());
    cases.extend((60..72).map(|seed| random_blends(seed, 40)));
    for (i, case) in cases.iter().enumerate() {
        let program = Program::lower(&case.scene).expect("a program");
        let voxel_grid = voxel_grid(&case.scene, &program, 30 + i as u32 % 40);
        let encoding = Encoding {
            format: if i % 2 == 0 {
                SampleFormat::Snorm8
            } else {
                SampleFormat::Snorm16
            },
            ..Encoding::default()
        };
        let whole = Dense::bake_unpruned(&program, voxel_grid, encoding, true);
        let pruned = Dense::bake(&program, voxel_grid, encoding, true);
        assert!(whole == pruned, "{}", case.name);
    }
}

fn sixteen_bits(settings: OctreeSettings) -> OctreeSettings {
    OctreeSettings {
        encoding: Encoding {
            format: SampleFormat::Snorm16,
            ..settings.encoding
        },
        ..settings
    }
}

fn settings(brick: u32, depth: Option<u32>, keep: BrickTest) -> OctreeSettings {
    OctreeSettings {
        brick_size_voxels: brick,
        depth,
        brick_test: keep,
        ..OctreeSettings::default()
    }
}

/// Exact codes, nodes and levels; bounded texels.
#[test]
fn gpu_octrees_are_the_cpus() {
    let gpu = gpu();
    let mut cases = shipped();
    cases.extend((2..6).map(|seed| random_blends(seed, 20)));
    cases.push(SceneCase {
        name: "nothing".into(),
        scene: Scene::new(),
    });
    let counted = settings(8, None, BrickTest::Conservative);
    let enumerated = settings(16, None, BrickTest::Conservative);
    let shapes = [
        (50, counted, BrickOrdering::PrefixSum),
        (53, sixteen_bits(enumerated), BrickOrdering::EnumerationSort),
        (
            40,
            settings(8, Some(4), BrickTest::CenterInBand),
            BrickOrdering::EnumerationSort,
        ),
        (
            72,
            settings(32, Some(3), BrickTest::CenterInBand),
            BrickOrdering::PrefixSum,
        ),
    ];
    for (i, case) in cases.iter().enumerate() {
        let program = Program::lower(&case.scene).expect("a program");
        let field = GpuProgram::new(gpu.clone(), &program, false).expect("a field");
        // Two of the shapes each, so that every scene and every shape has its turn.
        for (resolution, settings, order) in [shapes[i % 4], shapes[(i + 1) % 4]] {
            let voxel_grid = voxel_grid(&case.scene, &program, resolution);
            let layout = OctreeLayout::new(voxel_grid, &settings).expect("a layout");
            let (cpu, _) = Octree::bake(&program, layout, settings.brick_test);
            let (volume, stages) =
                GpuVolume::octree(&field, &program, layout, settings.brick_test, order)
                    .wait()
                    .expect("an octree");
            assert_eq!(stages.len(), 5);
            let info = volume.info(&gpu).wait().expect("a tree");
            let size = info.octree.map(|tree| (tree.bricks, tree.nodes));
            let found = octree_of(volume.download(&gpu).wait().expect("an octree"));
            assert_eq!(cpu.tree().codes(), found.tree().codes(), "{}", case.name);
            assert_eq!(cpu.tree(), found.tree(), "{}", case.name);
            let sizes = (found.tree().codes().len(), found.tree().nodes().len());
            assert_eq!(size, Some((sizes.0 as u64, sizes.1 as u64)));
            let range = layout.encoding.band_width(&voxel_grid, 0);
            let allowed = steps_of(range, &layout.encoding, range);
            let (count, most) = gap(cpu.texels(), found.texels());
            assert!(
                most <= allowed && count <= cpu.texels().bytes().len() / 50,
                "{}: {count} texels differ, by up to {most}",
                case.name
            );
            if case.name != "nothing" && cpu.tree().codes().len() > 1 {
                // Negative control: one brick less is another tree.
                let mut fewer = cpu.tree().codes().to_vec();
                fewer.remove(fewer.len() / 2);
                assert_ne!(
                    &argil_volume::OctreeNodes::from_codes(fewer, layout.depth),
                    found.tree()
                );
            }
        }
    }
}

/// A tree with thousands of bricks: many times the size of a workgroup, with levels that are larger than one.
#[test]
fn large_octrees_go_past_one_workgroup() {
    let gpu = gpu();
    let mut scene = Scene::new();
    scene
        .push(Brush::new(Shape::sphere(0.9)))
        .expect("a valid brush");
    let program = Program::lower(&scene).expect("a program");
    let voxel_grid = voxel_grid(&scene, &program, 200);
    let layout = OctreeLayout::new(voxel_grid, &settings(8, None, BrickTest::Conservative))
        .expect("a layout");
    let field = GpuProgram::new(gpu.clone(), &program, false).expect("a field");
    let (cpu, _) = Octree::bake(&program, layout, BrickTest::Conservative);
    assert!(
        cpu.tree().codes().len() > 2000,
        "{}",
        cpu.tree().codes().len()
    );
    for order in [BrickOrdering::PrefixSum, BrickOrdering::EnumerationSort] {
        let (volume, _) =
            GpuVolume::octree(&field, &program, layout, BrickTest::Conservative, order)
                .wait()
                .expect("an octree");
        let found = octree_of(volume.download(&gpu).wait().expect("an octree"));
        assert_eq!(cpu.tree(), found.tree());
    }
}

/// The limits of WebGPU suffice: a workgroup of 256 threads fills tiles of 32 by columns, with few bindings.
#[test]
fn the_limits_that_every_device_has_are_enough() {
    let gpu = Arc::new(Gpu::open_portable().wait().expect("a device"));
    let case = random_blends(13, 20);
    let program = Program::lower(&case.scene).expect("a program");
    let field = GpuProgram::new(gpu.clone(), &program, false).expect("a field");
    let voxel_grid = voxel_grid(&case.scene, &program, 70);
    let encoding = Encoding::default();
    let range = encoding.band_width(&voxel_grid, 0);
    let allowed = steps_of(range, &encoding, range);
    let cpu = Dense::bake(&program, voxel_grid, encoding, true);
    let (volume, _) = GpuVolume::dense(
        &field,
        &program,
        voxel_grid,
        encoding,
        true,
        DenseFill::Tiled,
    )
    .wait()
    .expect("a volume");
    let found = dense_of(volume.download(&gpu).wait().expect("a volume"));
    for (a, b) in cpu.levels().iter().zip(found.levels()) {
        assert!(gap(a, b).1 <= allowed);
    }
    let layout = OctreeLayout::new(voxel_grid, &settings(32, None, BrickTest::Conservative))
        .expect("a layout");
    let (cpu, _) = Octree::bake(&program, layout, BrickTest::Conservative);
    for order in [BrickOrdering::PrefixSum, BrickOrdering::EnumerationSort] {
        let (volume, _) =
            GpuVolume::octree(&field, &program, layout, BrickTest::Conservative, order)
                .wait()
                .expect("an octree");
        let found = octree_of(volume.download(&gpu).wait().expect("an octree"));
        assert_eq!(cpu.tree(), found.tree());
        assert!(gap(cpu.texels(), found.texels()).1 <= allowed);
        let frames = frame(
            &program,
            &cpu.clone().into(),
            Vec3::new(1.6, 1.2, 2.2),
            RenderMode::Shaded,
        );
        let (picture, _) = volume
            .render(&field, &frames, ImageOutput::CpuWithHits)
            .wait()
            .expect("a picture");
        assert!(picture.hits.iter().filter(|h| h.kind != HIT_NONE).count() > 300);
    }
}

/// Devices that cannot write 16-bit textures store half floats. Bricks equal the CPU's within rounding, and render
/// equally, built there or uploaded.
#[test]
fn bricks_on_the_least_device_are_the_same_but_for_rounding() {
    let gpu = Arc::new(Gpu::open_portable().wait().expect("a device"));
    let case = random_blends(29, 20);
    let program = Program::lower(&case.scene).expect("a program");
    let field = GpuProgram::new(gpu.clone(), &program, false).expect("a field");
    let voxel_grid = voxel_grid(&case.scene, &program, 70);
    let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
    let (cpu, _) = Bricks::bake(&program, layout, None).expect("bricks");
    let (built, _) = GpuVolume::bricks(&field, &program, layout, None)
        .wait()
        .expect("bricks");
    let cpu: Volume = cpu.into();
    let brought = GpuVolume::upload(&field, &cpu).wait().expect("bricks");
    let Volume::Bricks(bricks) = &cpu else {
        panic!("bricks");
    };
    let samples = |bricks: &Bricks, word: u32| -> Vec<f32> {
        let all: &[i16] = bricks.pool().of().expect("16 bits");
        let each = layout.brick_samples() as usize;
        let stored = &all[word as usize * each..][..each];
        stored.iter().map(|&s| f32::from(s)).collect()
    };
    for volume in [&built, &brought] {
        let Volume::Bricks(found) = volume.download(&gpu).wait().expect("bricks") else {
            panic!("bricks");
        };
        assert_eq!(found.len(), bricks.len());
        let mut most = 0.0f32;
        // Bricks lie in the pool in any order.
        for (&a, &b) in bricks.words().iter().zip(found.words()) {
            assert_eq!(is_brick(a), is_brick(b));
            if !is_brick(a) {
                continue;
            }
            for (a, b) in samples(bricks, a).into_iter().zip(samples(&found, b)) {
                // A step of 11 bits, as a device may round to either side, and what its arithmetic makes.
                most = most.max((a - b).abs() / (1.5 + a.abs() / 1024.0));
            }
        }
        assert!(most <= 1.0, "{most}");
        assert!(most > 0.0, "half floats do not hold 16 bits");
    }
    let frames = frame(&program, &cpu, Vec3::new(1.6, 1.2, 2.2), RenderMode::Normal);
    let [a, b] = [&built, &brought].map(|v| {
        v.render(&field, &frames, ImageOutput::CpuWithHits)
            .wait()
            .expect("a picture")
            .0
    });
    assert!(a.hits.iter().filter(|h| h.kind != HIT_NONE).count() > 300);
    let unlike = a
        .rgb
        .iter()
        .zip(&b.rgb)
        .filter(|(a, b)| a.abs_diff(**b) > 3);
    assert!(unlike.count() <= a.rgb.len() / 200);
}

/// Conservative: no coarse level exceeds the distance, and the finest exceeds it at most by interpolation.
#[test]
fn no_level_overstates_the_distance() {
    let mut numbers = CaseRng::new(41);
    let mut over = 0;
    let mut cases = all_cases();
    cases.extend(shipped());
    cases.extend((7..10).map(|seed| random_blends(seed, 20)));
    for case in &cases {
        let program = Program::lower(&case.scene).expect("a program");
        let voxel_grid = voxel_grid(&case.scene, &program, 48);
        let encoding = Encoding::default();
        let dense = Dense::bake(&program, voxel_grid, encoding, true);
        let held = voxel_grid.aabb();
        let slack = program.bound_error(held);
        let between = 0.5 * 3f32.sqrt() * voxel_grid.voxel_size * program.lipschitz();
        let step = encoding.band_width(&voxel_grid, 0) / encoding.format.max_code() as f32;
        for _ in 0..300 {
            let share = Vec3::new(numbers.unit(), numbers.unit(), numbers.unit());
            let p = held.min + held.size() * share;
            let d = program.distance(p).abs();
            for level in 0..dense.levels().len() as u32 {
                let stored = dense.distance(level, p).expect("a level");
                let stored = if level == 0 { stored.abs() } else { stored };
                let allowed = if level == 0 {
                    between + 0.5 * step + slack
                } else {
                    1e-6
                };
                assert!(
                    stored <= d + allowed,
                    "{}, level {level} at {p}: {stored} of {d}",
                    case.name
                );
                // Negative control: without what is taken off, levels do overstate.
                let bias = encoding
                    .fill_uniform(&program, &voxel_grid, level)
                    .first_bias[3];
                over += usize::from(level > 0 && stored + bias > d + 2e-3);
            }
        }
    }
    assert!(over > 1000, "{over}");
}

const FOCUS: Aabb = Aabb::new(Vec3::splat(-1.0), Vec3::ONE);

fn frame(program: &Program, volume: &Volume, eye: Vec3, show: RenderMode) -> Vec<FrameUniform> {
    let camera = Camera {
        eye,
        target: Vec3::new(0.02, 0.01, 0.0),
        field_of_view_degrees: 45.0,
    };
    let settings = RenderSettings {
        size: [96, 72],
        mode: show,
        max_steps: 4096,
        ..RenderSettings::default()
    };
    frame_uniforms(
        &settings,
        &camera,
        program,
        Some(volume.voxel_grid()),
        FOCUS,
    )
}

/// Counts hits that differ in kind, id or steps, and returns the differences of length and normal that all but one in
/// 500 of the others stay below.
fn hit_gap(a: &[Hit], b: &[Hit]) -> (usize, f32, f32) {
    let mut other = 0;
    let (mut lengths, mut normals) = (Vec::new(), Vec::new());
    for (a, b) in a.iter().zip(b) {
        let far = |x: u32, y: u32| x.abs_diff(y) > 4 + x / 20;
        if a.kind != b.kind
            || a.id != b.id
            || a.cells.abs_diff(b.cells) > 1
            || a.descents.abs_diff(b.descents) > 4
            || far(a.steps, b.steps)
        {
            other += 1;
        } else if a.kind != HIT_NONE {
            lengths.push((a.normal_t[3] - b.normal_t[3]).abs());
            let turns = a.normal_t.iter().zip(&b.normal_t).take(3);
            normals.push(turns.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max));
        }
    }
    let usual = |mut gaps: Vec<f32>| {
        gaps.sort_by(f32::total_cmp);
        let rest = gaps.len() / 500;
        gaps.iter().rev().nth(rest).copied().unwrap_or(0.0)
    };
    (other, usual(lengths), usual(normals))
}

/// Bounded: a texture filter may round its weights to eight bits. That moves a hit by a small part of a voxel, and
/// rotates a normal by a degree or two. At grazing rays the hit may differ.
#[test]
#[expect(
    clippy::too_many_lines,
    reason = "one comparison, and what tells its bounds"
)]
fn rays_through_volumes_are_the_same_on_both_devices() {
    let gpu = gpu();
    let case = random_blends(11, 18);
    let program = Program::lower(&case.scene).expect("a program");
    let field = GpuProgram::new(gpu.clone(), &program, false).expect("a field");
    let voxel_grid = voxel_grid(&case.scene, &program, 96);
    let sixteen = Encoding {
        format: SampleFormat::Snorm16,
        ..Encoding::default()
    };
    let layout = |brick| {
        OctreeLayout::new(voxel_grid, &settings(brick, None, BrickTest::Conservative))
            .expect("a layout")
    };
    let bricks = |brick, bits| {
        let settings = BrickSettings {
            brick_size_voxels: brick,
            encoding: Encoding {
                format: bits,
                ..Encoding::default()
            },
        };
        let layout = BrickLayout::new(voxel_grid, &settings).expect("a layout");
        Bricks::bake(&program, layout, None).expect("bricks").0
    };
    let octree = |brick| Octree::bake(&program, layout(brick), BrickTest::Conservative).0;
    let volumes: [(&str, Volume, LookupStart); 7] = [
        (
            "dense",
            Dense::bake(&program, voxel_grid, Encoding::default(), false).into(),
            LookupStart::Root,
        ),
        (
            "mips",
            Dense::bake(&program, voxel_grid, Encoding::default(), true).into(),
            LookupStart::Root,
        ),
        (
            "16 bits",
            Dense::bake(&program, voxel_grid, sixteen, true).into(),
            LookupStart::Root,
        ),
        ("octree", octree(8).into(), LookupStart::Root),
        ("octree by path", octree(16).into(), LookupStart::Path),
        (
            "bricks",
            bricks(8, SampleFormat::Snorm16).into(),
            LookupStart::Root,
        ),
        (
            "small bricks of 8 bits",
            bricks(4, SampleFormat::Snorm8).into(),
            LookupStart::Root,
        ),
    ];
    for (name, volume, descent) in &volumes {
        let on_gpu = GpuVolume::upload(&field, volume).wait().expect("a volume");
        assert!(
            on_gpu.download(&gpu).wait().expect("a volume") == *volume,
            "{name}"
        );
        let mut views = vec![
            (Vec3::new(1.6, 1.2, 2.2), RenderMode::Normal),
            (Vec3::new(-2.2, 0.3, 1.0), RenderMode::Shaded),
            (Vec3::new(0.05, -0.1, 0.02), RenderMode::Heat),
        ];
        if matches!(volume, Volume::Bricks(_)) {
            views.push((Vec3::new(1.5, 0.9, 1.5), RenderMode::Bricks));
        }
        if matches!(volume, Volume::Octree(_)) {
            views.push((Vec3::new(1.5, 0.9, 1.5), RenderMode::Bricks));
            views.push((Vec3::new(1.5, 0.9, -1.5), RenderMode::Nodes));
        }
        for (eye, show) in views {
            let mut frames = frame(&program, volume, eye, show);
            frames[0].descent = u32::from(*descent == LookupStart::Path);
            let cpu = render_with_hits(&program, volume, &frames);
            let (found, _) = on_gpu
                .render(&field, &frames, ImageOutput::CpuWithHits)
                .wait()
                .expect("a picture");
            let (other, length, normal) = hit_gap(&cpu.hits, &found.hits);
            assert!(
                other <= cpu.hits.len() / 100,
                "{name}, {show:?}: {other} hits are of another kind"
            );
            assert!(
                length < 0.1 * voxel_grid.voxel_size && normal < 0.1,
                "{name}, {show:?}: lengths {length}, normals {normal} apart"
            );
            let differing = cpu.rgb.iter().zip(&found.rgb);
            let differing = differing.filter(|(a, b)| a.abs_diff(**b) > 6).count();
            assert!(
                differing <= cpu.rgb.len() / 60,
                "{name}, {show:?}: {differing} channels differ"
            );
            let hit = cpu.hits.iter().filter(|h| h.kind != HIT_NONE).count();
            assert!(hit > 300, "{name}, {show:?}: {hit}");

            // Negative control: a camera moved by a quarter of a voxel.
            let moved = eye + Vec3::splat(0.25 * voxel_grid.voxel_size);
            let moved = render_with_hits(&program, volume, &frame(&program, volume, moved, show));
            let (other, length, _) = hit_gap(&cpu.hits, &moved.hits);
            assert!(
                other > cpu.hits.len() / 100 || length >= 0.1 * voxel_grid.voxel_size,
                "{name}, {show:?}"
            );
        }
    }
}

/// The start of look-ups changes only the number of visited nodes.
#[test]
fn a_remembered_path_saves_descents_and_nothing_else() {
    let case = random_blends(12, 18);
    let program = Program::lower(&case.scene).expect("a program");
    let voxel_grid = voxel_grid(&case.scene, &program, 128);
    let layout = OctreeLayout::new(voxel_grid, &settings(8, None, BrickTest::Conservative))
        .expect("a layout");
    let (octree, _) = Octree::bake(&program, layout, BrickTest::Conservative);
    let frames = frame(
        &program,
        &octree.clone().into(),
        Vec3::new(1.6, 1.2, 2.2),
        RenderMode::Normal,
    );
    let root = render_with_hits(&program, &octree, &frames);
    let by_path: Vec<FrameUniform> = frames
        .iter()
        .map(|frame| FrameUniform {
            descent: argil_abi::DESCENT_PATH,
            ..*frame
        })
        .collect();
    let path = render_with_hits(&program, &octree, &by_path);
    let descents = |hits: &[Hit]| hits.iter().map(|h| u64::from(h.descents)).sum::<u64>();
    assert!(descents(&path.hits) < descents(&root.hits) * 3 / 4);
    for (a, b) in root.hits.iter().zip(&path.hits) {
        assert_eq!(
            (a.kind, a.normal_t, a.cells, a.steps - a.descents),
            (b.kind, b.normal_t, b.cells, b.steps - b.descents)
        );
    }
}

/// The study's figure 19: with bricks only in the eight central cells, rays show a brick if they cross the box of
/// those cells, and hit it at the correct place.
#[test]
fn rays_meet_the_eight_middle_bricks_where_they_are() {
    let mut scene = Scene::new();
    scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    scene
        .push(Brush::new(Shape::sphere(0.05)))
        .expect("a valid brush");
    let program = Program::lower(&scene).expect("a program");
    let voxel_grid = voxel_grid(&scene, &program, 256);
    // The study's test keeps a brick whose center is within the range, here 0.25.
    let mut settings = settings(32, None, BrickTest::CenterInBand);
    settings.encoding.band = Band::Voxels(0.25 * 128.0);
    let layout = OctreeLayout::new(voxel_grid, &settings).expect("a layout");
    let (octree, _) = Octree::bake(&program, layout, settings.brick_test);
    assert_eq!(octree.tree().codes().len(), 8);
    assert_eq!(octree.tree().nodes().len(), 8 + 8 + 1);
    let volume: Volume = octree.clone().into();
    let frames = frame(
        &program,
        &volume,
        Vec3::new(2.0, 1.4, 2.3),
        RenderMode::Bricks,
    );
    let hits = render_with_hits(&program, &octree, &frames).hits;
    let middle = Aabb::centered(Vec3::splat(0.25));
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let on_gpu = GpuVolume::upload(&field, &volume).wait().expect("a volume");
    let (found, _) = on_gpu
        .render(&field, &frames, ImageOutput::CpuWithHits)
        .wait()
        .expect("a picture");
    let mut met = 0;
    for (i, (hit, other)) in hits.iter().zip(&found.hits).enumerate() {
        let span = primary_ray(&frames[0], i as u32 % 96, i as u32 / 96).span(middle);
        // A ray along an edge may be given to either side.
        let is_clear = span.is_none_or(|(near, far)| far - near > 1e-3);
        if is_clear {
            assert_eq!(hit.id != 0, span.is_some());
            assert_eq!((hit.id, hit.kind), (other.id, other.kind));
        }
        if let (true, Some((near, _))) = (is_clear, span) {
            met += 1;
            assert!((hit.normal_t[3] - near).abs() < 1e-4);
        }
    }
    assert!(met > 200 && met < hits.len() / 2, "{met}");
}

/// A camera inside a solid sees its wall from inside. A camera outside sees a cut face where the volume ends inside
/// a solid.
#[test]
fn rays_that_start_inside_and_solids_that_are_cut() {
    let mut scene = Scene::new();
    scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    scene
        .push(Brush::new(Shape::sphere(0.7)))
        .expect("a valid brush");
    let mut floor = Scene::new();
    floor.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    floor
        .push(Brush::new(Shape::Plane {
            normal: [0.0, 1.0, 0.0],
            offset: 0.0,
        }))
        .expect("a valid brush");
    let gpu = gpu();
    for (scene, eye, kind) in [
        (&scene, Vec3::new(0.1, 0.0, 0.2), HIT_INSIDE),
        (&floor, Vec3::new(0.0, -0.5, 3.0), HIT_OUTSIDE),
    ] {
        let program = Program::lower(scene).expect("a program");
        let voxel_grid = voxel_grid(scene, &program, 64);
        let layout = OctreeLayout::new(voxel_grid, &settings(8, None, BrickTest::Conservative))
            .expect("a layout");
        let field = GpuProgram::new(gpu.clone(), &program, false).expect("a field");
        let dense = Dense::bake(&program, voxel_grid, Encoding::default(), true);
        let octree = Octree::bake(&program, layout, BrickTest::Conservative).0;
        let mut shown: Vec<Vec<Hit>> = Vec::new();
        for volume in [Volume::Dense(dense), Volume::Octree(octree)] {
            let frames = frame(&program, &volume, eye, RenderMode::Normal);
            let on_gpu = GpuVolume::upload(&field, &volume).wait().expect("a volume");
            let (found, _) = on_gpu
                .render(&field, &frames, ImageOutput::CpuWithHits)
                .wait()
                .expect("a picture");
            for hits in [
                render_with_hits(&program, &volume, &frames).hits,
                found.hits,
            ] {
                let middle = &hits[30 * 96 + 48 - 20..30 * 96 + 48 + 20];
                let low = &hits[40 * 96 + 48 - 20..40 * 96 + 48 + 20];
                let seen = if kind == HIT_INSIDE { middle } else { low };
                for hit in seen {
                    assert_eq!(hit.kind, kind);
                    let t = hit.normal_t[3];
                    if kind == HIT_INSIDE {
                        assert!((0.4..0.95).contains(&t), "{t}");
                    } else {
                        // The volume's side is at z = 1, two away.
                        assert!((1.99..2.3).contains(&t), "{t}");
                    }
                }
                shown.push(hits);
            }
        }
        // A whole picture of an octree is that of a dense volume, cut sides and all.
        for hits in &shown[1..] {
            let other = hits.iter().zip(&shown[0]);
            let other = other.filter(|(a, b)| {
                a.kind != b.kind || (a.normal_t[3] - b.normal_t[3]).abs() > voxel_grid.voxel_size
            });
            assert!(other.count() <= 4);
        }
        let seen = shown[0].iter().filter(|h| h.kind == kind).count();
        assert!(seen > 1500, "{seen}");
    }
}
