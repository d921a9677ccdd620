//! NanoVDB files: `.nvdb`.
//!
//! The layout is that of NanoVDB 32.4 (`NanoVDB.h`, `util/IO.h` and `util/GridChecksum.h` of
//! <https://github.com/AcademySoftwareFoundation/openvdb>): a header, metadata for each grid, and grids that programs map
//! into memory. Nodes lie level by level, and offsets lead from parents to children.

mod bytes;
mod layout;
mod nodes;
mod read;
mod statistics;
mod write;

pub use read::read;
pub use write::write;

/// The type of a NanoVDB grid's values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NanoType {
    /// 32-bit floats.
    #[default]
    Float,
    /// 16 bits for each value of a leaf, between the leaf's smallest and largest value.
    Fp16,
    /// 8 bits for each value of a leaf, between the leaf's smallest and largest value.
    Fp8,
}
