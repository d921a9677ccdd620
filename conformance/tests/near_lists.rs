//! Lists of instructions for the parts of a grid, on a device.

use argil_abi::QueryResult;
use argil_conformance::{
    RandomTables, SceneCase, Wait, all_cases, gpu, points, poison, side_by_side, universal,
};
use argil_field::Program;
use argil_gpu::{Gpu, GpuProgram, ImageOutput};
use argil_math::Aabb;
use argil_render::{Camera, RenderMode, RenderSettings, frame_uniforms};
use glam::Vec3;
use std::sync::Arc;

const POINTS: usize = 600;
/// A software device evaluates no longer programs.
const MOST_ITERATIONS: u64 = 2800;

/// Makes lists: all images use them.
fn make_lists(field: &GpuProgram, program: &Program) {
    let camera = Camera::orbit(Aabb::centered(Vec3::ONE), [30.0, 20.0, 3.0], 45.0);
    let settings = RenderSettings {
        size: [8, 8],
        mode: RenderMode::Depth,
        ..RenderSettings::default()
    };
    let frames = frame_uniforms(&settings, &camera, program, None, Aabb::centered(Vec3::ONE));
    field
        .render(&frames, ImageOutput::Cpu)
        .wait()
        .expect("a picture");
}

/// Returns the number of points where lists give another distance than the whole program, to the bit, or another material.
/// What is left out still rounds a mix of materials.
fn differing(by_lists: &[QueryResult], whole: &[QueryResult]) -> usize {
    let is_close = |a: f32, b: f32| (a - b).abs() <= 1e-6;
    let is_equal = |(a, b): &(&QueryResult, &QueryResult)| {
        let numbers =
            |result: &QueryResult| [result.base_roughness, result.emission_metallic].concat();
        a.distance[0].to_bits() == b.distance[0].to_bits()
            && numbers(a)
                .iter()
                .zip(numbers(b))
                .all(|(&a, b)| is_close(a, b))
    };
    by_lists
        .iter()
        .zip(whole)
        .filter(|pair| !is_equal(pair))
        .count()
}

/// Returns all rows of the tables, some beside each other, so that there is something to leave out, and random scenes of nested
/// rows.
fn cases() -> Vec<SceneCase> {
    let rows = all_cases();
    let rows = rows.chunks(5).map(|rows| SceneCase {
        name: rows[0].name.clone(),
        scene: side_by_side(rows),
    });
    let random = (0..16).map(|seed| SceneCase {
        name: format!("seed {seed}"),
        scene: RandomTables::new(seed).scene(12),
    });
    rows.chain(random).collect()
}

/// Hardware may fuse products and sums otherwise in another pass.
#[test]
fn lists_have_the_bits_of_the_whole_program() {
    let universal = Program::lower(&universal()).expect("a program");
    let as_hardware = Arc::new(Gpu::open().wait().expect("a device").as_hardware());
    let mut fields = [gpu(), as_hardware].map(|gpu| {
        [0; 2].map(|_| GpuProgram::new(gpu.clone(), &universal, false).expect("a field"))
    });
    let mut checked = 0;
    for (index, SceneCase { name, scene }) in (0..).zip(cases()) {
        // Random numbers may bend what is infinite.
        let Ok(program) = Program::lower(&scene) else {
            continue;
        };
        if program.max_iterations() > MOST_ITERATIONS {
            continue;
        }
        checked += 1;
        let mut asked = poison();
        let mut random = points(POINTS, index);
        for (k, point) in random.iter_mut().enumerate() {
            point[0] += 1.5 * (k % 5) as f32;
        }
        asked.extend(random);
        let fields = &mut fields[index as usize % 2];
        for field in fields.iter_mut() {
            field.update(&program).expect("a field");
        }
        make_lists(&fields[0], &program);
        let [by_lists, whole] = fields
            .each_ref()
            .map(|field| field.evaluate(&asked).wait().expect("answers"));
        let differing = differing(&by_lists, &whole);
        assert_eq!(differing, 0, "{name}: {index}");
    }
    assert!(checked > 40, "{checked} cases");
}
