//! Tests sparse bricks in their buffers: cells and samples against the field, and the GPU against the CPU.
//!
//! *Length.* A test for each pass of sparse bricks, with the reading of buffers that they share.

use argil_abi::GpuMaterial;
use argil_conformance::Wait;
use argil_conformance::{
    CaseRng, SceneCase, SharedFields, all_cases, by_opcodes, gpu, gpu_field, random_blends,
    random_scene, shipped, stored_integers, voxel_grid,
};
use argil_field::{Evaluator, Grid, Program};
use argil_gpu::{GpuProgram, GpuVolume};
use argil_math::Aabb;
use argil_scene::{Brush, Group, Scene, Shape};
use argil_volume::{BrickCell, BrickLayout, BrickSettings, Bricks, BricksError, Encoding, Volume};
use glam::{IVec3, UVec3, Vec3};

/// Samples along a voxel's edge.
const FINER: u32 = 4;

fn layout_of(program: &Program, scene: &Scene, resolution: u32, brick: u32) -> BrickLayout {
    let settings = BrickSettings {
        brick_size_voxels: brick,
        ..BrickSettings::default()
    };
    BrickLayout::new(voxel_grid(scene, program, resolution), &settings).expect("a layout")
}

fn bake(program: &Program, layout: BrickLayout) -> Bricks {
    Bricks::bake(program, layout, None).expect("bricks").0
}

fn cases() -> Vec<SceneCase> {
    let mut cases = shipped();
    cases.extend((20..32).map(|seed| random_blends(seed, 24)));
    cases
}

fn cells(layout: &BrickLayout) -> impl Iterator<Item = IVec3> {
    let (low, high) = (layout.first_cell(), layout.end_cell());
    (low.z..high.z).flat_map(move |z| {
        (low.y..high.y).flat_map(move |y| (low.x..high.x).map(move |x| IVec3::new(x, y, z)))
    })
}

/// Whether samples in a cell's closed box, four per voxel's edge, have both signs.
fn is_crossed(evaluator: &mut Evaluator<'_>, layout: &BrickLayout, cell: IVec3) -> bool {
    let spacing = Vec3::splat(layout.voxel_grid().voxel_size / FINER as f32);
    let held = layout.cell_box(cell);
    // What lies outside of the volume is not asked for.
    let end = held.max.min(layout.voxel_grid().aabb().max + 0.5 * spacing);
    let most = UVec3::splat(layout.brick_size_voxels() * FINER);
    let grid = Grid {
        min: held.min,
        spacing,
        begin: UVec3::ZERO,
        size: ((end - held.min) / spacing).as_uvec3().min(most) + 1,
    };
    let (mut inside, mut outside) = (false, false);
    let xs = grid.coordinates(0);
    for k in 0..grid.size.z {
        grid.sweep_layer(evaluator, &xs, k, |_, d| {
            inside |= d.iter().any(|&d| d < 0.0);
            outside |= d.iter().any(|&d| d >= 0.0);
        });
        if inside && outside {
            return true;
        }
    }
    false
}

/// Counts cells that contain surface, those of them without a brick, and those that half of the margin would lose.
fn crossings(program: &Program, bricks: &Bricks) -> (usize, usize, usize) {
    let layout = bricks.layout();
    let mut evaluator = Evaluator::new(program);
    let (mut crossed, mut missed, mut lost_by_less) = (0, 0, 0);
    for cell in cells(layout) {
        if is_crossed(&mut evaluator, layout, cell) {
            crossed += 1;
            let has_brick = matches!(bricks.cell(cell), BrickCell::Brick(_));
            missed += usize::from(!has_brick);
            let d = program.distance(layout.cell_box(cell).center());
            lost_by_less += usize::from(d.abs() > 0.5 * layout.half_diagonal(1));
        }
    }
    (crossed, missed, lost_by_less)
}

