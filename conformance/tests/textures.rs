//! Textures: the GPU's against the CPU's, in the interpreter and in a specialized shader.

use argil_abi::{GpuMaterial, QueryResult};
use argil_conformance::{Wait, gpu};
use argil_field::{Evaluator, Program};
use argil_gpu::GpuProgram;
use argil_scene::{Scene, SceneImage};
use glam::Vec3;
use std::sync::Arc;

/// Six brushes with all patterns, turned, scaled, twisted and blended. `size` is that of all patterns.
fn scene(size: f32) -> Scene {
    let texture = |pattern: &str, space: &str| {
        format!(
            r#"{{"pattern": {{"type": {pattern}}}, "size": {size}, "space": "{space}", "high": "#
        )
    };
    let material = |index: usize, pattern: &str, space: &str| {
        let texture_json = texture(pattern, space);
        format!(
            r#""m{index}": {{"textures": {{"base_color": {texture_json}[0.9, 0.5, 0.2]}}, "roughness": {texture_json}0.7}}, "metallic": {texture_json}1}}, "bump": {texture_json}0.1}}}}}}"#
        )
    };
    let patterns = [
        (r#""checker""#, "brush"),
        (r#""stripes""#, "world"),
        (r#""noise", "octaves": 3"#, "brush"),
        (r#""wood""#, "brush"),
        (r#""marble""#, "world"),
        (r#""brick""#, "brush"),
        (r#""image", "path": "a.png""#, "world"),
        (
            r#""image", "path": "a.png", "mapping": "triplanar""#,
            "brush",
        ),
    ];
    let materials: Vec<String> = patterns
        .iter()
        .enumerate()
        .map(|(index, (pattern, space))| material(index, pattern, space))
        .collect();
    let brushes: Vec<String> = (0..patterns.len())
        .map(|index| {
            let shape = match index % 3 {
                0 => r#"{"type": "box", "half_size": [0.3, 0.25, 0.2]}"#,
                1 => r#"{"type": "sphere", "radius": 0.3}"#,
                _ => r#"{"type": "torus", "major_radius": 0.3, "minor_radius": 0.12}"#,
            };
            let turn = 37 * index;
            let (x, z) = (0.4 * (index % 4) as f32 - 0.6, 0.5 * (index / 4) as f32 - 0.3);
            let twist = if index == 3 {
                r#"{"type": "twist", "degrees_per_unit": 60},"#
            } else {
                ""
            };
            format!(
                r#"{{"shape": {shape}, "material": "m{index}", "blend": 0.08, "modifiers": [{twist}{{"type": "scale", "by": 1.1}},
                {{"type": "rotate", "axis": [1, 2, 0.5], "degrees": {turn}}}, {{"type": "translate", "by": [{x}, 0.05, {z}]}}]}}"#
            )
        })
        .collect();
    let text = format!(
        r#"{{"argil": 1, "materials": {{{}}}, "brushes": [{}]}}"#,
        materials.join(","),
        brushes.join(",")
    );
    let mut scene = Scene::from_json(&text, "textures").unwrap_or_else(|e| panic!("{e}"));
    let image = SceneImage {
        size: [5, 3],
        pixels: (0..15u8)
            .map(|index| [0.9, 0.3, 0.6].map(|c: f32| (c * f32::from(index + 1) * 0.37).fract()))
            .collect(),
    };
    scene.set_image("a.png", &Arc::new(image));
    scene
}

/// Returns points near the surface.
fn points(program: &Program) -> Vec<[f32; 3]> {
    let mut state = 9u64;
    let mut number = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let near = |p: &[f32; 3]| program.distance(Vec3::from(*p)).abs() < 0.05;
    std::iter::repeat_with(|| [0.0; 3].map(|_: f32| 2.4 * number() - 1.2))
        .filter(near)
        .take(2000)
        .collect()
}

fn gap(a: &GpuMaterial, b: &GpuMaterial) -> f32 {
    let all = |m: &GpuMaterial| [m.base_roughness, m.emission_metallic].concat();
    let pairs = all(a).into_iter().zip(all(b));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn material_of(found: &QueryResult) -> GpuMaterial {
    GpuMaterial {
        base_roughness: found.base_roughness,
        emission_metallic: found.emission_metallic,
    }
}

fn of_cpu(program: &Program, points: &[[f32; 3]]) -> Vec<GpuMaterial> {
    let mut evaluator = Evaluator::new(program);
    let one = |p: &[f32; 3]| {
        let (mut d, mut found) = ([0.0], [GpuMaterial::default()]);
        evaluator.materials(&[p[0]], &[p[1]], &[p[2]], &mut d, &mut found);
        found[0]
    };
    points.iter().map(one).collect()
}

/// Bounded: materials agree within rounding, except where a pattern jumps. With patterns of another size, they differ.
#[test]
fn gpu_textures_are_the_cpus() {
    let program = Program::lower(&scene(0.2)).expect("a program");
    let other = Program::lower(&scene(0.21)).expect("a program");
    assert!(program.has_textures());
    let points = points(&program);
    let (plain, turned) = (of_cpu(&program, &points), of_cpu(&other, &points));
    for is_specialized in [false, true] {
        let gpu = GpuProgram::new(gpu(), &program, is_specialized).expect("a program");
        let found = gpu.evaluate(&points).wait().expect("materials");
        let off = |all: &[GpuMaterial], least: f32| {
            let pairs = all.iter().zip(&found);
            pairs
                .filter(|(plain, found)| gap(plain, &material_of(found)) > least)
                .count()
        };
        assert!(
            off(&plain, 0.01) < 20,
            "{is_specialized}: {} of 2000",
            off(&plain, 0.01)
        );
        assert!(off(&turned, 0.01) > 1000, "{}", off(&turned, 0.01));
    }
}
