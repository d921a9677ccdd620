//! What the interpreter works on.

use crate::FAR;
use crate::marks::Marks;
use crate::scalar::{Dual, F32Lanes, LANES, Real};
use std::cell::Cell;
use std::ops::{Deref, DerefMut};
use std::thread::LocalKey;

/// Base color, roughness, emission, metallic of each lane.
pub(crate) type MaterialLanes = [F32Lanes; 8];

/// What the interpreter works on. Allocated once, used for many batches.
pub(crate) struct InterpreterState<R: Real> {
    /// The points, changed along the way.
    pub point: [R::Lanes; 3],
    /// Lanes in use, rounded up to whole blocks: what brushes are measured for.
    pub active: usize,
    /// What distances are accumulated from.
    pub start: f32,
    /// The accumulated distances, and after the run the answer.
    pub acc: R::Lanes,
    /// What was accumulated before a brush, while that is measured on its own.
    pub aside: R::Lanes,
    /// The accumulated materials.
    pub material: Box<MaterialLanes>,
    pub values: Vec<R::Lanes>,
    pub points: Vec<[R::Lanes; 3]>,
    pub materials: Vec<MaterialLanes>,
    /// Candidates done of each open loop.
    pub loops: Vec<u32>,
    pub outside_world: F32Lanes,
    /// Of each instruction: who loses there.
    pub marks: Vec<Marks>,
    /// By how much a distance can come nearer to another within a cell.
    pub margin: f32,
}

/// Numbers whose registers a thread keeps while nobody uses them.
pub(crate) trait Spare: Real {
    /// Registers that nobody on this thread uses at the moment.
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
    pub(crate) fn new() -> Self {
        let zero = || R::splat(0.0);
        Self {
            point: [zero(), zero(), zero()],
            active: LANES,
            start: FAR,
            acc: zero(),
            aside: zero(),
            material: Box::new(std::array::from_fn(|_| f32::splat(0.0))),
            values: Vec::new(),
            points: Vec::new(),
            materials: Vec::new(),
            loops: Vec::new(),
            outside_world: f32::splat(0.0),
            marks: Vec::new(),
            margin: 0.0,
        }
    }
}

/// Registers on loan: a thread's spare ones, or new ones, which become its spare. A single question then allocates nothing.
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
        let mut own = self.0.take();
        // What long lists have left is not kept.
        if let Some(own) = &mut own {
            own.marks = Vec::new();
        }
        // A thread that ends has no spare ones.
        let _ = R::spare().try_with(|spare| spare.set(own));
    }
}

/// The first `N` words at an instruction's parameters. A program's tables agree, so the default is never used.
#[inline(always)]
pub(crate) fn words<const N: usize>(params: &[f32], at: usize) -> &[f32; N] {
    params
        .get(at..at + N)
        .and_then(|w| w.try_into().ok())
        .unwrap_or(&[0.0; N])
}