/// Conservative: each cell with a change of sign at four times the resolution has a brick. A smaller margin would
/// lose some.
#[test]
fn no_cell_with_surface_is_without_its_brick() {
    let mut all_lost = 0;
    for case in cases() {
        let program = Program::lower(&case.scene).expect("a program");
        let resolution = if case.name == "temple" { 32 } else { 48 };
        for brick in [4, 8, 16] {
            let layout = layout_of(&program, &case.scene, resolution, brick);
            let bricks = bake(&program, layout);
            let (crossed, missed, lost_by_less) = crossings(&program, &bricks);
            assert_eq!(missed, 0, "{}: of {crossed} cells of {brick}", case.name);
            assert!(crossed > 5, "{}: {crossed}", case.name);
            assert!(bricks.len() >= crossed);
            all_lost += lost_by_less;
        }
    }
    assert!(all_lost > 100, "{all_lost}");
}

/// No point of an empty cell is nearer to the surface than the cell's bound, and all have its sign. Counts the
/// tested points, and how many a bound larger by half a diagonal would violate.
fn check_empty_cells(name: &str, program: &Program, bricks: &Bricks) -> (usize, usize) {
    let layout = bricks.layout();
    let mut numbers = CaseRng::new(7);
    let spread = program.lipschitz() * layout.half_diagonal(1);
    let (mut checked, mut too_much) = (0, 0);
    for cell in cells(layout) {
        let BrickCell::Empty {
            center,
            is_block_empty,
        } = bricks.cell(cell)
        else {
            continue;
        };
        let held = layout.cell_box(cell);
        let mask = bricks.masks()[bricks.word_index(cell) / 64];
        assert_eq!(is_block_empty, mask == 0);
        let mut points = held.corners().to_vec();
        let size = held.size();
        points.extend((0..4).map(|_| held.min + size * (numbers.point(0.5) + 0.5)));
        for p in points {
            let d = program.distance(p);
            let rounding = program.bound_error(held);
            let away = (center.abs() - spread).max(0.0);
            assert!(
                d.abs() >= away - rounding && (d < 0.0) == (center < 0.0),
                "{name} {cell}: {d} at {p}, and the cell says {center}",
            );
            checked += 1;
            too_much += usize::from(d.abs() < away + spread);
        }
    }
    (checked, too_much)
}

/// Conservative: bounds of empty cells on the CPU.
#[test]
fn empty_cells_never_overstate_the_distance() {
    let (mut checked, mut too_much) = (0, 0);
    for case in cases() {
        let program = Program::lower(&case.scene).expect("a program");
        let layout = layout_of(&program, &case.scene, 64, 8);
        let found = check_empty_cells(&case.name, &program, &bake(&program, layout));
        (checked, too_much) = (checked + found.0, too_much + found.1);
    }
    assert!(checked > 50_000 && too_much > 1000, "{checked}, {too_much}");
}

/// The same for bricks that the GPU built: no surface is lost, and no distance is overstated.
#[test]
fn gpu_bricks_are_conservative_too() {
    let gpu = gpu();
    let (mut crossed, mut checked) = (0, 0);
    let slow = ["dense-edgy-cubes", "temple"];
    let cases = cases().into_iter().filter(|c| !slow.contains(&&*c.name));
    for case in cases.take(10) {
        let program = Program::lower(&case.scene).expect("a program");
        let field = GpuProgram::new(gpu.clone(), &program, false).expect("a field");
        let layout = layout_of(&program, &case.scene, 56, 4);
        let (volume, _) = GpuVolume::bricks(&field, &program, layout, None)
            .wait()
            .expect("a volume");
        let Volume::Bricks(bricks) = volume.download(&gpu).wait().expect("a volume") else {
            panic!("bricks were read");
        };
        let (cells, missed, _) = crossings(&program, &bricks);
        assert_eq!(missed, 0, "{}: of {cells} cells", case.name);
        crossed += cells;
        checked += check_empty_cells(&case.name, &program, &bricks).0;
    }
    assert!(crossed > 1000 && checked > 20_000, "{crossed}, {checked}");
}

/// Returns nested groups, each next to a sphere.
fn deep(levels: u32) -> SceneCase {
    let mut numbers = CaseRng::new(57);
    let mut scene = Scene::new();
    let mut group = Scene::ROOT;
    for _ in 0..levels {
        let ball = Brush::new(Shape::sphere(0.05))
            .at(numbers.point(0.9).to_array())
            .smooth(0.02);
        scene.push_into(group, ball).expect("a valid brush");
        let made = scene.push_into(group, Group::new()).expect("a group");
        group = made.node;
    }
    scene
        .push_into(group, Brush::new(Shape::sphere(0.2)))
        .expect("a valid brush");
    SceneCase {
        name: format!("{levels} levels"),
        scene,
    }
}

