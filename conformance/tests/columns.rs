//! Tests that samples taken three at a time have the bits of the CPU's: random scenes of the shapes, joints and depths for which
//! passes do so, and of neighbors for which they do not.

use argil_conformance::{CaseRng, Wait, gpu, stored_integers, voxel_grid};
use argil_field::Program;
use argil_gpu::{DenseFill, DeviceKind, GpuProgram, GpuVolume};
use argil_scene::{Brush, Group, Modifier, NodeId, Scene, Shape};
use argil_volume::{
    BrickCell, BrickLayout, BrickSettings, Bricks, Dense, Encoding, Texels, Volume,
};
use glam::IVec3;

fn shape(numbers: &mut CaseRng, nth: usize) -> Shape {
    let mut size = || numbers.between(0.1, 0.35);
    match nth % 8 {
        0 => Shape::sphere(size()),
        1 => Shape::rounded_box([size(), size(), size()], 0.03),
        2 => Shape::cylinder(size(), size()),
        3 => Shape::capsule([0.0; 3], [size(), size(), 0.0], 0.1),
        4 => Shape::torus(0.3, 0.3 * size()),
        5 => Shape::RoundCone {
            bottom_radius: size(),
            top_radius: 0.05,
            height: 0.4,
        },
        6 => Shape::Plane {
            normal: [0.2, 1.0, 0.1],
            offset: -0.5,
        },
        // None that is measured three times at once.
        _ => Shape::Octahedron { radius: size() },
    }
}

/// Adds brushes and groups in groups.
fn fill(scene: &mut Scene, group: NodeId, depth: u32, numbers: &mut CaseRng, kinds: usize) {
    for _ in 0..3 {
        let nth = (numbers.between(0.0, 1.0) * kinds as f32) as usize;
        let mut brush = Brush::new(shape(numbers, nth)).smooth(numbers.between(0.0, 0.1));
        if numbers.between(0.0, 1.0) < 0.5 {
            brush = brush
                .rotated(numbers.point(1.0).to_array(), numbers.between(0.0, 360.0))
                .scaled(numbers.between(0.7, 1.3));
        }
        brush = brush.at(numbers.point(0.6).to_array());
        brush = match (numbers.between(0.0, 6.0)) as u32 {
            0 => brush.subtract(),
            1 => brush.intersect(),
            _ => brush,
        };
        scene.push_into(group, brush).expect("a brush");
    }
    if depth > 0 {
        let mut inner = Group::new().smooth(numbers.between(0.01, 0.1));
        if numbers.between(0.0, 1.0) < 0.5 {
            inner = inner.with_modifier(Modifier::Round { radius: 0.02 });
        }
        let made = scene.push_into(group, inner).expect("a group").node;
        fill(scene, made, depth - 1, numbers, kinds);
    }
}

fn scene_of(seed: u64, depth: u32, kinds: usize) -> Scene {
    let mut numbers = CaseRng::new(seed);
    let mut scene = Scene::new();
    scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    scene.push(Brush::new(Shape::sphere(0.7))).expect("a brush");
    fill(&mut scene, Scene::ROOT, depth, &mut numbers, kinds);
    scene
}

fn cells(layout: &BrickLayout) -> impl Iterator<Item = IVec3> {
    let (low, high) = (layout.first_cell(), layout.end_cell());
    let along = move |axis: usize| low[axis]..high[axis];
    along(2)
        .flat_map(move |z| along(1).flat_map(move |y| along(0).map(move |x| IVec3::new(x, y, z))))
}

/// Counts the samples of common bricks, and those that differ by more than `allowed`.
fn compare(cpu: &Bricks, found: &Bricks, allowed: i32) -> [usize; 2] {
    let (own, other) = (stored_integers(cpu.pool()), stored_integers(found.pool()));
    let samples = cpu.layout().brick_samples() as usize;
    let mut counts = [0; 2];
    for cell in cells(cpu.layout()) {
        let (BrickCell::Brick(a), BrickCell::Brick(b)) = (cpu.cell(cell), found.cell(cell)) else {
            continue;
        };
        let of = |all: &[i32], brick: u32| all[brick as usize * samples..][..samples].to_vec();
        counts[0] += samples;
        let pairs = of(&own, a).into_iter().zip(of(&other, b));
        counts[1] += pairs.filter(|(a, b)| (a - b).abs() > allowed).count();
    }
    counts
}

fn differing(own: &Texels, other: &Texels, allowed: i32) -> usize {
    let (own, other) = (stored_integers(own), stored_integers(other));
    assert_eq!(own.len(), other.len());
    let pairs = own.into_iter().zip(other);
    pairs.filter(|(a, b)| (a - b).abs() > allowed).count()
}

#[test]
fn three_samples_at_once_have_the_bits_of_each() {
    let gpu = gpu();
    // Hardware contracts multiplications and additions.
    let allowed = i32::from(gpu.info().kind != DeviceKind::Software);
    let (mut samples, mut whole, mut partly) = (0, 0, 0);
    for seed in 0..12u64 {
        let (depth, kinds) = (seed as u32 % 4 * 2, [7, 8][seed as usize % 2]);
        let scene = scene_of(seed, depth, kinds);
        let program = Program::lower(&scene).expect("a program");
        let is_whole = program.column_words().is_some();
        *if is_whole { &mut whole } else { &mut partly } += 1;
        let field = GpuProgram::new(gpu.clone(), &program, false).expect("a field");

        let settings = BrickSettings {
            brick_size_voxels: [8, 4, 16][seed as usize % 3],
            ..BrickSettings::default()
        };
        let grid = voxel_grid(&scene, &program, 40);
        let layout = BrickLayout::new(grid, &settings).expect("a layout");
        let cpu = Bricks::bake(&program, layout, None).expect("bricks").0;
        let built = GpuVolume::bricks(&field, &program, layout, None).wait();
        let found = built.expect("a volume").0.download(&gpu).wait();
        let Volume::Bricks(found) = found.expect("a volume") else {
            panic!("bricks were read");
        };
        let [compared, apart] = compare(&cpu, &found, allowed);
        assert_eq!(apart, 0, "bricks of seed {seed}, of {compared}");
        samples += compared;

        let (grid, encoding) = (voxel_grid(&scene, &program, 29), Encoding::default());
        let cpu = Dense::bake(&program, grid, encoding, false);
        let built = GpuVolume::dense(&field, &program, grid, encoding, false, DenseFill::Tiled);
        let found = built.wait().expect("a volume").0.download(&gpu).wait();
        let Volume::Dense(found) = found.expect("a volume") else {
            panic!("a dense volume was read");
        };
        let apart = differing(&cpu.levels()[0], &found.levels()[0], allowed);
        assert_eq!(apart, 0, "texels of seed {seed}");
    }
    assert!(samples > 100_000, "{samples}");
    // Both kinds of programs were tried.
    assert!(whole > 2 && partly > 2, "{whole} and {partly}");
}
