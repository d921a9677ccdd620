//! Tests that samples taken three at a time have the bits of those taken one by one: random scenes of the shapes, joints and depths for which
//! passes do so, and of neighbors for which they do not.

use argil_conformance::{CaseRng, Wait, gpu, stored_integers, voxel_grid};
use argil_field::Program;
use argil_gpu::{DeviceKind, GpuProgram, GpuVolume};
use argil_scene::{Brush, Group, Modifier, NodeId, Scene, Shape};
use argil_volume::{
    BrickCell, BrickLayout, BrickSettings, Bricks, Dense, DenseFill, Encoding, Volume,
};
use glam::{IVec3, UVec3, Vec3};

fn shape(numbers: &mut CaseRng, index: usize) -> Shape {
    let mut size = || numbers.between(0.1, 0.35);
    match index % 8 {
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
        let index = (numbers.between(0.0, 1.0) * kinds as f32) as usize;
        let mut brush = Brush::new(shape(numbers, index)).smooth(numbers.between(0.0, 0.1));
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
        // The deeper operand comes first, and is exchanged with the other.
        if numbers.between(0.0, 1.0) < 0.5 {
            inner = inner.subtract();
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

/// A sample that differs from the CPU's: where, and the device's.
type Apart = (Vec3, i32);

/// Returns the number of samples of common bricks, and those that differ.
fn compare(cpu: &Bricks, found: &Bricks) -> (usize, Vec<Apart>) {
    let layout = cpu.layout();
    let (ours, other) = (stored_integers(cpu.pool()), stored_integers(found.pool()));
    let (samples, side) = (layout.brick_samples(), layout.brick_size_voxels() + 1);
    let (mut count, mut apart) = (0, Vec::new());
    for cell in cells(layout) {
        let (BrickCell::Brick(a), BrickCell::Brick(b)) = (cpu.cell(cell), found.cell(cell)) else {
            continue;
        };
        count += samples as usize;
        for i in 0..samples {
            let place = UVec3::new(i % side, i / side % side, i / side / side);
            let [a, b] = [
                ours[(a * samples + i) as usize],
                other[(b * samples + i) as usize],
            ];
            if a != b {
                let whole = (cell * layout.brick_size_voxels() as i32).as_vec3() + place.as_vec3();
                let grid = layout.voxel_grid();
                apart.push((grid.corner + grid.voxel_size * whole, b));
            }
        }
    }
    (count, apart)
}

/// Checks that samples are those of the device's other interpreter, which rounds some roots otherwise than the CPU. Hardware
/// also contracts multiplications and additions.
fn check(field: &GpuProgram, layout: &BrickLayout, apart: &[Apart], name: &str) {
    let allowed = i32::from(field.gpu().info().kind != DeviceKind::Software);
    let points: Vec<[f32; 3]> = apart.iter().map(|(p, _)| p.to_array()).collect();
    let quanta = layout.encoding().format.max_code() as f32;
    let range = layout.encoding().band_width(layout.voxel_grid(), 0);
    let answers = field.evaluate(&points).wait().expect("answers");
    for ((p, found), answer) in apart.iter().zip(answers) {
        let code = (answer.distance[0] * (quanta / range)).clamp(-quanta, quanta) + 0.5;
        let gap = (code.floor() as i32 - found).abs();
        assert!(gap <= allowed, "{name}: {found} and {code} at {p}");
    }
}

#[test]
fn three_samples_at_once_have_the_bits_of_each() {
    let gpu = gpu();
    let (mut samples, mut whole, mut partly) = (0, 0, 0);
    for seed in 0..8u64 {
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
        let grid = voxel_grid(&scene, &program, 28);
        let layout = BrickLayout::new(grid, &settings).expect("a layout");
        let cpu = Bricks::bake(&program, layout, None).expect("bricks").0;
        let built = GpuVolume::bricks(&field, &program, layout, None).wait();
        let found = built.expect("a volume").0.download(&gpu).wait();
        let Volume::Bricks(found) = found.expect("a volume") else {
            panic!("bricks were read");
        };
        let (compared, apart) = compare(&cpu, &found);
        assert!(
            apart.len() <= compared / 1000,
            "{} of {compared}",
            apart.len()
        );
        if !apart.is_empty() {
            check(&field, &layout, &apart, &format!("seed {seed}"));
        }
        samples += compared;

        let (grid, encoding) = (voxel_grid(&scene, &program, 20), Encoding::default());
        let cpu = Dense::bake(&program, grid, encoding, false);
        let built = GpuVolume::dense(&field, &program, grid, encoding, false, DenseFill::Tiled);
        let found = built.wait().expect("a volume").0.download(&gpu).wait();
        let Volume::Dense(found) = found.expect("a volume") else {
            panic!("a dense volume was read");
        };
        let [ours, other] = [&cpu, &found].map(|dense| stored_integers(&dense.levels()[0]));
        let gaps = ours.iter().zip(&other).map(|(a, b)| (a - b).abs());
        let (apart, most) = gaps.fold((0, 0), |(n, most), gap| (n + gap.min(1), most.max(gap)));
        assert!(most <= 1, "seed {seed}: {apart} of {}", ours.len());
        assert!(
            apart as usize <= ours.len() / 1000,
            "seed {seed}: {apart} texels"
        );
    }
    assert!(samples > 100_000, "{samples}");
    // Both kinds of programs were tried.
    assert!(whole > 2 && partly > 2, "{whole} and {partly}");
}
