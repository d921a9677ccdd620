//! Lists of instructions for the parts of a grid, on a device.

use argil_abi::QueryResult;
use argil_conformance::{
    CaseRng, RandomTables, SceneCase, Wait, all_cases, gpu, points, poison, universal,
};
use argil_field::Program;
use argil_gpu::{Gpu, GpuProgram};
use argil_scene::{Brush, Shape};
use std::sync::Arc;

/// As many points are evaluated by lists.
const MANY: usize = 4096;
/// Points that are also evaluated by the whole program.
const FEW: usize = 1500;
/// A software device evaluates no longer programs.
const MOST_ITERATIONS: u64 = 2800;

/// Returns the number of points where lists give another distance than the whole program, to the bit, or another material.
/// What is left out still rounds a mix of materials.
fn differing(field: &GpuProgram, points: &[[f32; 3]]) -> usize {
    assert!(points.len() >= MANY);
    let by_lists = field.evaluate(points).wait().expect("answers");
    let whole = field.evaluate(&points[..FEW]).wait().expect("answers");
    let is_close = |a: f32, b: f32| (a - b).abs() <= 1e-6;
    let is_equal = |(a, b): &(&QueryResult, QueryResult)| {
        let numbers = |own: &QueryResult| [own.base_roughness, own.emission_metallic].concat();
        a.distance[0].to_bits() == b.distance[0].to_bits()
            && numbers(a)
                .iter()
                .zip(numbers(b))
                .all(|(&a, b)| is_close(a, b))
    };
    let pairs = by_lists.iter().zip(whole);
    pairs.filter(|pair| !is_equal(pair)).count()
}

fn asked(seed: u64) -> Vec<[f32; 3]> {
    let mut all = poison();
    all.extend(points(MANY, seed));
    all
}

/// Returns each row of the tables beside spheres, so that there is something to leave out, and random scenes of nested rows.
fn cases() -> Vec<SceneCase> {
    let mut numbers = CaseRng::new(7);
    let mut cases = all_cases();
    for SceneCase { scene, .. } in &mut cases {
        for _ in 0..8 {
            let ball = Brush::new(Shape::sphere(0.1));
            scene
                .push(ball.at(numbers.point(1.0).to_array()))
                .expect("a brush");
        }
    }
    cases.extend((0..40).map(|seed| SceneCase {
        name: format!("seed {seed}"),
        scene: RandomTables::new(seed).scene(12),
    }));
    cases
}

/// Hardware may fuse products and sums otherwise in another pass.
#[test]
fn lists_have_the_bits_of_the_whole_program() {
    let program = Program::lower(&universal()).expect("a program");
    let as_hardware = Gpu::open().wait().expect("a device").as_hardware();
    let mut fields = [gpu(), Arc::new(as_hardware)]
        .map(|gpu| GpuProgram::new(gpu, &program, false).expect("a field"));
    let mut checked = 0;
    for (nth, SceneCase { name, scene }) in (0..).zip(cases()) {
        // Random numbers may bend what is infinite.
        let Ok(program) = Program::lower(&scene) else {
            continue;
        };
        let field = &mut fields[nth as usize % 2];
        if program.max_iterations() > MOST_ITERATIONS {
            continue;
        }
        checked += 1;
        field.update(&program).expect("a field");
        let differing = differing(field, &asked(nth));
        assert_eq!(differing, 0, "{name}: {nth}");
    }
    assert!(checked > 200, "{checked} cases");
}
