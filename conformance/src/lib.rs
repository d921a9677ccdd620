//! Shared parts of the conformance tests: scenes that use every part of the field, points to evaluate, and the GPU.
//!
//! The tests are in `tests/`. They check the contract of each pass on every back end. Next to each comparison, a
//! negative control shows that it can fail.

#![allow(
    clippy::missing_panics_doc,
    reason = "fixtures of tests: a panic fails the test"
)]

mod case;
mod edit_rig;
mod modifier_cases;
mod operator_cases;
mod random_scenes;
mod random_session;
mod random_tables;
mod shape_cases;
mod shared_fields;
mod structure_cases;

use argil_abi::FrameUniform;
use argil_field::Program;
use argil_gpu::{Gpu, GpuProgram};
use argil_math::{Aabb, Ray};
use argil_scene::{Brush, Group, NodeId, Scene, Shape};
use argil_volume::{SampleFormat, Texels, VoxelGrid};
use glam::Vec3;
use std::sync::Arc;

use case::push;
pub use case::{CaseRng, SceneCase};
pub use edit_rig::EditRig;
pub use modifier_cases::modifier_cases;
pub use operator_cases::operator_cases;
pub use random_scenes::random_scene;
pub use random_session::random_session;
pub use random_tables::RandomTables;
pub use shape_cases::{heights, sampled, shape_cases, shapes, vase};
pub use shared_fields::{SharedFields, by_opcodes};
pub use structure_cases::structure_cases;

/// Creates random boxes and capsules, rotated and blended. They lose bricks if bounds are not conservative.
pub fn random_blends(seed: u64, brushes: usize) -> SceneCase {
    let mut numbers = CaseRng::new(seed);
    let mut scene = Scene::new();
    for i in 0..brushes {
        let size = [
            numbers.between(0.03, 0.3),
            numbers.between(0.02, 0.2),
            numbers.between(0.01, 0.2),
        ];
        let shape = match i % 3 {
            0 => Shape::rounded_box(size, 0.3 * size[0].min(size[1]).min(size[2])),
            1 => Shape::capsule([0.0; 3], [size[0], size[0], 0.0], size[2]),
            _ => Shape::torus(size[0], 0.4 * size[0].min(size[1])),
        };
        let axis = numbers.point(1.0).to_array();
        let turned = Brush::new(shape)
            .rotated(axis, numbers.between(0.0, 360.0))
            .at(numbers.point(0.6).to_array())
            .smooth(numbers.between(0.0, 0.15));
        let brush = if i % 5 == 4 {
            turned.subtract()
        } else {
            turned
        };
        push(&mut scene, Scene::ROOT, brush);
    }
    SceneCase {
        name: format!("random blends {seed}"),
        scene,
    }
}

/// Returns the scenes of the repository.
pub fn shipped() -> Vec<SceneCase> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes");
    [
        "brick",
        "csg20",
        "dense-edgy-cubes",
        "dense-spheres",
        "edgy-cube",
        "props",
        "melting",
        "morph",
        "teapot",
        "temple",
        "trees",
    ]
    .into_iter()
    .map(|name| SceneCase {
        name: name.into(),
        scene: Scene::open(format!("{folder}/{name}.json")).expect("a scene"),
    })
    .collect()
}

/// Computes the primary ray of a pixel, independently of the renderer.
pub fn primary_ray(frame: &FrameUniform, x: u32, y: u32) -> Ray {
    let u = (x as f32 + frame.jitter_x) / frame.width as f32 * 2.0 - 1.0;
    let v = 1.0 - (y as f32 + frame.jitter_y) / frame.height as f32 * 2.0;
    let axis = Vec3::from;
    Ray {
        origin: axis(frame.eye),
        direction: (axis(frame.forward) + axis(frame.right) * u + axis(frame.up) * v).normalize(),
    }
}

/// Returns the stored integers of texels.
pub fn stored_integers(texels: &Texels) -> Vec<i32> {
    match texels.bits() {
        SampleFormat::Snorm8 => texels.bytes().iter().map(|&b| i32::from(b as i8)).collect(),
        SampleFormat::Snorm16 => {
            let (pairs, _) = texels.bytes().as_chunks::<2>();
            pairs
                .iter()
                .map(|&b| i32::from(i16::from_le_bytes(b)))
                .collect()
        }
    }
}