/// Exact: samples equal the unpruned program at the corners of voxels, and neighbors agree on their common side.
#[test]
fn samples_are_the_fields() {
    let long = SceneCase {
        name: "twenty thousand brushes".into(),
        scene: random_scene(20_000, 3),
    };
    let extremes = [deep(3_000), long];
    for (i, case) in cases().into_iter().chain(extremes).enumerate() {
        let program = Program::lower(&case.scene).expect("a program");
        let layout = layout_of(&program, &case.scene, 40 + i as u32, [8, 4, 16][i % 3]);
        let bricks = bake(&program, layout);
        let stored = stored_integers(bricks.pool());
        let (side, range) = (
            layout.brick_size_voxels() + 1,
            layout.encoding().band_width(layout.voxel_grid(), 0),
        );
        let quanta = layout.encoding().format.max_code() as f32;
        for cell in cells(&layout).step_by(3) {
            let BrickCell::Brick(brick) = bricks.cell(cell) else {
                continue;
            };
            let stride = if program.instructions().len() > 1000 {
                311
            } else {
                17
            };
            for at in (0..layout.brick_samples()).step_by(stride) {
                let place = UVec3::new(at % side, at / side % side, at / side / side);
                let whole = (cell * layout.brick_size_voxels() as i32).as_vec3() + place.as_vec3();
                let p = layout.voxel_grid().corner + layout.voxel_grid().voxel_size * whole;
                let d = program.distance(p);
                let expected = (d * (quanta / range)).clamp(-quanta, quanta) + 0.5;
                let found = stored[(brick * layout.brick_samples() + at) as usize];
                assert_eq!(
                    found,
                    expected.floor() as i32,
                    "{} {cell} {place}",
                    case.name
                );
            }
        }
    }
}

/// Counts cells with a brick in only one of two volumes, and differing samples.
fn compare(cpu: &Bricks, found: &Bricks) -> (usize, usize, usize) {
    let layout = cpu.layout();
    let (mut differing, mut apart, mut texels) = (0, 0, 0);
    let (a, b) = (stored_integers(cpu.pool()), stored_integers(found.pool()));
    let samples = layout.brick_samples();
    let range = layout.encoding().band_width(layout.voxel_grid(), 0);
    let step = layout.encoding().format.max_code() as f32 / range;
    for cell in cells(layout) {
        match (cpu.cell(cell), found.cell(cell)) {
            (BrickCell::Brick(brick), BrickCell::Brick(other)) => {
                let brick = &a[(brick * samples) as usize..][..samples as usize];
                let other = &b[(other * samples) as usize..][..samples as usize];
                for (texel, other) in brick.iter().zip(other) {
                    // Rounding: of the field, and which of two integers is nearer.
                    let allowed = 1 + (4e-5 * step * (1.0 + range)) as i32;
                    apart += usize::from((texel - other).abs() > allowed);
                    texels += 1;
                }
            }
            (BrickCell::Empty { center: middle, .. }, BrickCell::Empty { center: other, .. }) => {
                // The CPU knows less of cells that are far.
                let is_same = middle.abs() <= other.abs() + 1e-4 && (middle < 0.0) == (other < 0.0);
                let is_zero = middle == 0.0 || other == 0.0;
                apart += usize::from(!is_same && !is_zero);
            }
            _ => differing += 1,
        }
    }
    (differing, apart, texels)
}

/// Compares two volumes: equal cells, except for a few at the limit of rounding, and equal samples. Returns their
/// number.
fn assert_same(name: &str, cpu: &Bricks, found: &Bricks) -> usize {
    let (differing, apart, texels) = compare(cpu, found);
    assert!(
        differing <= 1 + cpu.len() / 500,
        "{name}: {differing} cells differ, of {}",
        cpu.len()
    );
    assert!(apart <= texels / 2000, "{name}: {apart} of {texels}");
    texels
}

