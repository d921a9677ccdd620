//! Tests pruned programs: in its cell, a pruned program is bit-equal to the unpruned one.

use argil_abi::Instruction;
use argil_conformance::{CaseRng, SceneCase, all_cases, random_blends, shipped};
use argil_field::{CELLS_PER_BATCH, Evaluator, Grid, LANES, Program, Pruner};
use argil_math::Aabb;
use argil_scene::{Brush, Scene, Shape};
use glam::{UVec3, Vec3};

/// Returns the eight halves of a box.
fn halves(cell: Aabb) -> [Aabb; 8] {
    let center = cell.center();
    cell.corners()
        .map(|corner| Aabb::new(corner.min(center), corner.max(center)))
}

fn sample(cell: Aabb, numbers: &mut CaseRng) -> [[f32; LANES]; 3] {
    let mut points = [[0.0; LANES]; 3];
    for i in 0..LANES {
        for (axis, lanes) in points.iter_mut().enumerate() {
            lanes[i] = cell.min[axis] + cell.size()[axis] * numbers.unit();
        }
    }
    // Corners and the middle too.
    for (i, p) in cell
        .corners()
        .into_iter()
        .chain([cell.center()])
        .enumerate()
    {
        for (axis, lanes) in points.iter_mut().enumerate() {
            lanes[i] = p[axis];
        }
    }
    points
}

/// Statistics of walks to a few random small cells.
struct Walk {
    /// Instructions of the unpruned program, and of the pruned ones at the end.
    whole: usize,
    left: usize,
    cells: usize,
}

fn walk(case: &SceneCase, depth: usize, walks: usize, numbers: &mut CaseRng) -> Walk {
    let program = Program::lower(&case.scene).expect("a program");
    let region = if program.aabb().is_finite() {
        program.aabb().grown(0.1)
    } else {
        Aabb::centered(Vec3::ONE)
    };
    let mut pruner = Pruner::new(&program);
    let mut evaluator = Evaluator::new(&program);
    let mut result = Walk {
        whole: 0,
        left: 0,
        cells: 0,
    };
    for _ in 0..walks {
        let mut list: Vec<Instruction> = program.instructions().to_vec();
        let mut cell = region;
        for _ in 0..depth {
            let cells = halves(cell);
            let centers = cells.map(Aabb::center);
            let mut d = [0.0; 8];
            pruner.classify_cells(&list, &centers, cells[0].half_diagonal(), &mut d);
            let cell_index = (numbers.unit() * 8.0) as usize % 8;
            assert_eq!(
                d[cell_index],
                program.distance(centers[cell_index]),
                "{}",
                case.name
            );
            let mut next = Vec::new();
            pruner.prune_into(&list, cell_index, &mut next);
            assert!(next.len() <= list.len());
            (list, cell) = (next, cells[cell_index]);
            let [x, y, z] = sample(cell, numbers);
            let (mut whole, mut pruned) = ([0.0; LANES], [0.0; LANES]);
            evaluator.distances(&x, &y, &z, &mut whole);
            evaluator.distances_with(&list, &x, &y, &z, &mut pruned);
            assert!(
                whole == pruned,
                "{}: {} instructions of {} in {cell:?}",
                case.name,
                list.len(),
                program.instructions().len()
            );
        }
        result.whole += program.instructions().len();
        result.left += list.len();
        result.cells += 1;
    }
    result
}

/// Exact: every shape, operator, modifier and structure, all scenes in the repository, and random blends.
#[test]
fn a_pruned_list_gives_the_whole_programs_bits_in_its_cell() {
    let mut numbers = CaseRng::new(51);
    let mut cases = all_cases();
    cases.extend(shipped());
    cases.extend((40..52).map(|seed| random_blends(seed, 40)));
    let (mut whole, mut left) = (0, 0);
    for case in &cases {
        let found = walk(case, 5, 24, &mut numbers);
        whole += found.whole;
        left += found.left;
    }
    // It does prune.
    assert!(2 * left < whole, "{left} of {whole}");
}

/// Among a thousand spheres, a small cell needs a few.
#[test]
fn a_small_cell_has_a_short_list() {
    let mut numbers = CaseRng::new(52);
    let mut scene = Scene::new();
    for _ in 0..1000 {
        let ball = Brush::new(Shape::sphere(0.08))
            .at(numbers.point(1.0).to_array())
            .smooth(0.03);
        scene.push(ball).expect("a valid brush");
    }
    let case = SceneCase {
        name: "a thousand balls".into(),
        scene,
    };
    let found = walk(&case, 6, 60, &mut numbers);
    let mean = found.left / found.cells;
    assert!(mean < 20, "{mean} instructions on average");
}

