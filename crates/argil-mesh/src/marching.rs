//! Marching cubes (Lorensen and Cline 1987): one vertex on each edge of the grid where the sign changes, shared by
//! all triangles that meet there.

pub mod bricks;
pub mod case_table;
mod cell_loops;
pub mod dense;
mod signs;
pub mod surface;