/// Set-equal: the same cells have bricks, in any order of the pool. Samples and distances are bounded.
#[test]
fn gpu_bricks_are_the_cpus() {
    // A software device runs all of an interpreter for every sample: one case runs with the opcodes of all.
    let mut shared = gpu_field();
    let gpu = shared.gpu().clone();
    let mut cases = shipped();
    cases.extend((2..4).map(|seed| random_blends(seed, 20)));
    cases.push(SceneCase {
        name: "nothing".into(),
        scene: Scene::new(),
    });
    for (i, case) in cases.iter().enumerate() {
        let program = Program::lower(&case.scene).expect("a program");
        let does_everything = case.name == "edgy-cube";
        let specialized;
        let field = if does_everything {
            shared.update(&program).expect("a field");
            &shared
        } else {
            specialized = GpuProgram::new(gpu.clone(), &program, false).expect("a field");
            &specialized
        };
        // A software device takes minutes for many brushes, and for many opcodes.
        let resolution = match program.brush_count() {
            _ if does_everything => 12,
            300.. => 20,
            _ => 28 + i as u32,
        };
        let mut layout = layout_of(&program, &case.scene, resolution, [8, 4, 8, 16][i % 4]);
        if i % 3 == 1 {
            let settings = BrickSettings {
                encoding: Encoding::default(),
                brick_size_voxels: layout.brick_size_voxels(),
            };
            layout = BrickLayout::new(*layout.voxel_grid(), &settings).expect("a layout");
        }
        let cpu = bake(&program, layout);
        let (volume, stages) = GpuVolume::bricks(field, &program, layout, None)
            .wait()
            .expect("a volume");
        assert!(stages.iter().all(|(_, ms)| *ms > 0.0));
        let Volume::Bricks(found) = volume.download(&gpu).wait().expect("a volume") else {
            panic!("bricks were read");
        };
        let texels = assert_same(&case.name, &cpu, &found);

        // What they look like, at the center of each.
        let palette = program.materials();
        let (mut alike, mut unlike) = (0, 0);
        for cell in cells(&layout) {
            let p = layout.cell_box(cell).center();
            if let (Some(material), Some(other)) = (
                cpu.material(p, Vec3::Y, palette),
                found.material(p, Vec3::Y, palette),
            ) {
                let is_like = material_gap(&material, &other) < 0.02;
                alike += usize::from(is_like);
                unlike += usize::from(!is_like);
            }
        }
        assert!(unlike <= alike / 200, "{}: {unlike} of {alike}", case.name);
        // Negative control: a volume moved by a tenth of a voxel.
        let mut grid = *layout.voxel_grid();
        grid.corner += 0.1 * grid.voxel_size;
        let moved = layout.with_grid(grid).expect("a layout");
        if texels > 0 {
            assert!(
                stored_integers(bake(&program, moved).pool()) != stored_integers(cpu.pool()),
                "{}",
                case.name
            );
        }
        // There and back is the same to the bit.
        let there = GpuVolume::upload(field, &cpu.clone().into())
            .wait()
            .expect("a volume");
        assert!(there.download(&gpu).wait().expect("a volume") == Volume::Bricks(cpu));
    }
}

/// The GPU prunes every operator, modifier and structure as the CPU does, cell by cell and sample by sample.
/// `prune.rs` compares the CPU with the unpruned program.
#[test]
fn the_gpu_prunes_as_the_cpu() {
    let mut fields = SharedFields::new(gpu());
    let mut compared = 0;
    for (case, program) in by_opcodes(all_cases()) {
        if program.instructions().len() < 2 {
            continue;
        }
        let layout = layout_of(&program, &case.scene, 16, 4);
        let cpu = bake(&program, layout);
        let field = fields.running(&program);
        let (volume, _) = GpuVolume::bricks(field, &program, layout, None)
            .wait()
            .expect("a volume");
        let Volume::Bricks(found) = volume.download(field.gpu()).wait().expect("a volume") else {
            panic!("bricks were read");
        };
        compared += assert_same(&case.name, &cpu, &found);
    }
    assert!(compared > 200_000, "{compared}");
}