/// Negative control: a cell's pruned program gives wrong distances in another cell.
#[test]
fn a_list_is_wrong_outside_of_its_cell() {
    let case = random_blends(53, 40);
    let program = Program::lower(&case.scene).expect("a program");
    let cells = halves(program.aabb());
    let centers = cells.map(Aabb::center);
    let mut pruner = Pruner::new(&program);
    let mut d = [0.0; 8];
    // A half diagonal that is far too small makes lists that are far too short.
    pruner.classify_cells(program.instructions(), &centers, 0.01, &mut d);
    let mut list = Vec::new();
    pruner.prune_into(program.instructions(), 0, &mut list);
    let mut numbers = CaseRng::new(54);
    let [x, y, z] = sample(cells[7], &mut numbers);
    let mut evaluator = Evaluator::new(&program);
    let (mut whole, mut pruned) = ([0.0; LANES], [0.0; LANES]);
    evaluator.distances(&x, &y, &z, &mut whole);
    evaluator.distances_with(&list, &x, &y, &z, &mut pruned);
    assert_ne!(whole, pruned);
}

/// All cells of a full batch have their own pruned programs.
#[test]
fn a_full_batch_of_cells_has_separate_programs() {
    let case = random_blends(55, 40);
    let program = Program::lower(&case.scene).expect("a program");
    let region = program.aabb();
    let edge = region.size() / 4.0;
    let mut centers = Vec::new();
    for i in 0..CELLS_PER_BATCH {
        let at = Vec3::new((i % 4) as f32, (i / 4 % 4) as f32, (i / 16) as f32);
        centers.push(region.min + edge * (at + 0.5));
    }
    let half_diagonal = 0.5 * edge.length();
    let mut pruner = Pruner::new(&program);
    let mut d = [0.0; CELLS_PER_BATCH];
    pruner.classify_cells(program.instructions(), &centers, half_diagonal, &mut d);
    let mut evaluator = Evaluator::new(&program);
    let mut numbers = CaseRng::new(56);
    let mut lengths = std::collections::HashSet::new();
    for (i, &center) in centers.iter().enumerate() {
        let mut list = Vec::new();
        pruner.prune_into(program.instructions(), i, &mut list);
        let cell = Aabb::new(center - 0.5 * edge, center + 0.5 * edge);
        let [x, y, z] = sample(cell, &mut numbers);
        let (mut whole, mut pruned) = ([0.0; LANES], [0.0; LANES]);
        evaluator.distances(&x, &y, &z, &mut whole);
        evaluator.distances_with(&list, &x, &y, &z, &mut pruned);
        assert_eq!(whole, pruned);
        lengths.insert(list.len());
    }
    assert!(lengths.len() > 5);
}

/// Grids of uneven sizes and spacings, for every case: each distance equals the unpruned program, also far from the
/// surface.
#[test]
fn grids_by_parts_are_the_whole_programs() {
    let mut pruned = 0;
    for case in all_cases() {
        let program = Program::lower(&case.scene).expect("a program");
        let grid = Grid {
            min: Vec3::new(-1.7, -1.3, -1.1),
            spacing: Vec3::new(0.061, 0.11, 0.083),
            begin: UVec3::new(0, 2, 1),
            size: UVec3::new(53, 19, 21),
        };
        let (mut whole, mut parts) = (vec![0.0f32; grid.len()], vec![1.0f32; grid.len()]);
        program.distances(&grid, &mut whole);
        program.distances_pruned(&grid, &mut parts);
        let same = whole.iter().zip(&parts);
        let differing = same.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differing, 0, "{}", case.name);
        pruned += usize::from(program.instructions().len() > 4);
    }
    assert!(pruned > 20, "{pruned}");

    // A grid that reaches beyond the world.
    let mut scene = Scene::new();
    for i in 0..20 {
        let ball = Brush::new(Shape::sphere(3e4)).at([9.4e5 + 1e3 * i as f32, 0.0, 1e3]);
        scene.push(ball).expect("a brush");
    }
    let program = Program::lower(&scene).expect("a program");
    let grid = Grid {
        min: Vec3::new(-9e5, -1e6, -1e6),
        spacing: Vec3::new(1e5, 4e5, 4e5),
        begin: UVec3::ZERO,
        size: UVec3::new(130, 9, 9),
    };
    let (mut whole, mut parts) = (vec![0.0f32; grid.len()], vec![1.0f32; grid.len()]);
    program.distances(&grid, &mut whole);
    program.distances_pruned(&grid, &mut parts);
    assert!(whole.contains(&argil_field::FAR) && whole.iter().any(|&d| d < 1e6));
    assert!(whole == parts);
}
