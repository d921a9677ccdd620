//! The entry points of the interpreter.

use crate::interpreter::{Carried, run};
use crate::interpreter_state::{InterpreterState, Loan};
use crate::scalar::{Dual, F32Lanes, Real, SIMD_BLOCK};
use crate::{FAR, Program};
use argil_abi::{GpuMaterial, Instruction};
use glam::{DVec3, Vec3};
use multiversion::multiversion;
use std::array;

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn run_distances(
    program: &Program,
    instructions: &[Instruction],
    registers: &mut InterpreterState<f32>,
) {
    run::<f32, false>(program, instructions, registers, Carried::Nothing);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn run_gradients(
    program: &Program,
    instructions: &[Instruction],
    registers: &mut InterpreterState<Dual>,
) {
    run::<Dual, false>(program, instructions, registers, Carried::Nothing);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn run_parallel(
    program: &Program,
    instructions: &[Instruction],
    registers: &mut InterpreterState<f32>,
    carried: Carried,
) {
    run::<f32, true>(program, instructions, registers, carried);
}

/// Evaluates a program for one thread, batch after batch. Create one per thread and keep it, because it allocates
/// its stacks once.
///
/// ```
/// use argil_field::{Evaluator, Program};
/// use argil_scene::{Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(1.0))?;
/// let program = Program::lower(&scene)?;
/// let mut evaluator = Evaluator::new(&program);
/// let (x, zero) = ([0.0, 1.0, 3.0], [0.0; 3]);
/// let mut out = [0.0; 3];
/// evaluator.distances(&x, &zero, &zero, &mut out);
/// assert_eq!(out, [-1.0, 0.0, 2.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Evaluator<'a> {
    program: &'a Program,
    plain: Loan<f32>,
    dual: Option<Loan<Dual>>,
    origin: Option<DVec3>,
}

impl<'a> Evaluator<'a> {
    /// Creates an evaluator of a program.
    pub fn new(program: &'a Program) -> Self {
        Self {
            program,
            plain: Loan::new(),
            dual: None,
            origin: None,
        }
    }

    /// Sets what points are relative to from now on, in place of the scene's origin. Distances near such a point are
    /// as precise as they would be at the scene's origin, however far away it is. Noise, and what is repeated, mirrored
    /// or bent in the scene's own space, is only as precise as the scene's coordinates. So is a solid whose own
    /// frame is as far away, such as an oblique plane through the scene's origin. An endless repetition is precise.
    ///
    /// ```
    /// use argil_field::{Evaluator, Program};
    /// use argil_scene::{Scene, Shape};
    /// let mut scene = Scene::new();
    /// scene.push(Shape::sphere(1.0).at([100_000.0, 0.0, 0.0]))?;
    /// let program = Program::lower(&scene)?;
    /// let mut evaluator = Evaluator::new(&program);
    /// evaluator.set_origin(Some([100_000.0, 0.0, 0.0].into()));
    /// let mut out = [0.0];
    /// evaluator.distances(&[1.000_001], &[0.0], &[0.0], &mut out);
    /// assert!((out[0] - 1e-6).abs() < 1e-7);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_origin(&mut self, origin: Option<DVec3>) {
        self.origin = origin;
    }

    /// Returns the program.
    pub fn program(&self) -> &'a Program {
        self.program
    }

    /// Computes the signed distances of the points `(x[i], y[i], z[i])` into `out`, in the scene's unit. At most
    /// [`LANES`](crate::LANES) points.
    ///
    /// # Panics
    /// If the slices differ in length, or are longer than [`LANES`](crate::LANES).
    pub fn distances(&mut self, x: &[f32], y: &[f32], z: &[f32], out: &mut [f32]) {
        self.distances_with(&self.program.instructions, x, y, z, out);
    }

    /// Computes distances with a pruned list of the program's instructions, from [`Pruner`](crate::Pruner).
    ///
    /// # Panics
    /// If the slices differ in length, or are longer than [`LANES`](crate::LANES).
    pub fn distances_with(
        &mut self,
        instructions: &[Instruction],
        x: &[f32],
        y: &[f32],
        z: &[f32],
        out: &mut [f32],
    ) {
        self.distances_from(FAR, instructions, [x, y, z], out);
    }

    /// Computes distances with a pruned list that continues from a constant distance, instead of an empty scene.
    ///
    /// # Panics
    /// If the slices differ in length, or are longer than [`LANES`](crate::LANES).
    pub fn distances_from(
        &mut self,
        start: f32,
        instructions: &[Instruction],
        points: [&[f32]; 3],
        out: &mut [f32],
    ) {
        let n = out.len();
        assert!(points.iter().all(|axis| axis.len() == n), "as many");
        let plain = &mut *self.plain;
        plain.active = n.next_multiple_of(SIMD_BLOCK);
        plain.start = start;
        plain.origin = self.origin;
        for (lanes, from) in plain.point.iter_mut().zip(points) {
            load(lanes, from, plain.active);
        }
        run_distances(self.program, instructions, plain);
        plain.start = FAR;
        out.copy_from_slice(&plain.acc.0[..n]);
    }

    /// Computes distances and their gradients along x, y and z.
    ///
    /// # Panics
    /// If the slices differ in length, or are longer than [`LANES`](crate::LANES).
    pub fn gradients(
        &mut self,
        x: &[f32],
        y: &[f32],
        z: &[f32],
        out: &mut [f32],
        gradients: [&mut [f32]; 3],
    ) {
        self.gradients_with(&self.program.instructions, [x, y, z], out, gradients);
    }

    /// Computes distances and gradients with a pruned list, from [`Pruner`](crate::Pruner).
    ///
    /// # Panics
    /// If the slices differ in length, or are longer than [`LANES`](crate::LANES).
    pub fn gradients_with(
        &mut self,
        instructions: &[Instruction],
        [x, y, z]: [&[f32]; 3],
        out: &mut [f32],
        gradients: [&mut [f32]; 3],
    ) {
        let n = out.len();
        assert!([x, y, z].iter().all(|axis| axis.len() == n), "as many");
        let dual = &mut **self.dual.get_or_insert_with(Loan::new);
        dual.active = n.next_multiple_of(SIMD_BLOCK);
        dual.origin = self.origin;
        for (k, (lanes, from)) in dual.point.iter_mut().zip([x, y, z]).enumerate() {
            load(&mut lanes.0[0], from, dual.active);
            for (along, ones) in (0..3).zip(&mut lanes.0[1..]) {
                ones.0[..dual.active].fill(if along == k { 1.0 } else { 0.0 });
            }
        }
        run_gradients(self.program, instructions, dual);
        out.copy_from_slice(&dual.acc.0[0].0[..n]);
        for (k, gradient) in gradients.into_iter().enumerate() {
            gradient.copy_from_slice(&dual.acc.0[1 + k].0[..n]);
        }
    }

    /// Computes distances and materials.
    ///
    /// # Panics
    /// If the slices differ in length, or are longer than [`LANES`](crate::LANES).
    pub fn materials(
        &mut self,
        x: &[f32],
        y: &[f32],
        z: &[f32],
        out: &mut [f32],
        materials: &mut [GpuMaterial],
    ) {
        self.materials_with(&self.program.instructions, [x, y, z], out, materials);
    }

    /// Computes distances and materials with a pruned list, from [`Pruner`](crate::Pruner).
    ///
    /// # Panics
    /// If the slices differ in length, or are longer than [`LANES`](crate::LANES).
    pub fn materials_with(
        &mut self,
        instructions: &[Instruction],
        [x, y, z]: [&[f32]; 3],
        out: &mut [f32],
        materials: &mut [GpuMaterial],
    ) {
        self.run_materials(instructions, [x, y, z], out);
        let found = &self.plain.material;
        for (i, material) in materials.iter_mut().enumerate() {
            material.base_roughness = array::from_fn(|k| found[k].0[i]);
            material.emission_metallic = array::from_fn(|k| found[4 + k].0[i]);
        }
    }

    /// Computes distances and all properties of materials with a pruned list: base color, roughness, emission, metalness,
    /// transmission, index of refraction, 1 / attenuation distance, and height.
    ///
    /// # Panics
    /// If the slices differ in length, or are longer than [`LANES`](crate::LANES).
    pub fn appearances_with(
        &mut self,
        instructions: &[Instruction],
        points: [&[f32]; 3],
        out: &mut [f32],
        appearances: &mut [[f32; 12]],
    ) {
        self.run_materials(instructions, points, out);
        // What all materials have in common was not carried.
        let common = self.program.materials.appearance(0);
        let (found, carried) = (&self.plain.material, self.plain.properties);
        for (i, appearance) in appearances.iter_mut().enumerate() {
            *appearance = array::from_fn(|k| {
                if k < carried {
                    found[k].0[i]
                } else {
                    common[k]
                }
            });
        }
    }

    fn run_materials(
        &mut self,
        instructions: &[Instruction],
        [x, y, z]: [&[f32]; 3],
        out: &mut [f32],
    ) {
        let n = out.len();
        assert!([x, y, z].iter().all(|axis| axis.len() == n), "as many");
        let plain = &mut *self.plain;
        plain.active = n.next_multiple_of(SIMD_BLOCK);
        for (lanes, from) in plain.point.iter_mut().zip([x, y, z]) {
            load(lanes, from, plain.active);
        }
        plain.origin = self.origin;
        let first = self.program.materials.appearance(0);
        plain.properties = self.program.materials.properties();
        let carried = plain.material.iter_mut().take(plain.properties);
        for (lanes, value) in carried.zip(first) {
            *lanes = f32::splat(value);
        }
        run_parallel(self.program, instructions, plain, Carried::Materials);
        out.copy_from_slice(&plain.acc.0[..n]);
    }
}

/// Loads the lanes in use from a slice. Lanes beyond its end repeat its last value. Other lanes keep earlier
/// values.
#[inline(always)]
fn load(lanes: &mut F32Lanes, from: &[f32], active: usize) {
    let (filled, rest) = lanes.0[..active].split_at_mut(from.len());
    filled.copy_from_slice(from);
    rest.fill(from.last().copied().unwrap_or(0.0));
}

impl Program {
    /// Returns the signed distance at one point. For many points, [`Evaluator`] is a hundred times as fast.
    pub fn distance(&self, point: Vec3) -> f32 {
        let mut out = [0.0];
        Evaluator::new(self).distances(&[point.x], &[point.y], &[point.z], &mut out);
        out[0]
    }

    /// Returns the distance and its gradient at one point.
    pub fn gradient(&self, point: Vec3) -> (f32, Vec3) {
        let (mut d, mut g) = ([0.0], [[0.0]; 3]);
        let [gx, gy, gz] = &mut g;
        Evaluator::new(self).gradients(&[point.x], &[point.y], &[point.z], &mut d, [gx, gy, gz]);
        (d[0], Vec3::new(g[0][0], g[1][0], g[2][0]))
    }
}