/// Both devices keep to a memory budget, and the error names the needed memory.
#[test]
fn a_memory_budget_is_respected() {
    let mut scene = Scene::new();
    scene
        .push(Brush::new(Shape::sphere(0.7)))
        .expect("a valid brush");
    let program = Program::lower(&scene).expect("a program");
    let layout = layout_of(&program, &scene, 64, 8);
    let bricks = bake(&program, layout);
    let needed = bricks.memory_bytes();
    let refused = Bricks::bake(&program, layout, Some(needed / 2));
    assert!(matches!(refused, Err(BricksError::Budget { needed: n, .. }) if n >= needed));
    let enough = needed * 3 / 2;
    assert!(Bricks::bake(&program, layout, Some(enough)).is_ok());

    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let refused = GpuVolume::bricks(&field, &program, layout, Some(needed / 2)).wait();
    assert!(matches!(refused, Err(argil_gpu::GpuError::Budget { .. })));
    assert!(
        GpuVolume::bricks(&field, &program, layout, Some(enough))
            .wait()
            .is_ok()
    );
    // Tables alone can be too much: nothing is made first.
    let layout = layout_of(&program, &scene, 4096, 4);
    let refused = Bricks::bake(&program, layout, Some(1 << 20));
    assert!(matches!(refused, Err(BricksError::Blocks { .. })));
}

/// The materials of mixed bricks count toward the budget: without them, the bricks would fit.
#[test]
fn a_budget_counts_materials() {
    let mut cases = shipped().into_iter();
    let case = cases
        .find(|c| c.name == "csg20")
        .expect("a scene that ships");
    let program = Program::lower(&case.scene).expect("a program");
    let layout = layout_of(&program, &case.scene, 64, 8);
    let bricks = bake(&program, layout);
    let of_mixed = size_of_val(bricks.mixed()) as u64;
    // More than what the candidates that were dropped would have taken.
    let budget = bricks.memory_bytes() - 1;
    assert!(of_mixed > 10_000, "{of_mixed}");
    assert!(Bricks::bake(&program, layout, Some(budget)).is_err());

    // What the GPU keeps is within whatever it may take, and not much more than what the CPU keeps.
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let mut kept = 0;
    for share in [11, 12, 14, 20, 40] {
        let budget = bricks.memory_bytes() * share / 10;
        if let Ok((volume, _)) = GpuVolume::bricks(&field, &program, layout, Some(budget)).wait() {
            assert!(volume.memory_bytes() <= budget, "{share}");
            kept += 1;
        }
    }
    assert!(kept >= 3, "{kept}");
}

/// A pool that was estimated too small grows: all cells of a block of noise have bricks.
#[test]
fn a_pool_grows_to_the_needed_size() {
    // Balls everywhere: a surface in nearly every cell, of a field that costs little.
    let balls = r#"{"argil":1,"brushes":[{"shape":{"type":"sphere","radius":0.03},
        "modifiers":[{"type":"repeat","spacing":[0.08,0.08,0.08],"count":[13,13,13]}]}]}"#;
    let scene = Scene::from_json(balls, "balls").expect("a scene");
    let program = Program::lower(&scene).expect("a program");
    let layout = layout_of(&program, &scene, 96, 4);
    let bricks = bake(&program, layout);
    let [x, y, z] = layout.size_cells().to_array();
    assert!(
        bricks.len() as u32 > 2 * (x * y + y * z + x * z),
        "{}",
        bricks.len()
    );
    let field = GpuProgram::new(gpu(), &program, false).expect("a field");
    let (volume, _) = GpuVolume::bricks(&field, &program, layout, None)
        .wait()
        .expect("a volume");
    let info = volume.info(field.gpu()).wait().expect("an answer");
    let count = info.bricks.expect("bricks").bricks;
    assert!(count.abs_diff(bricks.len() as u64) <= bricks.len() as u64 / 100);
}

/// The resolution is the requested one.
#[test]
fn no_resolution_is_rounded() {
    let solid = Aabb::new(Vec3::splat(-0.5), Vec3::new(0.5, 0.2, 0.1));
    for resolution in [8, 37, 300, 1000] {
        let voxel_grid =
            argil_volume::VoxelGrid::fitting(solid, None, resolution).expect("a voxel grid");
        let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
        assert_eq!(layout.voxel_grid().size.max_element(), resolution);
        let reach = layout.size_cells() * layout.brick_size_voxels();
        assert!(reach.cmpge(voxel_grid.size).all() && (reach - voxel_grid.size).max_element() < 8);
    }
}

