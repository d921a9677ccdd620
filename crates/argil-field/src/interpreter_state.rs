//! The state of the interpreter.

use crate::FAR;
use crate::marks::Marks;
use crate::scalar::{Dual, F32Lanes, LANES, Real};
use glam::DVec3;
use std::cell::Cell;
use std::ops::{Deref, DerefMut};
use std::thread::LocalKey;

/// Base color, roughness, emission and metalness of each lane.
pub(crate) type MaterialLanes = [F32Lanes; 12];

/// The state of the interpreter: allocated once, used for many batches.
pub(crate) struct InterpreterState<R: Real> {
    /// The points, which instructions change.
    pub point: [R::Lanes; 3],
    /// What the points are relative to, if that is not the scene's origin.
    pub origin: Option<DVec3>,
    /// From this number of saved points on, the current one is not relative to `origin`: it is in the frame of a solid.
    pub absolute_from: usize,
    /// Lanes in use, rounded up to whole blocks.
    pub active: usize,
    /// The initial value of distances.
    pub start: f32,
    /// Whether a run begins with the distances that are accumulated already.
    pub continues: bool,
    /// The accumulated distances, and the result after a run.
    pub acc: R::Lanes,
    /// The accumulator before a brush, while that is measured by itself.
    pub aside: R::Lanes,
    /// The share of the next morph with a ramp, or room for other shares.
    pub share: R::Lanes,
    /// The accumulated materials: see [`appearance`](crate::materials::MaterialTable::appearance).
    pub material: Box<MaterialLanes>,
    /// The points in the scene, if materials have textures.
    pub at: [F32Lanes; 3],
    pub values: Vec<R::Lanes>,
    pub points: Vec<[R::Lanes; 3]>,
    /// The saved materials, each of as many lanes as there are properties in use.
    pub materials: Vec<F32Lanes>,
    /// How many properties of materials are in use.
    pub properties: usize,
    /// Finished candidates of each open loop.
    pub loops: Vec<u32>,
    pub outside_world: F32Lanes,
    /// Which operand each instruction rules out.
    pub marks: Vec<Marks>,
    /// How much distances can approach each other within a cell.
    pub margin: f32,
}

/// Number types whose state a thread caches.
pub(crate) trait Spare: Real {
    /// Returns the thread's cached state.
    fn spare() -> &'static LocalKey<Cell<Option<Box<InterpreterState<Self>>>>>;
}

macro_rules! spare {
    ($($number:ident),*) => {$(
        impl Spare for $number {
            fn spare() -> &'static LocalKey<Cell<Option<Box<InterpreterState<$number>>>>> {
                thread_local!(static SPARE: Cell<Option<Box<InterpreterState<$number>>>> = const { Cell::new(None) });
                &SPARE
            }
        }
    )*};
}

spare!(f32, Dual);

impl<R: Real> InterpreterState<R> {
    /// Returns what the current points are relative to. Most often, that is nothing.
    #[inline(always)]
    pub(crate) fn current_origin(&self) -> Option<DVec3> {
        self.origin
            .filter(|_| self.points.len() < self.absolute_from)
    }

    pub(crate) fn new() -> Self {
        let zero = || R::splat(0.0);
        Self {
            point: [zero(), zero(), zero()],
            origin: None,
            absolute_from: 0,
            active: LANES,
            start: FAR,
            continues: false,
            acc: zero(),
            aside: zero(),
            share: zero(),
            material: Box::new(std::array::from_fn(|_| f32::splat(0.0))),
            at: std::array::from_fn(|_| f32::splat(0.0)),
            values: Vec::new(),
            points: Vec::new(),
            materials: Vec::new(),
            properties: 0,
            loops: Vec::new(),
            outside_world: f32::splat(0.0),
            marks: Vec::new(),
            margin: 0.0,
        }
    }
}

/// A state on loan: the thread's cached one, or a new one, which becomes the cached one. So a single evaluation
/// allocates nothing.
pub(crate) struct Loan<R: Spare>(Option<Box<InterpreterState<R>>>);

const LOANED: &str = "registers, until they are given back";

impl<R: Spare> std::fmt::Debug for Loan<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Loan").finish_non_exhaustive()
    }
}

impl<R: Spare> Loan<R> {
    pub(crate) fn new() -> Self {
        let spare = R::spare().take();
        Self(Some(
            spare.unwrap_or_else(|| Box::new(InterpreterState::new())),
        ))
    }
}

impl<R: Spare> Deref for Loan<R> {
    type Target = InterpreterState<R>;
    fn deref(&self) -> &InterpreterState<R> {
        self.0.as_ref().expect(LOANED)
    }
}

impl<R: Spare> DerefMut for Loan<R> {
    fn deref_mut(&mut self) -> &mut InterpreterState<R> {
        self.0.as_mut().expect(LOANED)
    }
}

impl<R: Spare> Drop for Loan<R> {
    fn drop(&mut self) {
        let mut state = self.0.take();
        // Do not keep the memory of long lists.
        if let Some(state) = &mut state {
            state.marks = Vec::new();
        }
        // A thread that ends has no cache.
        let _ = R::spare().try_with(|spare| spare.set(state));
    }
}

/// Returns the first `N` words of an instruction's parameters. A program's tables are consistent, so the default is
/// never used.
#[inline(always)]
pub(crate) fn words<const N: usize>(params: &[f32], at: usize) -> &[f32; N] {
    params
        .get(at..at + N)
        .and_then(|w| w.try_into().ok())
        .unwrap_or(&[0.0; N])
}

/// Pushes the accumulator onto the stack, and starts again with an empty one, or with the same one if a group `inherits` it.
#[inline(always)]
pub(crate) fn save_value<R: Real>(r: &mut InterpreterState<R>, materials: bool, inherits: bool) {
    if inherits {
        r.values.push(r.acc.clone());
    } else {
        r.values.push(std::mem::replace(&mut r.acc, R::splat(FAR)));
    }
    if materials {
        r.materials.extend_from_slice(&r.material[..r.properties]);
    }
}

#[inline(always)]
pub(crate) fn restore_point<R: Real>(r: &mut InterpreterState<R>) {
    if let Some(point) = r.points.pop() {
        r.point = point;
    }
    if r.points.len() < r.absolute_from {
        r.absolute_from = usize::MAX;
    }
}

/// Returns the lanes in use, so that the optimizer knows their number.
#[inline(always)]
pub(crate) fn lanes_of(active: usize) -> std::ops::Range<usize> {
    0..active.min(LANES)
}