/// Returns the voxel grid of a case's volume.
pub fn voxel_grid(scene: &Scene, program: &Program, resolution: u32) -> VoxelGrid {
    let frame = scene
        .view
        .bounds
        .map(|[min, max]| Aabb::new(min.into(), max.into()));
    VoxelGrid::fitting(program.aabb(), frame, resolution).expect("a voxel grid")
}

/// Returns all cases.
pub fn all_cases() -> Vec<SceneCase> {
    [
        shape_cases(),
        operator_cases(),
        modifier_cases(),
        structure_cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Returns one scene with every opcode. A GPU field compiled for it runs every case.
pub fn universal() -> Scene {
    let mut scene = Scene::new();
    for case in all_cases() {
        for &child in case.scene.node(Scene::ROOT).children() {
            copy(&case.scene, child, &mut scene, Scene::ROOT);
        }
    }
    scene
}

/// Returns one scene of some cases, each in a group of its own, beside each other.
pub fn side_by_side(cases: &[SceneCase]) -> Scene {
    let mut scene = Scene::new();
    for (index, case) in (0u8..).zip(cases) {
        let group = Group::new().at([1.5 * f32::from(index), 0.0, 0.0]);
        let group = push(&mut scene, Scene::ROOT, group);
        for &child in case.scene.node(Scene::ROOT).children() {
            copy(&case.scene, child, &mut scene, group);
        }
    }
    scene
}

fn copy(from: &Scene, id: NodeId, to: &mut Scene, group: NodeId) {
    let mut entry = from.node(id).desc().clone();
    entry.material = None;
    let copied = push(to, group, entry);
    for &child in from.node(id).children() {
        copy(from, child, to, copied);
    }
}

/// Returns points in and around the cases, on their planes of symmetry, and with values that break arithmetic.
pub fn points(count: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut numbers = CaseRng::new(seed);
    let mut all: Vec<[f32; 3]> = (0..count)
        .map(|i| numbers.point(if i % 8 == 0 { 6.0 } else { 1.2 }).to_array())
        .collect();
    // Values of thresholds in the code.
    let marks = [
        0.0,
        -0.0,
        0.5,
        -0.5,
        0.35,
        0.6,
        0.7,
        1e-7,
        f32::MIN_POSITIVE,
        f32::from_bits(1),
    ];
    for (i, &x) in marks.iter().enumerate() {
        for (j, &y) in marks.iter().enumerate() {
            all.push([x, y, marks[(i + 3 * j) % marks.len()]]);
        }
    }
    all
}

/// Returns points outside the world.
pub fn poison() -> Vec<[f32; 3]> {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e8, -3e38];
    bad.into_iter()
        .flat_map(|v| [[v, 0.0, 0.0], [0.0, v, 0.1], [0.2, 0.0, v], [v, v, v]])
        .collect()
}

/// Waits for futures of a device.
pub trait Wait: Future + Sized {
    /// Runs the future to its end.
    fn wait(self) -> Self::Output {
        pollster::block_on(self)
    }
}

impl<F: Future> Wait for F {}

/// Returns a bound on rounding errors of a distance at a point: 96 units in the last place of the greatest length
/// involved. A distance takes at most 40 roundings of values of that size, including Newton steps on curves, whose
/// errors shrink quadratically. Twice that allows for both sides.
pub fn rounding(point: [f32; 3]) -> f32 {
    let length = Vec3::from(point).length() + 2.0;
    96.0 * f32::EPSILON * length
}

/// Returns the GPU for tests. There is always one: `cargo xtask test` installs a software device where it can.
pub fn gpu() -> Arc<Gpu> {
    Arc::new(
        Gpu::open()
            .wait()
            .expect("a GPU, or Mesa's lavapipe: `cargo xtask test` says how to get it"),
    )
}

/// Returns a GPU field that runs every case.
pub fn gpu_field() -> GpuProgram {
    let program = Program::lower(&universal()).expect("every case can be lowered");
    GpuProgram::new(gpu(), &program, false).expect("every case fits the GPU")
}
