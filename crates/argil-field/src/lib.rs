#![doc = include_str!("crate.md")]
#![cfg_attr(doc, doc = include_str!("pictures/page.md"))]

mod background;
mod bake_history;
mod bounded_group;
mod bounds;
mod coinciding_copies;
mod column_wgsl;
mod column_words;
mod combine;
mod copy_loops;
mod curves;
mod dispatch;
mod domain_changes;
mod domain_ops;
mod eval_brush;
mod evaluate;
mod grid;
mod hard_unions;
mod incremental;
mod interpreter;
mod interpreter_state;
mod interpreter_wgsl;
mod jump_regions;
mod jumps;
mod lower;
mod marked_materials;
mod marks;
mod material_mix;
mod materials;
pub mod naive;
mod near_field;
mod near_grid;
mod node_map;
mod noise;
mod opcode_set;
mod operands;
mod params;
mod part_grid;
mod pieces;
mod places;
mod prefetch;
mod program;
mod program_tree;
mod prune;
mod pruned_grid;
mod pruned_writer;
mod quartic;
mod ramps;
mod regularity;
mod relative_points;
mod sampled;
mod scalar;
mod shapes;
mod spans;
mod specialize;
mod surface_reach;
mod texture_patterns;
mod textured_brush;
mod textures;

pub use background::in_background;
pub use bake_history::{BakeHistoryError, SampleLattice, bake_history};
pub use bounds::ClearanceModel;
pub use coinciding_copies::CoincidingCopies;
pub use evaluate::Evaluator;
pub use grid::Grid;
pub use incremental::{
    Additions, BrushMotion, ChangeSet, HardBrush, IncrementalProgram, MovedBrush, UpdateOutcome,
};
pub use interpreter_wgsl::Interpreter;
pub use jumps::NearJumps;
pub use lower::LowerError;
pub use marks::{CELLS_PER_BATCH, CellMarks};
pub use near_field::{NearEvaluator, NearField};
pub use opcode_set::OpcodeSet;
pub use operands::OperandIndex;
pub use part_grid::PartGrid;
pub use program::Program;
pub use program_tree::ProgramTree;
pub use prune::Pruner;
pub use scalar::LANES;
pub use surface_reach::SurfaceReach;

/// The distance of an empty scene, and of points outside the world.
pub const FAR: f32 = argil_abi::FAR;

/// Points farther than this from the origin along an axis are outside the world.
pub const WORLD_LIMIT: f32 = argil_abi::WORLD_LIMIT;

pub(crate) const WGSL_COMMON: &str = concat!(
    include_str!("scalar.wgsl"),
    include_str!("shapes.wgsl"),
    include_str!("quartic.wgsl"),
    include_str!("curves.wgsl"),
    include_str!("sampled.wgsl"),
    include_str!("noise.wgsl"),
    include_str!("combine.wgsl"),
    include_str!("domain_ops.wgsl"),
    include_str!("ramps.wgsl"),
);
