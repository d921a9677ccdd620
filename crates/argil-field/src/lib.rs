//! The exact field: a scene as a flat program, and its distances, gradients, materials and bounds.
//!
//! *Theory.* A program is a list of instructions over a few registers: the point, an accumulated distance, a stack of
//! each. Brushes combine with the accumulator as the list goes; groups save it, modifiers save the point. CPU and GPU
//! interpret the same program, so that an edit never compiles anything. Where an operand needs more of the stack than
//! what stands before it, it is evaluated first (Sethi and Ullman 1970), so that a tree of n brushes needs log₂ n slots
//! however deep it is. Each scale and each factor by which a deformation stretches space is multiplied into the
//! brushes' own distances, so that the program's distance is in the world's unit and keeps the Lipschitz constant.
//!
//! *Practice.* [`Program::lower`] makes the program. [`Program::distances`] and its siblings evaluate points in batches
//! of [`LANES`], each brush one plain loop over the batch, compiled for AVX-512, AVX2 and the baseline and chosen at run
//! time; no fused multiply-add, so that all give the same bits. `*.wgsl` holds the twins for the GPU, put together by
//! [`OpcodeSet::wgsl`]. [`naive`] is the oracle: scalar, double precision, straight from the scene.
//!
//! [`Pruner`] makes the lists of instructions that can matter in cells of space.
//!
//! A point that is not finite or farther than [`WORLD_LIMIT`] from the origin along an axis is outside of everything:
//! its distance is [`FAR`].
//!
//! ```
//! use argil_field::Program;
//! use argil_scene::{Brush, Scene, Shape};
//! let mut scene = Scene::new();
//! scene.push(Brush::new(Shape::sphere(1.0))).unwrap();
//! let program = Program::lower(&scene)?;
//! assert_eq!(program.distance([3.0, 0.0, 0.0].into()), 2.0);
//! # Ok::<(), argil_field::LowerError>(())
//! ```

mod bounds;
mod combine;
mod curves;
mod dispatch;
mod eval_brush;
mod evaluate;
mod grid;
mod incremental;
mod interpret;
mod interpreter_state;
mod jump_regions;
mod jumps;
mod lower;
mod marks;
mod material_mix;
mod materials;
pub mod naive;
mod near_field;
mod node_map;
mod noise;
mod opcode_set;
mod operands;
mod params;
mod part_grid;
mod pieces;
mod prefetch;
mod program;
mod program_tree;
mod prune;
mod pruned_grid;
mod regularity;
mod sampled;
mod scalar;
mod shapes;
mod space;
mod spans;
mod specialize;

pub use bounds::ClearanceModel;
pub use evaluate::Evaluator;
pub use grid::Grid;
pub use incremental::{Additions, ChangeSet, HardUnionBrush, IncrementalProgram, UpdateOutcome};
pub use jumps::NearJumps;
pub use lower::LowerError;
pub use marks::CELLS_PER_BATCH;
pub use near_field::{NearEvaluator, NearField};
pub use opcode_set::OpcodeSet;
pub use operands::OperandIndex;
pub use part_grid::PartGrid;
pub use program::Program;
pub use program_tree::ProgramTree;
pub use prune::Pruner;
pub use scalar::LANES;

/// The distance of nothing, and of points that are not in the world.
pub const FAR: f32 = argil_abi::FAR;

/// Points farther than this from the origin along an axis are not in the world.
pub const WORLD_LIMIT: f32 = argil_abi::WORLD_LIMIT;

pub(crate) const WGSL_COMMON: &str = concat!(
    include_str!("real.wgsl"),
    include_str!("shapes.wgsl"),
    include_str!("curves.wgsl"),
    include_str!("sampled.wgsl"),
    include_str!("noise.wgsl"),
    include_str!("combine.wgsl"),
    include_str!("space.wgsl"),
);
