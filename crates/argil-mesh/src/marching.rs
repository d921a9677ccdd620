//! Marching cubes (Lorensen and Cline 1987): one vertex an edge of the grid on which the sign changes, shared by all that
//! meet there.

pub mod bricks;
pub mod case_table;
mod cell_loops;
pub mod dense;
mod signs;
pub mod surface;