/// Returns the largest difference of two materials' bytes.
fn material_gap(a: &GpuMaterial, b: &GpuMaterial) -> f32 {
    let numbers = a.base_roughness.iter().chain(&a.emission_metallic);
    let other = b.base_roughness.iter().chain(&b.emission_metallic);
    numbers
        .zip(other)
        .map(|(a, b)| (a - b).abs() / (1.0 + b))
        .fold(0.0, f32::max)
}

/// Bounded: near the surface, stored materials equal the field's, except within a sample's width of a border. With
/// another table of materials they differ.
#[test]
fn colors_and_blends_survive_baking() {
    let (mut mixed, mut all_near, mut all_off, mut all_turned) = (0, 0, 0, 0);
    for case in cases() {
        let program = Program::lower(&case.scene).expect("a program");
        let layout = layout_of(&program, &case.scene, 96, 8);
        let bricks = bake(&program, layout);
        mixed += bricks.mixed().len();
        let mut numbers = CaseRng::new(3);
        let mut evaluator = Evaluator::new(&program);
        let palette = program.materials();
        let mut turned = palette.to_vec();
        turned.rotate_left(1);
        let (mut near, mut off, mut total, mut off_turned) = (0, 0, 0.0, 0);
        for cell in cells(&layout).filter(|&c| matches!(bricks.cell(c), BrickCell::Brick(_))) {
            for _ in 0..40 {
                let held = layout.cell_box(cell);
                let p = held.min + held.size() * (numbers.point(0.5) + 0.5);
                let (mut d, mut exact) = ([0.0], [GpuMaterial::default()]);
                evaluator.materials(&[p.x], &[p.y], &[p.z], &mut d, &mut exact);
                if d[0].abs() > 0.3 * layout.voxel_grid().voxel_size {
                    continue;
                }
                let outward = program.gradient(p).1.normalize_or_zero();
                let stored = bricks.material(p, outward, palette);
                let stored = stored.expect("a brick is there");
                let gap = material_gap(&stored, &exact[0]);
                near += 1;
                total += gap;
                off += usize::from(gap > 0.15);
                let other = bricks
                    .material(p, outward, &turned)
                    .expect("a brick is there");
                off_turned += usize::from(material_gap(&other, &exact[0]) > 0.15);
            }
        }
        let mean = total / near as f32;
        assert!(near > 300, "{}: {near}", case.name);
        assert!(
            mean < 0.06 && off <= near / 6,
            "{}: {mean} in the mean, {off} of {near} off",
            case.name
        );
        (all_off, all_turned) = (all_off + off, all_turned + off_turned);
        all_near += near;
    }
    assert!(all_off <= all_near / 14, "{all_off} of {all_near}");
    assert!(all_turned > 2 * all_off, "{all_turned}, {all_off}");
    assert!(mixed > 10_000, "{mixed}");
}

/// A ring of noisy solids with a smooth joint needs no more bricks than without the joint, and loses none. The
/// jumps of copies count only near the copies.
#[test]
fn a_blend_near_a_ring_adds_only_its_own_bricks() {
    let ring = |blend: f32, amplitude: f32| {
        let text = format!(
            r#"{{"argil":1,"brushes":[
                {{"shape":{{"type":"box","half_size":[0.06,0.3,0.06]}},"modifiers":[
                    {{"type":"displace","amplitude":{amplitude},"frequency":20}},
                    {{"type":"translate","by":[0.7,0,0]}},
                    {{"type":"radial_repeat","count":8}}]}},
                {{"operator":"union","blend":{blend},"shape":{{"type":"sphere","radius":0.25}}}}]}}"#
        );
        Scene::from_json(&text, "ring").expect("a scene")
    };
    for (blend, amplitude) in [(0.02, 0.01), (0.05, 0.02)] {
        let [hard, smooth] = [0.0, blend].map(|blend| {
            let scene = ring(blend, amplitude);
            let program = Program::lower(&scene).expect("a program");
            let layout = layout_of(&program, &scene, 128, 8);
            let bricks = bake(&program, layout);
            let (crossed, missed, _) = crossings(&program, &bricks);
            assert_eq!(missed, 0, "of {crossed}, blend {blend}");
            bricks.len()
        });
        assert!(
            10 * smooth <= 13 * hard,
            "{smooth} with a blend, {hard} without"
        );
    }
}
